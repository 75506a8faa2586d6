// Which dry contacts stick and which slide: the pivoting that is the same at an event and over a step.
#pragma once

#include <algorithm>

#include "plant.hpp"

namespace flexdyn {

// A boxed linear complementarity problem by Bard's pivoting with the least-index rule, finite for a positive definite
// inertia: the first contact that contradicts itself goes on otherwise, until none contradicts itself.
//
//   contacts       indices of those that may change, in ascending order
//   motion         of every contact, in and out
//   solve()        what happens while every contact goes on as its motion says; the others ask for its numbers
//   speed(c)       velocity of a sliding contact, or what it becomes from rest
//   breaks_away(c) motion of a stuck contact under its load: `stuck` if it can hold it
//   flip(c)        give it the other motion
template <class Contacts, class Solve, class Speed, class BreaksAway, class Flip>
void settle_by_pivoting(const Plant& plant, const Contacts& contacts, const std::vector<int>& motion,
                        const Solve& solve, const Speed& speed, const BreaksAway& breaks_away, const Flip& flip) {
  constexpr int most = 1000;
  // Taken to slide and held by others that stick and a coupling: these have to give way first.
  const auto pinned = [&](std::size_t c) {
    return plant.has_couplings() && motion[c] != stuck && speed(c) == 0.0;
  };
  // Stuck under more than it can hold, or sliding into rest.
  const auto contradicts = [&](std::size_t c) {
    if (motion[c] == stuck) return breaks_away(c) != stuck;
    return motion[c] * speed(c) <= 0.0 && !pinned(c);
  };
  for (int pivot = 0; pivot < most; ++pivot) {
    solve();
    auto wrong = std::find_if(contacts.begin(), contacts.end(), contradicts);
    if (wrong == contacts.end()) wrong = std::find_if(contacts.begin(), contacts.end(), pinned);
    if (wrong == contacts.end()) return;
    flip(*wrong);
  }
}

}  // namespace flexdyn
