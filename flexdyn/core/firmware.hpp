// The position controller in a servo's firmware: counts of its encoder to counts of its PWM, at a control rate.
#pragma once

#include <vector>

#include "commands.hpp"

namespace flexdyn {

// Of one joint; see flexdyn/control/firmware.py for what each number means.
struct FirmwareSettings {
  double kp, ki, kd, counts_per_turn, full_pwm, pwm_limit, dead_band, rate;
};

// One servo during a run: it remembers its sum and its last error.
class Firmware {
 public:
  explicit Firmware(const FirmwareSettings& settings) : set_(settings) {}
  // Duty [1] at the next tick, of a goal and a position [rad].
  double duty(double goal, double position);

 private:
  FirmwareSettings set_;
  double sum_ = 0.0, before_ = 0.0;
  bool first_ = true;
};

// Servos of all joints: each duty as the torque of that voltage at standstill, late by some ticks.
class FirmwareServo : public Sampled {
 public:
  // goals (ticks, n); full (n): torque of a duty of 1.
  FirmwareServo(std::vector<double> goals, const std::vector<FirmwareSettings>& settings, std::vector<double> full,
                int delay, bool feedback_theta);

 private:
  void compute(double t, const JointState& state) override;
  std::vector<double> goals_, full_;
  std::vector<Firmware> servos_;
  std::vector<std::vector<double>> asked_;  // of the ticks so far
  int delay_;
  bool feedback_theta_;
};

}  // namespace flexdyn
