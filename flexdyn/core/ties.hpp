// Dry couplings that stick: two velocities that move as one.
#pragma once

#include <cstddef>
#include <vector>

#include "matrices.hpp"

namespace flexdyn {

// w[one] = ratio w[other].
struct Tie {
  int one, other;
  double ratio;
  std::size_t contact;
};

// What a contact can hold: its friction lies in [-below, above].
struct Box {
  double below = 0.0, above = 0.0;
};

// The moves (N, free) that held velocities and ties leave, w = T y. No velocity is in two ties.
MatrixXd free_moves(const std::vector<char>& held, const std::vector<Tie>& ties);

// Friction of a tie out of what holds both velocities in all, of which it takes its share away. Where both are held by
// contacts of their own as well, the share is free within the three boxes: the middle of what all of them allow.
double take_share(const Tie& tie, const std::vector<char>& held, const Box& own, const Box& of_one, const Box& of_other,
                  double& on_one, double& on_other);

}  // namespace flexdyn
