#include <algorithm>

#include "bindings.hpp"
#include "march.hpp"

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

// A command is made anew for every run: it carries the torque of the moment.
struct CommandFactory {
  std::function<std::unique_ptr<Command>(int n)> make;
};

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

nb::dict simulate(const Plant& plant, const CommandFactory& command, const std::vector<ExternalWrench>& external,
                  Array x0, double duration, const SolverSettings& solver, Array times, std::vector<OutArray> out,
                  nb::object progress) {
  require(static_cast<int>(x0.size()) == plant.state_size(), "x0 is the state's size");
  require(out.size() == 7, "seven output arrays");
  for (const OutArray& array : out) require(array.size() == times.size() * plant.n(), "outputs are (times, n)");
  const Output output{times.data(),  times.size(),  out[0].data(), out[1].data(), out[2].data(),
                      out[3].data(), out[4].data(), out[5].data(), out[6].data()};
  const Poll poll = [&progress](double t) {
    nb::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (!progress.is_none()) progress(t);
  };
  Report report;
  {
    nb::gil_scoped_release release;
    auto run = command.make(plant.n());
    report = march(plant, *run, external, to_vector(x0), duration, solver, output, poll);
  }
  nb::dict result;
  result["reason"] = report.failure.reason;
  result["t"] = report.failure.t;
  result["x"] = copy_to_numpy(report.x.data(), static_cast<int>(report.x.size()));
  result["written"] = report.written;
  result["steps"] = report.stats.steps;
  result["rejected"] = report.stats.rejected;
  result["events"] = report.events;
  result["evaluations"] = report.stats.evaluations;
  return result;
}

SolverSettings settings(const std::string& name, double step, double rtol, double atol, double max_step,
                        double smoothing) {
  return {name, step, rtol, atol, max_step, smoothing};
}

}  // namespace

void bind_simulate(nb::module_& m) {
  nb::class_<PiecewisePolynomial>(m, "Signal");
  m.def("signal", &make_signal, nb::arg("breaks"), nb::arg("coef"), nb::arg("last"));
  nb::class_<CommandFactory>(m, "Command");
  m.def("open_loop", &open_loop, nb::arg("samples") = nb::none());
  m.def("tracking", &tracking, nb::arg("reference"), nb::arg("feedforward"), nb::arg("kp"), nb::arg("kd"),
        nb::arg("feedback_theta"), nb::arg("rate"));
  m.def("controller", &callback, nb::arg("law"), nb::arg("rate"));
  nb::class_<ExternalWrench>(m, "ExternalWrench");
  m.def("external_wrench", &external_wrench, nb::arg("joint"), nb::arg("rotation"), nb::arg("translation"),
        nb::arg("world_axes"), nb::arg("samples"));
  nb::class_<SolverSettings>(m, "SolverSettings");
  m.def("solver_settings", &settings, nb::arg("name"), nb::kw_only(), nb::arg("step") = 0.0, nb::arg("rtol") = 0.0,
        nb::arg("atol") = 0.0, nb::arg("max_step") = 0.0, nb::arg("smoothing") = 0.0);
  m.def("simulate", &simulate, nb::arg("plant"), nb::arg("command"), nb::arg("external"), nb::arg("x0"),
        nb::arg("duration"), nb::arg("solver"), nb::arg("times"), nb::arg("out"), nb::arg("progress").none());
}

}  // namespace flexdyn
