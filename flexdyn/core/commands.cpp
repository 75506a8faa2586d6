#include "commands.hpp"

#include <algorithm>
#include <cmath>

namespace flexdyn {

namespace {
constexpr double never = std::numeric_limits<double>::infinity();
}

OpenLoop::OpenLoop(std::shared_ptr<const PiecewisePolynomial> samples, int n)
    : samples_(std::move(samples)), tau_(n, 0.0) {}

double OpenLoop::next_switch(double t) const {
  if (!samples_ || t >= samples_->end()) return never;
  if (t < samples_->breaks.front()) return samples_->breaks.front();  // asked of a delayed command
  // A cubic spline is smooth across its knots; only its end is a jump (to zero torque).
  if (samples_->degree > 1) return samples_->end();
  return samples_->breaks[samples_->segment(t) + 1];
}

void OpenLoop::begin(double t, const JointState&, bool final) {
  if (!samples_) return;
  over_ = t >= samples_->end();
  segment_ = samples_->segment(t);
  if (over_) {
    // The last sample is what is asked at the end itself; whatever comes after it gets no torque.
    const bool ask_last = final && t == samples_->end();
    for (std::size_t i = 0; i < tau_.size(); ++i) tau_[i] = ask_last ? samples_->last[i] : 0.0;
  } else {
    samples_->value(segment_, t, tau_.data());
  }
}

const double* OpenLoop::at(double t) {
  if (samples_ && !over_ && samples_->degree > 0) {
    if (samples_->degree > 1) segment_ = samples_->segment(t);
    samples_->value(segment_, t, tau_.data());
  }
  return tau_.data();
}

double OpenLoop::past(double inside, double t, int joint) const {
  if (!samples_ || inside < 0.0 || inside >= samples_->end()) return 0.0;
  std::vector<double> tau(tau_.size());
  samples_->value(samples_->segment(samples_->degree > 1 ? t : inside), t, tau.data());
  return tau[joint];
}

// Called at every switch in the run, not only at ticks: the torque is computed anew at ticks alone.
void Sampled::begin(double t, const JointState& state, bool) {
  const bool tick = times_.empty() || t >= (std::floor(times_.back() * rate_ + 1e-6) + 1.0) / rate_ - 1e-12;
  if (!tick) return;
  compute(t, state);
  times_.push_back(t);
  torques_.insert(torques_.end(), tau_.begin(), tau_.end());
}

double Sampled::past(double inside, double, int joint) const {
  const auto after = std::upper_bound(times_.begin(), times_.end(), inside);
  if (after == times_.begin()) return 0.0;
  const auto row = static_cast<std::size_t>(after - times_.begin()) - 1;
  return torques_[row * tau_.size() + static_cast<std::size_t>(joint)];
}

double Sampled::next_switch(double t) const {
  // Ticks stand at k / rate; the tolerance keeps a tick that t already stands on from coming twice.
  return (std::floor(t * rate_ + 1e-6) + 1.0) / rate_;
}

Tracking::Tracking(std::shared_ptr<const PiecewisePolynomial> reference,
                   std::shared_ptr<const PiecewisePolynomial> feedforward, TrackingGains gains, double rate, int n)
    : Sampled(rate, n), reference_(std::move(reference)), feedforward_(std::move(feedforward)),
      gains_(std::move(gains)), position_(n), velocity_(n) {}

void Tracking::compute(double t, const JointState& state) {
  const int n = static_cast<int>(tau_.size());
  const int segment = reference_->segment(t);
  if (t < reference_->end()) {
    reference_->value(segment, t, position_.data());
  } else {
    position_ = reference_->last;  // from its end on the reference stands still
  }
  if (t > reference_->end()) {
    std::fill(velocity_.begin(), velocity_.end(), 0.0);
  } else {
    reference_->derivative(segment, t, velocity_.data());
  }
  std::fill(tau_.begin(), tau_.end(), 0.0);
  if (feedforward_ && t < feedforward_->end()) feedforward_->value(feedforward_->segment(t), t, tau_.data());
  const double* y = gains_.feedback_theta ? state.theta : state.q;
  const double* rate = gains_.feedback_theta ? state.omega : state.v;
  for (int j = 0; j < n; ++j) {
    tau_[j] += gains_.kp[j] * (position_[j] - y[j]) + gains_.kd[j] * (velocity_[j] - rate[j]);
  }
}

}  // namespace flexdyn
