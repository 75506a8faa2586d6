// What drives the arm: torques over time (open loop), joint tracking at a control rate, a law in Python.
//
// The march goes from one switch of the command to the next and tells it at each (`begin`); in between the
// command is smooth in t and may be asked anywhere (`at`).
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "signals.hpp"

namespace flexdyn {

// All joints at one instant, rotor columns filled for rigid joints too.
struct JointState {
  const double* q;
  const double* v;
  const double* theta;
  const double* omega;
};

class Command {
 public:
  virtual ~Command() = default;
  // First instant after t where the command may jump or bend.
  virtual double next_switch(double t) const = 0;
  virtual bool needs_state() const { return false; }
  // Whether tau does not change within the interval begun last.
  virtual bool constant() const = 0;
  // A new interval starts at t; `final` if the run ends here and only the torque asked now is wanted.
  virtual void begin(double t, const JointState& state, bool final) = 0;
  // tau (n) at t within the interval begun last.
  virtual const double* at(double t) = 0;
  // tau of one joint at an earlier t, on the piece that holds `inside` (a point of the present interval, as early).
  virtual double past(double inside, double t, int joint) const = 0;
};

// Zero torque; open-loop samples are zero after their end.
class OpenLoop : public Command {
 public:
  OpenLoop(std::shared_ptr<const PiecewisePolynomial> samples, int n);
  double next_switch(double t) const override;
  bool constant() const override { return !samples_ || over_ || samples_->degree == 0; }
  void begin(double t, const JointState&, bool final) override;
  const double* at(double t) override;
  double past(double inside, double t, int joint) const override;

 private:
  std::shared_ptr<const PiecewisePolynomial> samples_;  // null: no torque
  std::vector<double> tau_;
  int segment_ = 0;
  bool over_ = false;
};

// Base of the two commands that compute a torque at a control rate and hold it.
class Sampled : public Command {
 public:
  Sampled(double rate, int n) : rate_(rate), tau_(n, 0.0) {}
  double next_switch(double t) const override;
  bool needs_state() const override { return true; }
  bool constant() const override { return true; }
  const double* at(double) override { return tau_.data(); }
  void begin(double t, const JointState& state, bool final) override;
  double past(double inside, double t, int joint) const override;
  // Torques at the ticks so far, (ticks, n): what a delay line or a replay needs.
  const std::vector<double>& tick_times() const { return times_; }
  const std::vector<double>& tick_torques() const { return torques_; }

 protected:
  virtual void compute(double t, const JointState& state) = 0;
  double rate_;
  std::vector<double> tau_;

 private:
  std::vector<double> times_, torques_;
};

// tau = feedforward(t) + kp (reference - y) + kd (reference' - y'), y = theta or q.
struct TrackingGains {
  std::vector<double> kp, kd;
  bool feedback_theta;
};

class Tracking : public Sampled {
 public:
  Tracking(std::shared_ptr<const PiecewisePolynomial> reference, std::shared_ptr<const PiecewisePolynomial> feedforward,
           TrackingGains gains, double rate, int n);

 private:
  void compute(double t, const JointState& state) override;
  std::shared_ptr<const PiecewisePolynomial> reference_, feedforward_;
  TrackingGains gains_;
  std::vector<double> position_, velocity_;
};

using ControlLaw = std::function<void(double t, const JointState& state, double* tau)>;

class Callback : public Sampled {
 public:
  Callback(ControlLaw law, double rate, int n) : Sampled(rate, n), law_(std::move(law)) {}

 private:
  void compute(double t, const JointState& state) override { law_(t, state, tau_.data()); }
  ControlLaw law_;
};

// A command is made anew for every run: it carries the torque of the moment.
struct CommandFactory {
  std::function<std::unique_ptr<Command>(int n)> make;
};

}  // namespace flexdyn
