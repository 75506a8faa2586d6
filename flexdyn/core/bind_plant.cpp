#include <algorithm>
#include <cmath>
#include <limits>

#include "bindings.hpp"
#include "events.hpp"
#include "plant.hpp"

namespace flexdyn {

namespace {

const LawRow& find_law(const std::string& name) {
  const LawRow* found = named(name);
  if (found == nullptr) throw std::invalid_argument("no such law: " + name);
  return *found;
}

Side side_of(const std::string& side) {
  if (side == "link") return Side::link;
  if (side == "motor") return Side::motor;
  require(side == "transmission", "side is link, motor or transmission");
  return Side::transmission;
}

class PythonLaw : public CallbackLaw {
 public:
  explicit PythonLaw(nb::object law) : law_(std::move(law)) {}
  double operator()(const LawInput& in, double tau) const override {
    nb::gil_scoped_acquire gil;
    return nb::cast<double>(law_.get()(in.t, in.x, in.u, tau));
  }

 private:
  PythonCallable law_;
};

Law make_law(const std::string& name, int joint, const std::string& side, const std::vector<double>& parameters,
             int other, const std::vector<double>& row) {
  const LawRow& entry = find_law(name);
  require(static_cast<int>(parameters.size()) == entry.parameters, "wrong number of parameters for this law");
  Law law{entry.kind, entry.stage, joint, side_of(side), {}, nullptr, other};
  require(row.empty() || law.stage == Stage::link, "a law on several joints is of stage link");
  std::copy(parameters.begin(), parameters.end(), law.p);
  law.row = row;
  return law;
}

Law make_python_law(const std::string& stage, int joint, const std::string& side, nb::object callable) {
  Law law{LawKind::callback, Stage::friction, joint, side_of(side), {}, nullptr};
  if (stage == "actuator") law.stage = Stage::actuator;
  else if (stage == "spring") law.stage = Stage::spring;
  else require(stage == "friction", "a law in Python is of stage friction, spring or actuator");
  law.callback = std::make_shared<PythonLaw>(std::move(callable));
  return law;
}

double law_value(const Law& law, const LawInput& in, double tau) {
  const int region = region_of(law.kind, law.p, in, law.stage == Stage::deflection ? in.x : tau);
  const double direction = (in.u > 0.0) - (in.u < 0.0);
  switch (law.stage) {
    case Stage::friction: return friction_torque(law.kind, law.p, in, region);
    case Stage::spring: return spring_torque(law.kind, law.p, in);
    case Stage::actuator: return actuator_torque(law.kind, law.p, in, tau, region);
    case Stage::link: return link_torque(law.kind, law.p, in, region);
    case Stage::dry: return direction * dry_level(law.kind, law.p, in, direction, region);
    case Stage::deflection: break;
  }
  return deflection_after(law.kind, law.p, in.x, tau, region);
}

// The law over whole recordings; dry laws give the set's end in the direction of u, and 0 at u = 0. For the stage
// deflection tau is theta.
void evaluate_law(const std::string& name, const std::vector<double>& parameters, Array t, Array x, Array u, Array tau,
                  Array z, OutArray out) {
  const Law law = make_law(name, 0, "motor", parameters, -1, {});
  const std::size_t count = out.size();
  require(t.size() == count && x.size() == count && u.size() == count && tau.size() == count && z.size() == count,
          "sizes differ");
  nb::gil_scoped_release release;
  for (std::size_t i = 0; i < count; ++i) {
    LawInput in{t.data()[i], x.data()[i], u.data()[i], z.data()[i], tau.data()[i]};
    in.other = in.u;
    out.data()[i] = law_value(law, in, tau.data()[i]);
  }
}

void evaluate_slope(const std::string& name, const std::vector<double>& parameters, Array theta, OutArray out) {
  const Law law = make_law(name, 0, "transmission", parameters, -1, {});
  require(theta.size() == out.size(), "sizes differ");
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] = deflection_slope(law.kind, law.p, theta.data()[i]);
}

// States of a law that remembers, z' = u - |u| z/reach, along a path; exact where it is monotone between its points.
void states_along(Array x, double reach, double z0, OutArray z) {
  require(x.size() == z.size() && reach > 0.0, "x and z differ in size, or the reach is not above 0");
  nb::gil_scoped_release release;
  double now = z0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    const double way = i == 0 ? 0.0 : x.data()[i] - x.data()[i - 1];
    now += std::expm1(-std::abs(way) / reach) * (now - std::copysign(reach, way));
    z.data()[i] = now;
  }
}

void derivative(const Plant& plant, double t, Array x, Array tau, double smoothing, OutArray dx) {
  require(static_cast<int>(x.size()) == plant.state_size() && dx.size() == x.size(), "x and dx are the state's size");
  require(static_cast<int>(tau.size()) == plant.n(), "tau has one entry a joint");
  auto work = plant.workspace();
  work.smoothing = smoothing;
  plant.derivative(work, t, x.data(), tau.data(), nullptr, dx.data());
}

void stored_energy(const Plant& plant, Array x, OutArray out) {
  const std::size_t size = plant.state_size();
  require(x.size() == out.size() * size, "x is (rows, nx) and out (rows,)");
  auto work = plant.workspace();
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] = plant.stored_energy(work, x.data() + i * size);
}

void magnetic_energy(const Plant& plant, Array x, OutArray out) {
  const std::size_t size = plant.state_size();
  require(x.size() == out.size() * size, "x is (rows, nx) and out (rows,)");
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] = plant.magnetic_energy(x.data() + i * size);
}

void inertia(const Plant& plant, Array x, OutArray H) {
  const std::size_t N = plant.velocities(), size = plant.state_size(), rows = x.size() / size;
  require(x.size() == rows * size && H.size() == rows * N * N, "x is (rows, nx) and H (rows, N, N)");
  auto work = plant.workspace();
  for (std::size_t i = 0; i < rows; ++i) plant.inertia(work, x.data() + i * size, H.data() + i * N * N);
}

void bias_all(const Plant& plant, Array x, OutArray b) {
  const std::size_t N = plant.velocities(), size = plant.state_size(), rows = x.size() / size;
  require(x.size() == rows * size && b.size() == rows * N, "x is (rows, nx) and b (rows, N)");
  auto work = plant.workspace();
  for (std::size_t i = 0; i < rows; ++i) plant.bias(work, x.data() + i * size, b.data() + i * N);
}

// Dry friction is smoothed if a width is given; without, what rests and is held has no acceleration.
void jacobian_at(const Plant& plant, Plant::Workspace& work, double t, const double* x, const double* tau,
                 double smoothing, double* out) {
  work.smoothing = smoothing;
  if (smoothing == 0.0) {
    Events events(plant, work, [&](double) { return tau; }, [](double, const double*) { return nullptr; });
    events.settle(t, std::vector<double>(x, x + plant.state_size()));
  }
  plant.jacobian(work, t, x, tau, nullptr, out);
}

void jacobian(const Plant& plant, double t, Array x, Array tau, double smoothing, OutArray out) {
  const std::size_t size = plant.state_size();
  require(x.size() == size && out.size() == size * size, "x is (nx,) and the Jacobian (nx, nx)");
  require(static_cast<int>(tau.size()) == plant.n(), "tau has one entry a joint");
  auto work = plant.workspace();
  jacobian_at(plant, work, t, x.data(), tau.data(), smoothing, out.data());
}

// Along a motion the Jacobians (rows, nx, nx), and every so many rows what torques do (rows, nx, n) where no contact
// sticks; rows between have those of the row before.
void slopes_along(const Plant& plant, Array x, Array tau, int every, OutArray A, OutArray B) {
  const std::size_t size = plant.state_size(), n = plant.n(), rows = x.size() / size, wide = size * n;
  require(x.size() == rows * size && tau.size() == rows * n, "x is (rows, nx) and tau (rows, n)");
  require(A.size() == rows * size * size && B.size() == rows * wide, "A is (rows, nx, nx) and B (rows, nx, n)");
  require(every > 0, "every is a number of rows");
  nb::gil_scoped_release release;
  auto sticking = plant.workspace(), free = plant.workspace();
  free.smoothing = std::numeric_limits<double>::infinity();
  constexpr double step = 1e-3;
  std::vector<double> pushed(n), base(size), up(size);
  for (std::size_t row = 0; row < rows; ++row) {
    const double *at = x.data() + row * size, *asked = tau.data() + row * n;
    double* by_torque = B.data() + row * wide;
    jacobian_at(plant, sticking, 0.0, at, asked, 0.0, A.data() + row * size * size);
    if (row % static_cast<std::size_t>(every) != 0) {
      std::copy(by_torque - wide, by_torque, by_torque);
      continue;
    }
    plant.derivative(free, 0.0, at, asked, nullptr, base.data());
    for (std::size_t j = 0; j < n; ++j) {
      std::copy(asked, asked + n, pushed.begin());
      pushed[j] += step;
      plant.derivative(free, 0.0, at, pushed.data(), nullptr, up.data());
      for (std::size_t i = 0; i < size; ++i) by_torque[i * n + j] = (up[i] - base[i]) / step;
    }
  }
}

std::shared_ptr<Plant> make_plant(std::shared_ptr<LinkDynamics> links, Array stiffness, Array damping, Array inertia,
                                  Array spin, const std::vector<Law>& laws) {
  const std::size_t n = links->size();
  require(stiffness.size() == n && damping.size() == n && inertia.size() == n && spin.size() == n,
          "K, D, J and spin have one entry a joint");
  for (const Law& law : laws) {
    require(law.joint >= 0 && law.joint < static_cast<int>(n), "a law's joint is not there");
    require(law.other < static_cast<int>(n), "a law's other joint is not there");
    require(law.row.empty() || law.row.size() == n, "a law's row has one entry a joint");
  }
  return std::make_shared<Plant>(links, to_vector(stiffness), to_vector(damping), to_vector(inertia), to_vector(spin),
                                 laws);
}

}  // namespace

void bind_plant(nb::module_& m) {
  nb::class_<LawRow>(m, "LawRow")
      .def_prop_ro("name", [](const LawRow& row) { return std::string(row.name); })
      .def_prop_ro("stage", [](const LawRow& row) { return std::string(row.stage_name()); })
      .def_ro("parameters", &LawRow::parameters)
      .def_prop_ro("has_state", [](const LawRow& row) { return row.has(has_state); })
      .def_prop_ro("conservative", [](const LawRow& row) { return row.has(conservative); })
      .def_prop_ro("of_load", [](const LawRow& row) { return is_of_load(row); });
  m.def("law_table", [] { return std::vector<LawRow>(std::begin(law_table), std::end(law_table)); });
  nb::class_<Law>(m, "Law");
  m.def("law", &make_law, nb::arg("name"), nb::arg("joint"), nb::arg("side"), nb::arg("parameters"),
        nb::arg("other") = -1, nb::arg("row") = std::vector<double>());
  m.def("python_law", &make_python_law, nb::arg("stage"), nb::arg("joint"), nb::arg("side"), nb::arg("callable"));
  m.def("evaluate_law", &evaluate_law, nb::arg("name"), nb::arg("parameters"), nb::arg("t"), nb::arg("x"),
        nb::arg("u"), nb::arg("tau"), nb::arg("z"), nb::arg("out"));
  m.def("deflection_slope", &evaluate_slope, nb::arg("name"), nb::arg("parameters"), nb::arg("theta"), nb::arg("out"));
  m.def("states_along", &states_along, nb::arg("x"), nb::arg("reach"), nb::arg("z0"), nb::arg("out"));
  nb::class_<Plant>(m, "Plant")
      .def_prop_ro("n", &Plant::n)
      .def_prop_ro("state_size", &Plant::state_size)
      .def_prop_ro("internal_states", &Plant::internal_states)
      .def_prop_ro("ledger_size", &Plant::ledger_size)
      .def_prop_ro("coupled", &Plant::coupled)
      .def("inertia", &inertia, nb::arg("x"), nb::arg("out"))
      .def("bias", &bias_all, nb::arg("x"), nb::arg("out"))
      .def("stored_energy", &stored_energy, nb::arg("x"), nb::arg("out"))
      .def("magnetic_energy", &magnetic_energy, nb::arg("x"), nb::arg("out"))
      .def_prop_ro("has_dry_friction", &Plant::has_dry_friction)
      .def("derivative", &derivative, nb::arg("t"), nb::arg("x"), nb::arg("tau"), nb::arg("smoothing"),
           nb::arg("out"))
      .def("jacobian", &jacobian, nb::arg("t"), nb::arg("x"), nb::arg("tau"), nb::arg("smoothing"), nb::arg("out"))
      .def("slopes_along", &slopes_along, nb::arg("x"), nb::arg("tau"), nb::arg("every"), nb::arg("A"), nb::arg("B"));
  m.def("plant", &make_plant, nb::arg("links"), nb::arg("stiffness"), nb::arg("damping"), nb::arg("rotor_inertia"),
        nb::arg("spin"), nb::arg("laws"));
}

}  // namespace flexdyn
