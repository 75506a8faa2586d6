// How fast the fastest motion at a point is, and when a run should no longer follow it step by step.
#pragma once

#include "plant.hpp"

namespace flexdyn {

// The largest eigenvalue, by size, of the motion linearised at a point [1/s]; dry friction takes no part. 0: slopes are
// not finite. The workspace is the caller's to lose.
double fastest_rate(const Plant& plant, Plant::Workspace& work, double t, const double* x, const double* tau);

// Looks now and then whether short steps of an explicit method are a matter of stiffness.
class StiffnessWatch {
 public:
  // limit: rate beyond which an implicit method takes over [1/s].
  StiffnessWatch(const Plant& plant, double limit) : plant_(plant), work_(plant.workspace()), limit_(limit) {}

  // After every step that was taken; true once the motion at its end is faster than the limit.
  bool stiff(double t, const double* x, const double* tau);

 private:
  const Plant& plant_;
  Plant::Workspace work_;
  double limit_, t_looked_ = 0.0;
  long steps_ = 0, every_ = 128;
};

}  // namespace flexdyn
