#include "drive.hpp"

#include <algorithm>
#include <cmath>

namespace flexdyn {

bool same_instant(double a, double b) { return std::abs(a - b) <= 1e-10 + 1e-13 * std::abs(b); }

Drive::Drive(const Plant& plant, Command& command, const std::vector<ExternalWrench>& wrenches, double duration)
    : plant_(plant), command_(command), wrenches_(wrenches), duration_(duration), delayed_(plant.has_delay()),
      links_(wrenches.empty() ? nullptr : plant.links().workspace()), theta_(plant.n()), omega_(plant.n()),
      tau_ext_(plant.n()), late_(plant.n()) {}

double Drive::next_limit(double t) const {
  double next = next_command_switch(t);
  for (const ExternalWrench& wrench : wrenches_) {
    const PiecewisePolynomial& samples = *wrench.samples;
    if (t >= samples.end()) continue;
    next = std::min(next, samples.degree > 1 ? samples.end() : samples.breaks[samples.segment(t) + 1]);
  }
  return next >= duration_ || same_instant(next, duration_) ? duration_ : next;
}

// The command itself switches (its tau is written), and so does what reaches a joint after its delay.
double Drive::next_command_switch(double t) const {
  double next = command_.next_switch(t);
  for (int j = 0; delayed_ && j < plant_.n(); ++j) {
    const double delay = plant_.delay(j);
    double after = command_.next_switch(t - delay) + delay;
    if (after <= t + 1e-12) after = command_.next_switch(t - delay + 1e-9) + delay;
    next = std::min(next, after);
  }
  return next;
}

void Drive::begin(double t, const std::vector<double>& x, bool final) {
  t_begin_ = t;
  final_ = final;
  if (command_.needs_state()) plant_.rotor(x.data(), theta_.data(), omega_.data());
  command_.begin(t, {plant_.q(x.data()), plant_.v(x.data()), theta_.data(), omega_.data()}, final);
  t_inside_ = final ? t : 0.5 * (t + next_limit(t));
}

bool Drive::constant() const {
  return command_.constant() && std::all_of(wrenches_.begin(), wrenches_.end(), [this](const ExternalWrench& wrench) {
           return wrench.samples->degree == 0 || t_begin_ >= wrench.samples->end();
         });
}

const double* Drive::torque(double t) {
  if (!delayed_) return command_.at(t);
  for (int j = 0; j < plant_.n(); ++j) {
    const double delay = plant_.delay(j);
    late_[j] = delay > 0.0 ? command_.past(t_inside_ - delay, t - delay, j) : command_.at(t)[j];
  }
  return late_.data();
}

const double* Drive::external(double t, const double* x) {
  if (wrenches_.empty()) return nullptr;
  std::fill(tau_ext_.begin(), tau_ext_.end(), 0.0);
  double value[6];
  for (const ExternalWrench& wrench : wrenches_) {
    const PiecewisePolynomial& samples = *wrench.samples;
    if (t_begin_ < samples.end()) {
      // Held and linear pieces keep to the interval begun last, even at its very end.
      samples.value(samples.segment(samples.degree > 1 ? t : t_begin_), t, value);
    } else if (final_ && same_instant(t_begin_, samples.end())) {
      std::copy(samples.last.begin(), samples.last.end(), value);  // as commands do at the end of the run
    } else {
      continue;
    }
    plant_.links().add_wrench(*links_, x, wrench.point, value, tau_ext_.data());
  }
  return tau_ext_.data();
}

}  // namespace flexdyn
