#include "march.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "events.hpp"
#include "ledger.hpp"
#include "stiffness.hpp"
#include "time_stepping.hpp"

namespace flexdyn {

namespace {

using Clock = std::chrono::steady_clock;

class March {
 public:
  March(const Plant& plant, Command& command, const std::vector<ExternalWrench>& external, double duration,
        const SolverSettings& solver, const Output& output, const Poll& poll)
      : plant_(plant), drive_(plant, command, external, duration), duration_(duration), output_(output), poll_(poll),
        work_(plant.workspace()), solver_(solver) {
    work_.smoothing = solver.smoothing;
    const Events::Torque torque = [this](double t) { return drive_.torque(t); };
    const Events::External wrench = [this](double t, const double* x) { return drive_.external(t, x); };
    if (!external.empty()) moving_ = wrench;
    if (output.ledger != nullptr) ledger_ = std::make_unique<Ledger>(plant, work_, drive_);
    if (solver.name == "TimeStepping") {
      stepper_ = make_time_stepping(plant, work_, torque, wrench, solver.step);
      pieces_at_samples_ = plant.switches() > 0;
      // What a rigid joint's gear carries depends on how its contact moves at the sample itself, not over the step.
      const bool rigid = plant.elastic() < plant.n();
      if (rigid && plant.has_dry_friction()) at_samples_ = std::make_unique<Events>(plant, work_, torque, wrench);
      return;
    }
    if (plant.has_events() && solver.smoothing == 0.0) events_ = std::make_unique<Events>(plant, work_, torque, wrench);
    if (solver.name == "RungeKutta4") {
      stepper_ = make_runge_kutta4(right_hand_side(), solver.step);
    } else if (solver.name == "DormandPrince") {
      stepper_ = make_dormand_prince(right_hand_side(), solver.rtol, solver.atol, solver.max_step);
      if (std::isfinite(solver.stiff_rate)) watch_ = std::make_unique<StiffnessWatch>(plant, solver.stiff_rate);
    } else if (solver.name == "Rosenbrock") {
      stepper_ = implicit(solver.rtol, solver.atol);
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
    report.switched = t_switched_;
    report.written = row_;
    report.x = report.failure.reason.empty() ? stepper_->x() : x_finite_;
    return report;
  }

 private:
  RightHandSide right_hand_side() {
    return [this](double t, const double* x, double* dx) {
      plant_.derivative(work_, t, x, drive_.torque(t), drive_.external(t, x), dx);
    };
  }

  std::unique_ptr<Stepper> implicit(double rtol, double atol) {
    const Jacobian jacobian = [this](double t, const double* x, double* J) {
      plant_.jacobian(work_, t, x, drive_.torque(t), moving_, J);
    };
    return make_rosenbrock(right_hand_side(), jacobian, rtol, atol, solver_.max_step);
  }

  // DormandPrince that has met a motion too fast for it hands over, once and for all.
  void switch_if_stiff() {
    if (std::isfinite(t_switched_)) return;
    const double t = stepper_->t();
    const bool due = t >= solver_.until || (watch_ && watch_->stiff(t, stepper_->x().data(), drive_.torque(t)));
    if (!due) return;
    t_switched_ = t;
    auto next = implicit(solver_.stiff_rtol, solver_.stiff_atol);
    next->start(t, stepper_->x());
    next->take_over(stepper_->stats());
    stepper_ = std::move(next);
  }

  // What is left of the budget does not depend on the clock; empty: enough.
  const char* overspent() const {
    const StepperStats& stats = stepper_->stats();
    if (solver_.most > 0 && stats.evaluations > solver_.most) return "more evaluations than allowed";
    const bool more = stats.steps + stats.rejected > solver_.max_steps + 10 * intervals_;
    return solver_.max_steps > 0 && more ? "more steps than allowed" : "";
  }

  void begin_interval(bool final) {
    ++intervals_;
    if (++since_poll_ >= 64) poll_if_due();  // an arm that stands still takes no step
    if (events_ && intervals_ > 1 && plant_.has_couplings()) {
      std::vector<double> x = stepper_->x();
      events_->tie(x.data());
      stepper_->truncate(stepper_->t(), x);
    }
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
      if (const char* reason = overspent(); *reason != '\0') {
        failure = {reason, stepper_->t()};
        return;
      }
      switch_if_stiff();
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
    if (events_ && plant_.has_couplings()) {
      tied_.assign(x, x + plant_.state_size());
      events_->tie(tied_.data());
      x = tied_.data();
    }
    torques_at(t, x);
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

  // TimeStepping keeps the pieces and motions of its step: a sample, at a jump of the command above all, has its own.
  void torques_at(double t, const double* x) {
    if (!at_samples_ && !pieces_at_samples_) return plant_.torques(work_, t, x, drive_.torque(t), drive_.external(t, x));
    const std::vector<int> motion = work_.motion, region = work_.region;
    if (at_samples_) {
      at_samples_->settle(t, std::vector<double>(x, x + plant_.state_size()));
    } else {
      work_.located = false;
      work_.smoothing = 1.0;  // friction of this call is not used
      plant_.evaluate_laws(work_, t, x, drive_.torque(t));
      work_.located = true;
    }
    plant_.torques(work_, t, x, drive_.torque(t), drive_.external(t, x));
    work_.motion = motion;
    work_.region = region;
  }

  const Plant& plant_;
  Drive drive_;
  double duration_;
  Output output_;
  const Poll& poll_;
  Plant::Workspace work_;
  SolverSettings solver_;
  std::unique_ptr<Stepper> stepper_;
  ExternalTorque moving_;  // empty: nothing from outside acts
  std::unique_ptr<StiffnessWatch> watch_;
  double t_switched_ = std::numeric_limits<double>::infinity();
  long intervals_ = 0;
  std::unique_ptr<Events> events_, at_samples_;
  std::unique_ptr<Ledger> ledger_;
  bool pieces_at_samples_ = false;
  std::vector<double> at_sample_, tied_;
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
