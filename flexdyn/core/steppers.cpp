#include "steppers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace flexdyn {

double EqualSteps::next(double t, double limit) {
  if (limit != limit_) {
    limit_ = limit;
    origin_ = t;
    count_ = std::max(1L, std::lround(std::ceil((limit - t) / step_ - 1e-6)));
    done_ = 0;
    h_ = (limit - t) / static_cast<double>(count_);
  }
  ++done_;
  return done_ == count_ ? limit_ : origin_ + h_ * static_cast<double>(done_);
}

StepPlan plan_step(double wanted, double left) {
  if (wanted >= left * (1.0 - 1e-10)) return {left, true};
  return {wanted > 0.5 * left ? 0.5 * left : wanted, false};
}

bool StepPlan::vanishes(double t) const {
  return !last && h <= 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), 1e-300);
}

}  // namespace flexdyn
