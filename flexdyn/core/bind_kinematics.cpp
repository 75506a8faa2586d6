#include <algorithm>
#include <cmath>
#include <cstdint>

#include "bindings.hpp"

namespace flexdyn {

namespace {

// A joint between the frame and the base. A point x in its axes is in those of its parent
//   along x + cos(q) even x + sin(q) odd x + moved    (Rodrigues: R a a^T, R (1 - a a^T), R S(a)) where it turns,
//   along (x + q axis) + moved                        where it slides; there `along` is R.
struct Passage {
  int joint;
  bool slides;
  double along[9], even[9], odd[9], axis[3], moved[3];
};

Passage passage(int joint, bool slides, const double* a, const double* R, const double* t) {
  Passage made{joint, slides, {}, {}, {}, {a[0], a[1], a[2]}, {t[0], t[1], t[2]}};
  const double across[9] = {0.0, -a[2], a[1], a[2], 0.0, -a[0], -a[1], a[0], 0.0};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double along = 0.0, odd = 0.0;
      for (int k = 0; k < 3; ++k) {
        along += R[3 * i + k] * a[k] * a[j];
        odd += R[3 * i + k] * across[3 * k + j];
      }
      made.along[3 * i + j] = slides ? R[3 * i + j] : along;
      made.even[3 * i + j] = R[3 * i + j] - along;
      made.odd[3 * i + j] = odd;
    }
  }
  return made;
}

// The point moves from the joint's axes to those of its parent.
void pass(const Passage& way, double q, double* point) {
  if (way.slides) {
    for (int k = 0; k < 3; ++k) point[k] += q * way.axis[k];
  }
  const double cos = way.slides ? 0.0 : std::cos(q), sin = way.slides ? 0.0 : std::sin(q);
  double moved[3];
  for (int i = 0; i < 3; ++i) {
    double along = 0.0, even = 0.0, odd = 0.0;
    for (int k = 0; k < 3; ++k) {
      along += way.along[3 * i + k] * point[k];
      even += way.even[3 * i + k] * point[k];
      odd += way.odd[3 * i + k] * point[k];
    }
    moved[i] = (way.slides ? along : along + cos * even + sin * odd) + way.moved[i];
  }
  std::copy(moved, moved + 3, point);
}

using Parents = Read<std::int32_t, nb::ndim<1>>;
using Kinds = Read<bool, nb::ndim<1>>;

// Where a point fixed to `joint` is in the axes of the base, at positions q (rows, m) of all joints of the tree.
void point_positions(Parents parent, Kinds prismatic, Array axis, Array rotation, Array translation, int joint,
                     Array point, Matrix q, OutArray out) {
  const std::size_t m = parent.size(), rows = q.shape(0);
  require(prismatic.size() == m && axis.size() == 3 * m && rotation.size() == 9 * m && translation.size() == 3 * m,
          "the tree's arrays differ in size");
  require(joint < static_cast<int>(m), "the joint is not there");
  require(point.size() == 3 && q.shape(1) == m && out.size() == 3 * rows, "q is (rows, m), out is (rows, 3)");
  std::vector<Passage> way;
  for (int k = joint; k >= 0; k = parent.data()[k]) {
    require(parent.data()[k] < k, "joints stand after their parents");
    way.push_back(passage(k, prismatic.data()[k], axis.data() + 3 * k, rotation.data() + 9 * k,
                          translation.data() + 3 * k));
  }
  nb::gil_scoped_release release;
  for (std::size_t row = 0; row < rows; ++row) {
    double* found = out.data() + 3 * row;
    std::copy(point.data(), point.data() + 3, found);
    for (const Passage& each : way) pass(each, q.data()[row * m + each.joint], found);
  }
}

}  // namespace

void bind_kinematics(nb::module_& m) {
  m.def("point_positions", &point_positions, nb::arg("parent"), nb::arg("prismatic"), nb::arg("axis"),
        nb::arg("rotation"), nb::arg("translation"), nb::arg("joint"), nb::arg("point"), nb::arg("q"), nb::arg("out"));
}

}  // namespace flexdyn
