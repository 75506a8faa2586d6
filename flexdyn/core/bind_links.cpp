#include <algorithm>

#include "bindings.hpp"
#include "link_dynamics.hpp"

namespace flexdyn {

namespace {

std::shared_ptr<LinkDynamics> make_links(nb::dict arrays, Array gravity) {
  const auto doubles = [&](const char* key) { return to_vector(nb::cast<Array>(arrays[key])); };
  Tree tree;
  for (const double parent : doubles("parent")) tree.parent.push_back(static_cast<int>(parent));
  for (const double prismatic : doubles("prismatic")) tree.prismatic.push_back(prismatic != 0.0);
  tree.axis = doubles("axis");
  tree.rotation = doubles("rotation");
  tree.translation = doubles("translation");
  tree.mass = doubles("mass");
  tree.com = doubles("com");
  tree.inertia = doubles("inertia");
  tree.armature = doubles("armature");
  tree.gain = doubles("gain");
  tree.offset = doubles("offset");
  const std::size_t m = tree.parent.size();
  require(m > 0 && tree.prismatic.size() == m && tree.axis.size() == 3 * m && tree.rotation.size() == 9 * m &&
              tree.translation.size() == 3 * m && tree.mass.size() == m && tree.com.size() == 3 * m &&
              tree.inertia.size() == 9 * m && tree.armature.size() == m && tree.offset.size() == m &&
              !tree.gain.empty() && tree.gain.size() % m == 0 && gravity.size() == 3,
          "tree arrays do not fit each other");
  for (std::size_t i = 0; i < m; ++i) {
    require(tree.parent[i] >= -1 && tree.parent[i] < static_cast<int>(i), "parents come before children");
  }
  std::copy(gravity.data(), gravity.data() + 3, tree.gravity);
  return std::make_shared<LinkDynamics>(tree);
}

std::size_t rows_of(const LinkDynamics& links, const Array& q) {
  require(q.size() % links.size() == 0, "the last axis is n joints long");
  return q.size() / links.size();
}

void acceleration(const LinkDynamics& links, Array q, Array v, Array tau, OutArray a) {
  const std::size_t rows = rows_of(links, q), n = links.size();
  require(v.size() == q.size() && tau.size() == q.size() && a.size() == q.size(), "q, v, tau, a differ in size");
  nb::gil_scoped_release release;
  auto work = links.workspace();
  for (std::size_t i = 0; i < rows; ++i) {
    links.acceleration(*work, q.data() + i * n, v.data() + i * n, tau.data() + i * n, a.data() + i * n);
  }
}

void mass_matrix(const LinkDynamics& links, Array q, OutArray M) {
  const std::size_t rows = rows_of(links, q), n = links.size();
  require(M.size() == rows * n * n, "M is (rows, n, n)");
  nb::gil_scoped_release release;
  auto work = links.workspace();
  for (std::size_t i = 0; i < rows; ++i) links.mass_matrix(*work, q.data() + i * n, M.data() + i * n * n);
}

void bias(const LinkDynamics& links, Array q, Array v, OutArray h) {
  const std::size_t rows = rows_of(links, q), n = links.size();
  require(v.size() == q.size() && h.size() == q.size(), "q, v, h differ in size");
  nb::gil_scoped_release release;
  auto work = links.workspace();
  for (std::size_t i = 0; i < rows; ++i) {
    links.bias(*work, q.data() + i * n, v.data() + i * n, h.data() + i * n);
  }
}

void inverse_dynamics(const LinkDynamics& links, Array q, Array v, Array a, OutArray tau) {
  const std::size_t rows = rows_of(links, q), n = links.size();
  require(v.size() == q.size() && a.size() == q.size() && tau.size() == q.size(), "q, v, a, tau differ in size");
  nb::gil_scoped_release release;
  auto work = links.workspace();
  for (std::size_t i = 0; i < rows * n; i += n) {
    links.inverse_dynamics(*work, q.data() + i, v.data() + i, a.data() + i, tau.data() + i);
  }
}

void inverse_derivatives(const LinkDynamics& links, Array q, Array v, Array a, OutArray by_q, OutArray by_v) {
  const std::size_t rows = rows_of(links, q), n = links.size();
  require(v.size() == q.size() && a.size() == q.size(), "q, v, a differ in size");
  require(by_q.size() == rows * n * n && by_v.size() == rows * n * n, "derivatives are (rows, n, n)");
  nb::gil_scoped_release release;
  auto work = links.workspace();
  for (std::size_t i = 0; i < rows; ++i) {
    links.inverse_derivatives(*work, q.data() + i * n, v.data() + i * n, a.data() + i * n, by_q.data() + i * n * n,
                              by_v.data() + i * n * n);
  }
}

void inertial_torques(const LinkDynamics& links, Array q, Array v, Array a, Array more, OutArray tau) {
  const std::size_t rows = rows_of(links, q), n = links.size();
  const std::size_t size = LinkDynamics::inertial_parameters * links.bodies(), count = more.size() / size;
  require(v.size() == q.size() && a.size() == q.size(), "q, v, a differ in size");
  require(count > 0 && more.size() == count * size, "inertias are (count, m, 11)");
  require(tau.size() == rows * count * n, "torques are (rows, count, n)");
  nb::gil_scoped_release release;
  auto work = links.workspace();
  for (std::size_t i = 0; i < rows; ++i) {
    links.inertial_torques(*work, q.data() + i * n, v.data() + i * n, a.data() + i * n, more.data(),
                           static_cast<int>(count), tau.data() + i * count * n);
  }
}

void energy(const LinkDynamics& links, Array q, Array v, OutArray kinetic, OutArray potential) {
  const std::size_t rows = rows_of(links, q), n = links.size();
  require(v.size() == q.size() && kinetic.size() == rows && potential.size() == rows, "sizes differ");
  auto work = links.workspace();
  for (std::size_t i = 0; i < rows; ++i) {
    links.energy(*work, q.data() + i * n, v.data() + i * n, kinetic.data()[i], potential.data()[i]);
  }
}

}  // namespace

void bind_links(nb::module_& m) {
  nb::class_<LinkDynamics>(m, "LinkDynamics")
      .def_prop_ro("n", &LinkDynamics::size)
      .def("acceleration", &acceleration, nb::arg("q"), nb::arg("v"), nb::arg("tau"), nb::arg("out"))
      .def("mass_matrix", &mass_matrix, nb::arg("q"), nb::arg("out"))
      .def("bias", &bias, nb::arg("q"), nb::arg("v"), nb::arg("out"))
      .def("inverse_dynamics", &inverse_dynamics, nb::arg("q"), nb::arg("v"), nb::arg("a"), nb::arg("out"))
      .def("inverse_derivatives", &inverse_derivatives, nb::arg("q"), nb::arg("v"), nb::arg("a"), nb::arg("by_q"),
           nb::arg("by_v"))
      .def("inertial_torques", &inertial_torques, nb::arg("q"), nb::arg("v"), nb::arg("a"), nb::arg("more"),
           nb::arg("out"))
      .def("energy", &energy, nb::arg("q"), nb::arg("v"), nb::arg("kinetic"), nb::arg("potential"));
  m.def("link_dynamics", &make_links, nb::arg("tree"), nb::arg("gravity"));
}

}  // namespace flexdyn
