#include "march.hpp"
#include "events.hpp"
#include "time_stepping.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

namespace flexdyn {

namespace {

using Clock = std::chrono::steady_clock;

// Times closer than this are one instant: k / rate and k * step differ in their last bits.
bool same_instant(double a, double b) { return std::abs(a - b) <= 1e-10 + 1e-13 * std::abs(b); }

class March {
 public:
  March(const Plant& plant, Command& command, const std::vector<ExternalWrench>& external, double duration,
        const SolverSettings& solver, const Output& output, const Poll& poll)
      : plant_(plant), command_(command), external_(external), duration_(duration), output_(output), poll_(poll),
        work_(plant.workspace()), theta_(plant.n()), omega_(plant.n()), tau_ext_(plant.n()), delayed_(plant.has_delay()), late_(plant.n()) {
    work_.smoothing = solver.smoothing;
    if (solver.name == "TimeStepping") {
      stepper_ = make_time_stepping(
          plant, work_, [this](double t) { return torque(t); },
          [this](double t, const double* x) { return wrench_torque(t, x); }, solver.step);
      return;
    }
    if (plant.has_events() && solver.smoothing == 0.0) {
      events_ = std::make_unique<Events>(
          plant, work_, [this](double t) { return torque(t); },
          [this](double t, const double* x) { return wrench_torque(t, x); });
    }
    auto f = [this](double t, const double* x, double* dx) {
      plant_.derivative(work_, t, x, torque(t), wrench_torque(t, x), dx);
    };
    if (solver.name == "RungeKutta4") {
      stepper_ = make_runge_kutta4(f, solver.step);
    } else if (solver.name == "DormandPrince") {
      stepper_ = make_dormand_prince(f, solver.rtol, solver.atol, solver.max_step);
    } else if (solver.name == "Rosenbrock") {
      const ExternalTorque wrench = external.empty() ? ExternalTorque()
                                                     : [this](double t, const double* x) { return wrench_torque(t, x); };
      auto jacobian = [this, wrench](double t, const double* x, double* J) {
        plant_.jacobian(work_, t, x, this->torque(t), wrench, J);
      };
      stepper_ = make_rosenbrock(f, jacobian, solver.rtol, solver.atol, solver.max_step);
    } else {
      throw std::invalid_argument("unknown solver " + solver.name);
    }
  }

  Report run(const std::vector<double>& x0) {
    Report report;
    stepper_->start(0.0, x0);
    while (stepper_->t() < duration_ && report.failure.reason.empty()) {
      begin_interval(false);
      integrate_interval(next_limit(), report.failure);
    }
    if (report.failure.reason.empty()) {
      begin_interval(true);
      while (row_ < output_.count) write(duration_, stepper_->x().data());
    }
    report.stats = stepper_->stats();
    report.events = events_ ? events_->count() : 0;
    report.written = row_;
    report.x = report.failure.reason.empty() ? stepper_->x() : x_finite_;
    return report;
  }

 private:
  double next_limit() const {
    double next = next_command_switch(stepper_->t());
    for (const ExternalWrench& wrench : external_) {
      const PiecewisePolynomial& samples = *wrench.samples;
      if (stepper_->t() >= samples.end()) continue;
      const bool smooth = samples.degree > 1;
      next = std::min(next, smooth ? samples.end() : samples.breaks[samples.segment(stepper_->t()) + 1]);
    }
    return next >= duration_ || same_instant(next, duration_) ? duration_ : next;
  }

  // The command itself switches (its tau is written), and so does what reaches a joint after its delay.
  double next_command_switch(double t) const {
    double next = command_.next_switch(t);
    for (int j = 0; delayed_ && j < plant_.n(); ++j) {
      const double delay = plant_.delay(j);
      double after = command_.next_switch(t - delay) + delay;
      if (after <= t + 1e-12) after = command_.next_switch(t - delay + 1e-9) + delay;
      next = std::min(next, after);
    }
    return next;
  }

  // The torque that reaches the motors.
  const double* torque(double t) {
    if (!delayed_) return command_.at(t);
    for (int j = 0; j < plant_.n(); ++j) {
      const double delay = plant_.delay(j);
      late_[j] = delay > 0.0 ? command_.past(t_inside_ - delay, t - delay, j) : command_.at(t)[j];
    }
    return late_.data();
  }

  void begin_interval(bool final) {
    const std::vector<double>& x = stepper_->x();
    t_begin_ = stepper_->t();
    final_ = final;
    if (command_.needs_state()) plant_.rotor(x.data(), theta_.data(), omega_.data());
    command_.begin(t_begin_, {plant_.q(x.data()), plant_.v(x.data()), theta_.data(), omega_.data()}, final);
    t_inside_ = final ? t_begin_ : 0.5 * (t_begin_ + next_limit());
    stepper_->restart();
    if (events_) events_->settle(t_begin_, x);
  }

  void integrate_interval(double limit, Failure& failure) {
    std::vector<double> at_sample(stepper_->x().size());
    // A sample on the switch itself belongs to the interval that begins there.
    while (sample_before(limit) && same_instant(output_.times[row_], t_begin_)) write(t_begin_, stepper_->x().data());
    while (stepper_->t() < limit) {
      const double t_before = t_finite_ = stepper_->t();
      x_finite_ = stepper_->x();
      if (!stepper_->step(limit, failure)) return;
      for (const double value : stepper_->x()) {
        if (!std::isfinite(value)) {
          failure = {"the motion is not finite", t_finite_};
          return;
        }
      }
      const double t_end = events_ ? events_->find(*stepper_, t_before) : stepper_->t();
      while (sample_before(limit) && (output_.times[row_] < t_end || same_instant(output_.times[row_], t_end))) {
        if (same_instant(output_.times[row_], stepper_->t())) {
          write(stepper_->t(), stepper_->x().data());
          continue;
        }
        stepper_->interpolate(output_.times[row_], at_sample.data());
        write(output_.times[row_], at_sample.data());
      }
      if (events_ && events_->found()) events_->apply(*stepper_, t_end);
      if (events_ && events_->stalled()) {
        failure = {"infinitely many events in finite time", t_end};
        return;
      }
      if (++since_poll_ >= 64) poll_if_due();
    }
  }

  bool sample_before(double limit) const {
    return row_ < output_.count && output_.times[row_] < limit && !same_instant(output_.times[row_], limit);
  }

  void poll_if_due() {
    since_poll_ = 0;
    const auto now = Clock::now();
    if (!poll_ || now - last_poll_ < std::chrono::milliseconds(100)) return;
    last_poll_ = now;
    poll_(stepper_->t());
  }

  const double* wrench_torque(double t, const double* x) {
    if (external_.empty()) return nullptr;
    std::fill(tau_ext_.begin(), tau_ext_.end(), 0.0);
    double value[6];
    for (const ExternalWrench& wrench : external_) {
      const PiecewisePolynomial& samples = *wrench.samples;
      if (t_begin_ < samples.end()) {
        // Held and linear pieces keep to the interval begun last, even at its very end.
        samples.value(samples.segment(samples.degree > 1 ? t : t_begin_), t, value);
      } else if (final_ && same_instant(t_begin_, samples.end())) {
        std::copy(samples.last.begin(), samples.last.end(), value);  // as commands do at the end of the run
      } else {
        continue;
      }
      plant_.links().add_wrench(*work_.links, x, wrench.point, value, tau_ext_.data());
    }
    return tau_ext_.data();
  }

  void write(double t, const double* x) {
    const std::size_t n = static_cast<std::size_t>(plant_.n()), at = row_ * n;
    const double* tau = command_.at(t);
    plant_.torques(work_, t, x, torque(t), wrench_torque(t, x));
    std::copy(plant_.q(x), plant_.q(x) + n, output_.q + at);
    std::copy(plant_.v(x), plant_.v(x) + n, output_.v + at);
    plant_.rotor(x, output_.theta + at, output_.omega + at);
    std::copy(tau, tau + n, output_.tau + at);
    std::copy(work_.tau_applied.begin(), work_.tau_applied.end(), output_.tau_applied + at);
    std::copy(work_.tau_s.begin(), work_.tau_s.end(), output_.tau_s + at);
    ++row_;
  }

  const Plant& plant_;
  Command& command_;
  const std::vector<ExternalWrench>& external_;
  double duration_;
  Output output_;
  const Poll& poll_;
  Plant::Workspace work_;
  std::unique_ptr<Stepper> stepper_;
  std::unique_ptr<Events> events_;
  std::vector<double> theta_, omega_, tau_ext_;
  bool delayed_;
  std::vector<double> late_;
  double t_begin_ = 0.0, t_inside_ = 0.0, t_finite_ = 0.0;
  std::vector<double> x_finite_;  // the last state that was finite: where a failed run stopped
  std::size_t row_ = 0;
  bool final_ = false;
  int since_poll_ = 0;
  Clock::time_point last_poll_ = Clock::now();
};

}  // namespace

Report march(const Plant& plant, Command& command, const std::vector<ExternalWrench>& external,
             const std::vector<double>& x0, double duration, const SolverSettings& solver, const Output& output,
             const Poll& poll) {
  return March(plant, command, external, duration, solver, output, poll).run(x0);
}

}  // namespace flexdyn
