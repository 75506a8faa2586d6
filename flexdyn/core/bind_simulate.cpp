#include <algorithm>
#include <exception>
#include <limits>

#include "bindings.hpp"
#include "commands.hpp"
#include "firmware.hpp"
#include "march.hpp"
#include "spread.hpp"

namespace flexdyn {

namespace {

using Signal = std::shared_ptr<PiecewisePolynomial>;

Signal make_signal(Array breaks, Array coef, Array last) {
  require(coef.ndim() == 3 && coef.shape(0) + 1 == breaks.size() && coef.shape(0) > 0 && coef.shape(1) > 0,
          "coef is (segments, degree + 1, width)");
  require(last.size() == coef.shape(2), "last has one entry a column");
  auto signal = std::make_shared<PiecewisePolynomial>();
  signal->breaks = to_vector(breaks);
  signal->coef = to_vector(coef);
  signal->last = to_vector(last);
  signal->degree = static_cast<int>(coef.shape(1)) - 1;
  signal->width = static_cast<int>(coef.shape(2));
  require(std::is_sorted(signal->breaks.begin(), signal->breaks.end()), "breaks increase");
  return signal;
}

CommandFactory open_loop(std::optional<Signal> samples) {
  const Signal signal = samples.value_or(nullptr);
  return {[signal](int n) {
    require(!signal || signal->width == n, "the command has one column a joint");
    return std::make_unique<OpenLoop>(signal, n);
  }};
}

CommandFactory tracking(Signal reference, std::optional<Signal> feedforward, std::vector<double> kp,
                        std::vector<double> kd, bool feedback_theta, double rate) {
  const Signal ahead = feedforward.value_or(nullptr);
  return {[=](int n) {
    require(reference->width == n && static_cast<int>(kp.size()) == n && static_cast<int>(kd.size()) == n &&
                (!ahead || ahead->width == n),
            "reference, kp, kd and feedforward have one column a joint");
    return std::make_unique<Tracking>(reference, ahead, TrackingGains{kp, kd, feedback_theta}, rate, n);
  }};
}

std::vector<FirmwareSettings> firmware_settings(Array table) {
  require(table.ndim() == 2 && table.shape(1) == 8 && table.shape(0) > 0, "firmware has eight numbers a joint");
  std::vector<FirmwareSettings> found;
  for (std::size_t j = 0; j < table.shape(0); ++j) {
    const double* p = table.data() + 8 * j;
    found.push_back({p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]});
    require(p[7] == found.front().rate && p[7] > 0.0, "all joints have one rate");
  }
  return found;
}

CommandFactory firmware(Array goals, Array table, Array full, int delay, bool feedback_theta) {
  const auto settings = firmware_settings(table);
  const std::vector<double> rows = to_vector(goals), torques = to_vector(full);
  require(goals.ndim() == 2 && goals.shape(0) > 0 && goals.shape(1) == settings.size() &&
              torques.size() == settings.size() && delay >= 0,
          "goals, firmware and full have one column a joint");
  return {[=](int n) {
    require(static_cast<int>(torques.size()) == n, "the command has one column a joint");
    return std::make_unique<FirmwareServo>(rows, settings, torques, delay, feedback_theta);
  }};
}

// Duties (ticks,) of one servo at its ticks.
void firmware_duty(Array table, Array goal, Array position, OutArray out) {
  require(goal.size() == out.size() && position.size() == out.size(), "sizes differ");
  Firmware servo(firmware_settings(table).front());
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] = servo.duty(goal.data()[i], position.data()[i]);
}

nb::object copy_to_numpy(const double* data, int n) {
  auto* copy = new double[n];
  std::copy(data, data + n, copy);
  nb::capsule owner(copy, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  return nb::ndarray<nb::numpy, double, nb::ndim<1>>(copy, {static_cast<std::size_t>(n)}, owner).cast();
}

CommandFactory callback(nb::object law, double rate) {
  auto held = std::make_shared<PythonCallable>(std::move(law));
  return {[held, rate](int n) {
    auto call = [held, n](double t, const JointState& state, double* tau) {
      nb::gil_scoped_acquire gil;
      nb::object result = held->get()(t, copy_to_numpy(state.q, n), copy_to_numpy(state.v, n),
                                      copy_to_numpy(state.theta, n), copy_to_numpy(state.omega, n));
      const Array array = nb::cast<Array>(result);
      require(static_cast<int>(array.size()) == n, "the controller returns one torque a joint");
      std::copy(array.data(), array.data() + n, tau);
    };
    return std::make_unique<Callback>(call, rate, n);
  }};
}

ExternalWrench external_wrench(int joint, Array rotation, Array translation, bool world_axes, Signal samples) {
  require(rotation.size() == 9 && translation.size() == 3 && samples->width == 6, "a wrench has six columns");
  ExternalWrench wrench{{joint, {}, {}, world_axes}, samples};
  std::copy(rotation.data(), rotation.data() + 9, wrench.point.rotation);
  std::copy(translation.data(), translation.data() + 3, wrench.point.translation);
  return wrench;
}

// One run to be made: everything that a thread without the GIL needs.
struct Job {
  std::shared_ptr<Plant> plant;
  CommandFactory command;
  std::vector<ExternalWrench> external;
  std::vector<double> x0;
  double duration;
  SolverSettings solver;
  Array times;
  std::vector<OutArray> out;
  Output output;
};

Job make_job(std::shared_ptr<Plant> plant, const CommandFactory& command, std::vector<ExternalWrench> external,
             Array x0, double duration, const SolverSettings& solver, Array times, std::vector<OutArray> out,
             std::optional<OutArray> ledger) {
  const std::size_t n = plant->n(), rows = times.size(), internal = plant->internal_states();
  require(static_cast<int>(x0.size()) == plant->state_size(), "x0 is the state's size");
  require(out.size() == 8, "eight output arrays");
  for (std::size_t k = 0; k < 7; ++k) require(out[k].size() == rows * n, "outputs are (times, n)");
  require(out[7].size() == rows * internal, "z is (times, internal states)");
  require(!ledger || ledger->size() == rows * plant->ledger_size(), "the ledger is (times, ledger size)");
  Output output{times.data(),  rows,          out[0].data(), out[1].data(), out[2].data(), out[3].data(),
                out[4].data(), out[5].data(), out[6].data(), out[7].data(), ledger ? ledger->data() : nullptr};
  if (ledger) out.push_back(*ledger);
  return {plant, command, std::move(external), to_vector(x0), duration, solver, times, std::move(out), output};
}

struct Outcome {
  Report report;
  std::vector<double> tick_times, tick_torques;
  std::exception_ptr error;
};

Outcome run_job(const Job& job, const Poll& poll) {
  Outcome outcome;
  try {
    const auto command = job.command.make(job.plant->n());
    outcome.report =
        march(*job.plant, *command, job.external, job.x0, job.duration, job.solver, job.output, poll);
    if (const auto* sampled = dynamic_cast<const Sampled*>(command.get())) {
      outcome.tick_times = sampled->tick_times();
      outcome.tick_torques = sampled->tick_torques();
    }
  } catch (...) {
    outcome.error = std::current_exception();
  }
  return outcome;
}

nb::dict report_of(const Outcome& outcome) {
  const Report& report = outcome.report;
  nb::dict result;
  result["reason"] = report.failure.reason;
  result["t"] = report.failure.t;
  result["x"] = copy_to_numpy(report.x.data(), static_cast<int>(report.x.size()));
  result["switched"] = report.switched;
  result["written"] = report.written;
  result["steps"] = report.stats.steps;
  result["rejected"] = report.stats.rejected;
  result["events"] = report.events;
  result["evaluations"] = report.stats.evaluations;
  result["tick_times"] = copy_to_numpy(outcome.tick_times.data(), static_cast<int>(outcome.tick_times.size()));
  result["tick_torques"] = copy_to_numpy(outcome.tick_torques.data(), static_cast<int>(outcome.tick_torques.size()));
  return result;
}

nb::dict simulate(const Job& job, nb::object progress) {
  const Poll poll = [&progress](double t) {
    nb::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (!progress.is_none()) progress(t);
  };
  Outcome outcome;
  {
    nb::gil_scoped_release release;
    outcome = run_job(job, poll);
  }
  if (outcome.error) std::rethrow_exception(outcome.error);
  return report_of(outcome);
}

// A failed run is reported in its place, as the exception it raised; the others go on.
nb::list simulate_many(const std::vector<const Job*>& jobs, int threads, nb::object progress) {
  for (const Job* each : jobs) require(each != nullptr, "a job is None");
  std::vector<Outcome> outcomes(jobs.size());
  spread(jobs.size(), threads, progress,
         [&](std::size_t run, const Poll& poll) { outcomes[run] = run_job(*jobs[run], poll); });
  nb::list results;
  for (const Outcome& outcome : outcomes) {
    nb::dict result = report_of(outcome);
    result["error"] = nb::none();
    try {
      if (outcome.error) std::rethrow_exception(outcome.error);
    } catch (nb::python_error& error) {
      result["error"] = nb::borrow(error.value());
    } catch (const std::exception& error) {
      result["error"] = nb::str(error.what());
    }
    results.append(result);
  }
  return results;
}

SolverSettings settings(const std::string& name, double step, double rtol, double atol, double max_step,
                        double smoothing, long most, long max_steps, double stiff_rate, double until,
                        double stiff_rtol, double stiff_atol) {
  return {name, step, rtol, atol, max_step, smoothing, most, max_steps, stiff_rate, until, stiff_rtol, stiff_atol};
}

}  // namespace

void bind_simulate(nb::module_& m) {
  nb::class_<PiecewisePolynomial>(m, "Signal");
  m.def("signal", &make_signal, nb::arg("breaks"), nb::arg("coef"), nb::arg("last"));
  nb::class_<CommandFactory>(m, "Command");
  m.def("open_loop", &open_loop, nb::arg("samples") = nb::none());
  m.def("tracking", &tracking, nb::arg("reference"), nb::arg("feedforward"), nb::arg("kp"), nb::arg("kd"),
        nb::arg("feedback_theta"), nb::arg("rate"));
  m.def("firmware", &firmware, nb::arg("goals"), nb::arg("settings"), nb::arg("full"), nb::arg("delay"),
        nb::arg("feedback_theta"));
  m.def("firmware_duty", &firmware_duty, nb::arg("settings"), nb::arg("goal"), nb::arg("position"), nb::arg("out"));
  m.def("controller", &callback, nb::arg("law"), nb::arg("rate"));
  nb::class_<ExternalWrench>(m, "ExternalWrench");
  m.def("external_wrench", &external_wrench, nb::arg("joint"), nb::arg("rotation"), nb::arg("translation"),
        nb::arg("world_axes"), nb::arg("samples"));
  constexpr double never = std::numeric_limits<double>::infinity();
  nb::class_<SolverSettings>(m, "SolverSettings");
  m.def("solver_settings", &settings, nb::arg("name"), nb::kw_only(), nb::arg("step") = 0.0, nb::arg("rtol") = 0.0,
        nb::arg("atol") = 0.0, nb::arg("max_step") = 0.0, nb::arg("smoothing") = 0.0, nb::arg("most") = 0,
        nb::arg("max_steps") = 0, nb::arg("stiff_rate") = never, nb::arg("until") = never,
        nb::arg("stiff_rtol") = 0.0, nb::arg("stiff_atol") = 0.0);
  nb::class_<Job>(m, "Job");
  m.def("job", &make_job, nb::arg("plant"), nb::arg("command"), nb::arg("external"), nb::arg("x0"),
        nb::arg("duration"), nb::arg("solver"), nb::arg("times"), nb::arg("out"), nb::arg("ledger").none());
  m.def("simulate", &simulate, nb::arg("job"), nb::arg("progress").none());
  m.def("simulate_many", &simulate_many, nb::arg("jobs"), nb::arg("threads"), nb::arg("progress").none());
}

}  // namespace flexdyn
