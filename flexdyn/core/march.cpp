#include "march.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "events.hpp"
#include "ledger.hpp"
#include "time_stepping.hpp"

namespace flexdyn {

namespace {

using Clock = std::chrono::steady_clock;

class March {
 public:
  March(const Plant& plant, Command& command, const std::vector<ExternalWrench>& external, double duration,
        const SolverSettings& solver, const Output& output, const Poll& poll)
      : plant_(plant), drive_(plant, command, external, duration), duration_(duration), output_(output), poll_(poll),
        work_(plant.workspace()), most_(solver.most) {
    work_.smoothing = solver.smoothing;
    const Events::Torque torque = [this](double t) { return drive_.torque(t); };
    const Events::External wrench = [this](double t, const double* x) { return drive_.external(t, x); };
    if (output.ledger != nullptr) ledger_ = std::make_unique<Ledger>(plant, work_, drive_);
    if (solver.name == "TimeStepping") {
      stepper_ = make_time_stepping(plant, work_, torque, wrench, solver.step);
      // What a rigid joint's gear carries depends on how its contact moves at the sample itself, not over the step.
      const bool rigid = plant.elastic() < plant.n();
      if (rigid && plant.has_dry_friction()) at_samples_ = std::make_unique<Events>(plant, work_, torque, wrench);
      return;
    }
    if (plant.has_events() && solver.smoothing == 0.0) events_ = std::make_unique<Events>(plant, work_, torque, wrench);
    const RightHandSide f = [this](double t, const double* x, double* dx) {
      plant_.derivative(work_, t, x, drive_.torque(t), drive_.external(t, x), dx);
    };
    if (solver.name == "RungeKutta4") {
      stepper_ = make_runge_kutta4(f, solver.step);
    } else if (solver.name == "DormandPrince") {
      stepper_ = make_dormand_prince(f, solver.rtol, solver.atol, solver.max_step);
    } else if (solver.name == "Rosenbrock") {
      const ExternalTorque moving = external.empty() ? ExternalTorque() : ExternalTorque(wrench);
      const Jacobian jacobian = [this, moving](double t, const double* x, double* J) {
        plant_.jacobian(work_, t, x, drive_.torque(t), moving, J);
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
      integrate_interval(drive_.next_limit(stepper_->t()), report.failure);
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
  void begin_interval(bool final) {
    drive_.begin(stepper_->t(), stepper_->x(), final);
    stepper_->restart();
    if (!events_) return;
    events_->settle(stepper_->t(), stepper_->x());
    stepper_->keep_stable(events_->quiet_step());
  }

  void integrate_interval(double limit, Failure& failure) {
    // A sample on the switch itself belongs to the interval that begins there.
    while (sample_before(limit) && same_instant(output_.times[row_], drive_.t_begin())) {
      write(drive_.t_begin(), stepper_->x().data());
    }
    if (events_ && drive_.constant() && events_->at_rest(stepper_->t(), stepper_->x())) return stand_still(limit);
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
      write_samples(limit, t_end);
      if (ledger_) ledger_->advance(*stepper_, t_end);
      if (events_ && events_->found()) events_->apply(*stepper_, t_end);
      if (events_ && events_->stalled()) {
        failure = {"infinitely many events in finite time", t_end};
        return;
      }
      if (most_ > 0 && stepper_->stats().evaluations > most_) {
        failure = {"more evaluations than allowed", t_end};
        return;
      }
      if (++since_poll_ >= 64) poll_if_due();
    }
  }

  void stand_still(double limit) {
    const std::vector<double> x = stepper_->x();
    while (sample_before(limit)) write(output_.times[row_], x.data());
    if (ledger_) ledger_->skip(limit);
    stepper_->truncate(limit, x);
  }

  // Samples of the step just taken, up to the event that ends it.
  void write_samples(double limit, double t_end) {
    std::vector<double>& x = at_sample_;
    x.resize(stepper_->x().size());
    while (sample_before(limit) && (output_.times[row_] < t_end || same_instant(output_.times[row_], t_end))) {
      if (same_instant(output_.times[row_], stepper_->t())) {
        if (ledger_) ledger_->advance(*stepper_, stepper_->t());
        write(stepper_->t(), stepper_->x().data());
        continue;
      }
      if (ledger_) ledger_->advance(*stepper_, output_.times[row_]);
      stepper_->interpolate(output_.times[row_], x.data());
      write(output_.times[row_], x.data());
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

  void write(double t, const double* x) {
    const std::size_t n = static_cast<std::size_t>(plant_.n()), at = row_ * n;
    const double* tau = drive_.asked(t);
    if (at_samples_) at_samples_->settle(t, std::vector<double>(x, x + plant_.state_size()));
    plant_.torques(work_, t, x, drive_.torque(t), drive_.external(t, x));
    std::copy(plant_.q(x), plant_.q(x) + n, output_.q + at);
    std::copy(plant_.v(x), plant_.v(x) + n, output_.v + at);
    plant_.rotor(x, output_.theta + at, output_.omega + at);
    std::copy(tau, tau + n, output_.tau + at);
    std::copy(work_.tau_applied.begin(), work_.tau_applied.end(), output_.tau_applied + at);
    std::copy(work_.tau_s.begin(), work_.tau_s.end(), output_.tau_s + at);
    const auto internal = static_cast<std::size_t>(plant_.internal_states());
    std::copy(plant_.z(x), plant_.z(x) + internal, output_.z + row_ * internal);
    if (ledger_) {
      std::copy(ledger_->sums().begin(), ledger_->sums().end(), output_.ledger + row_ * ledger_->sums().size());
    }
    ++row_;
  }

  const Plant& plant_;
  Drive drive_;
  double duration_;
  Output output_;
  const Poll& poll_;
  Plant::Workspace work_;
  long most_;
  std::unique_ptr<Stepper> stepper_;
  std::unique_ptr<Events> events_, at_samples_;
  std::unique_ptr<Ledger> ledger_;
  std::vector<double> at_sample_;
  std::vector<double> x_finite_;  // the last state that was finite: where a failed run stopped
  double t_finite_ = 0.0;
  std::size_t row_ = 0;
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
