#include "stiffness.hpp"

#include <algorithm>
#include <limits>

#include <Eigen/Eigenvalues>

namespace flexdyn {

double fastest_rate(const Plant& plant, Plant::Workspace& work, double t, const double* x, const double* tau) {
  const int size = plant.state_size();
  MatrixXd J(size, size);  // its transpose has the same eigenvalues
  work.located = false;
  work.smoothing = std::numeric_limits<double>::infinity();  // so wide that dry friction has no slope
  plant.jacobian(work, t, x, tau, nullptr, J.data());
  return J.allFinite() ? J.eigenvalues().cwiseAbs().maxCoeff() : 0.0;
}

// An explicit method of order 5 is stable up to about 3.3/rate. Steps longer than that at the limiting rate are no
// question; shorter ones may also come of events, switches or accuracy, which the eigenvalues tell apart. They cost as
// much as some twenty steps, so that they are asked less and less often where the answer was no.
bool StiffnessWatch::stiff(double t, const double* x, const double* tau) {
  constexpr double stable = 3.3;
  constexpr long seldom = 4096;
  if (++steps_ < every_) return false;
  const bool short_steps = (t - t_looked_) * limit_ < stable * static_cast<double>(steps_);
  steps_ = 0;
  t_looked_ = t;
  if (!short_steps) return false;
  every_ = std::min(2 * every_, seldom);
  return fastest_rate(plant_, work_, t, x, tau) > limit_;
}

}  // namespace flexdyn
