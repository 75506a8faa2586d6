#include "firmware.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace flexdyn {

double Firmware::duty(double goal, double position) {
  const double counts = set_.counts_per_turn / 6.283185307179586476925;
  double error = std::nearbyint(goal * counts) - std::nearbyint(position * counts);
  if (std::abs(error) <= set_.dead_band) error = 0.0;
  const double rise = first_ ? 0.0 : (error - before_) * set_.rate;
  before_ = error;
  first_ = false;
  const double sum = sum_ + error / set_.rate;
  double pwm = set_.kp * error + set_.ki * sum + set_.kd * rise;
  if (std::abs(pwm) > set_.pwm_limit) {
    pwm = std::copysign(set_.pwm_limit, pwm);  // the sum stands still
  } else {
    sum_ = sum;
  }
  return std::trunc(pwm) / set_.full_pwm;
}

FirmwareServo::FirmwareServo(std::vector<double> goals, const std::vector<FirmwareSettings>& settings,
                             std::vector<double> full, int delay, bool feedback_theta)
    : Sampled(settings.front().rate, static_cast<int>(full.size())), goals_(std::move(goals)), full_(std::move(full)),
      servos_(settings.begin(), settings.end()), delay_(delay), feedback_theta_(feedback_theta) {}

void FirmwareServo::compute(double t, const JointState& state) {
  const std::size_t n = full_.size(), rows = goals_.size() / n;
  const std::size_t row = std::min(static_cast<std::size_t>(std::llround(t * rate_)), rows - 1);
  const double* position = feedback_theta_ ? state.theta : state.q;
  std::vector<double> torque(n);
  for (std::size_t j = 0; j < n; ++j) torque[j] = full_[j] * servos_[j].duty(goals_[row * n + j], position[j]);
  asked_.push_back(std::move(torque));
  const int arrives = static_cast<int>(asked_.size()) - 1 - delay_;
  if (arrives >= 0) {
    tau_ = asked_[static_cast<std::size_t>(arrives)];
  } else {
    std::fill(tau_.begin(), tau_.end(), 0.0);
  }
}

}  // namespace flexdyn
