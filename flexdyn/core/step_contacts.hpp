// Dry contacts over one step of TimeStepping: which stick and which slide.
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

#include "matrices.hpp"
#include "plant.hpp"
#include "ties.hpp"

namespace flexdyn {

class StepContacts {
 public:
  explicit StepContacts(const Plant& plant)
      : plant_(plant), N_(plant.velocities()), every_(plant.contacts().size()),
        motion_(plant.contacts().size(), stuck) {
    std::iota(every_.begin(), every_.end(), std::size_t{0});
  }

  // Impulse that every contact can hold over a step of length h: for sliding on, and for turning round from rest.
  void levels(Plant::Workspace& work, double t, const std::vector<double>& state, double h);
  // Velocities w (N) with A w + lambda = b, each impulse lambda in its contact's box.
  VectorXd boxed_solve(const MatrixXd& A, const VectorXd& b);

 private:
  void solve(const MatrixXd& A, const VectorXd& b);
  void solve_apart(const MatrixXd& A, const VectorXd& rest, const std::vector<char>& held);
  void solve_tied(const MatrixXd& A, const VectorXd& rest, const std::vector<char>& held,
                  const std::vector<Tie>& ties);
  int place(const DryContact& contact) const { return static_cast<int>(plant_.velocity_index(contact)) - N_; }
  int other_place(const DryContact& contact) const { return static_cast<int>(plant_.other_index(contact)) - N_; }
  // What a contact can hold over the step.
  Box box_of(std::size_t contact) const { return {level_[2 * contact], level_[2 * contact + 1]}; }
  Box box_at(int velocity) const;

  const Plant& plant_;
  int N_;
  std::vector<std::size_t> every_;  // contact
  std::vector<int> motion_;         // of each contact in the last step
  std::vector<double> level_;       // of each contact: backward, forward
  std::vector<double> load_;        // of each stuck contact, as an impulse
  std::vector<double> state_;       // as the plant has it, of which only the velocities are used
};

}  // namespace flexdyn
