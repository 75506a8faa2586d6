// Slopes of the plant: what implicit methods and linear analysis need.
#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "matrices.hpp"
#include "plant.hpp"

namespace flexdyn {

namespace {

// Central differences of smooth scalar laws: the error is of the order 1e-10 relative.
constexpr double difference = 6e-6;

}  // namespace

void Plant::local_torques(Workspace& w, double t, const double* x, const double* tau, double* link, double* rotor,
                          double* z_rate) const {
  evaluate_laws(w, t, x, tau);
  assemble_drive(w, nullptr);
  std::copy(w.drive.begin(), w.drive.begin() + n_, link);
  for (int j = 0; j < n_; ++j) rotor[j] = rotor_slot_[j] < 0 ? 0.0 : w.drive[n_ + rotor_slot_[j]];
  internal_rates(w, t, x, z_rate);
}

void Plant::local_slopes(Workspace& w, double t, const double* x, const double* tau, LocalSlopes& out) const {
  const std::size_t n = n_, e = elastic(), zs = internal_;
  std::vector<double> point(x, x + state_size());
  std::vector<double> up(2 * n + zs), down(2 * n + zs);
  const auto torques = [&](std::vector<double>& to) {
    local_torques(w, t, point.data(), tau, to.data(), to.data() + n, to.data() + 2 * n);
  };
  out.z_joint.assign(zs, 0);
  for (const auto* laws : {&actuator_, &friction_, &spring_}) {
    for (const Law& law : *laws) {
      if (law.state >= 0) out.z_joint[law.state] = law.joint;
    }
  }
  w.joint_local = true;
  // Laws see their own joint alone, so that one pair of calls moves all joints at once; couplings are mended below.
  const std::size_t starts[4] = {0, n, n + e, 2 * n + e};
  for (int k = 0; k < 4; ++k) {
    out.link_by[k].assign(n, 0.0);
    out.rotor_by[k].assign(n, 0.0);
    out.z_by[k].assign(zs, 0.0);
    const bool of_rotor = k == 1 || k == 3;
    const double h = difference;
    const auto shift = [&](double sign) {
      for (std::size_t at = starts[k]; at < starts[k] + (of_rotor ? e : n); ++at) point[at] = x[at] + sign * h;
    };
    shift(1.0);
    torques(up);
    shift(-1.0);
    torques(down);
    shift(0.0);
    for (std::size_t j = 0; j < n; ++j) {
      out.link_by[k][j] = (up[j] - down[j]) / (2.0 * h);
      out.rotor_by[k][j] = (up[n + j] - down[n + j]) / (2.0 * h);
    }
    for (std::size_t i = 0; i < zs; ++i) {
      out.z_by[k][i] = (up[2 * n + i] - down[2 * n + i]) / (2.0 * h);
    }
  }
  uncouple(out);
  for (auto* array : {&out.z_self, &out.link_by_z, &out.rotor_by_z}) array->assign(zs, 0.0);
  for (std::size_t i = 0; i < zs; ++i) {
    const std::size_t at = 2 * (n + e) + i, j = out.z_joint[i];
    const double h = difference * std::max(1e-3, std::abs(x[at]));
    point[at] = x[at] + h;
    torques(up);
    point[at] = x[at] - h;
    torques(down);
    point[at] = x[at];
    out.link_by_z[i] = (up[j] - down[j]) / (2.0 * h);
    out.rotor_by_z[i] = (up[n + j] - down[n + j]) / (2.0 * h);
    out.z_self[i] = (up[2 * n + i] - down[2 * n + i]) / (2.0 * h);
  }
  w.joint_local = false;
  out.link.resize(n);
  out.rotor.resize(n);
  out.z_rate.resize(zs);
  local_torques(w, t, x, tau, out.link.data(), out.rotor.data(), out.z_rate.data());
}

void Plant::jacobian(Workspace& w, double t, const double* x, const double* tau, const ExternalTorque& external,
                     double* out) const {
  if (coupled_) return difference_jacobian(w, t, x, tau, external, out);
  const int n = n_, e = elastic(), half = n + e, size = state_size();
  LocalSlopes slopes;
  local_slopes(w, t, x, tau, slopes);
  evaluate_laws(w, t, x, tau);
  solve(w, t, x, external ? external(t, x) : nullptr);
  const std::vector<double> a(w.acceleration.begin(), w.acceleration.begin() + n);
  RowMatrix by_q(n, n), by_v(n, n), M(n, n);
  links_->inverse_derivatives(*w.links, x, v(x), a.data(), by_q.data(), by_v.data());
  links_->mass_matrix(*w.links, x, M.data());
  // Right side of M da = d(tau_link) - d(M a + h) for every column of the state.
  RowMatrix right = RowMatrix::Zero(n, size);
  right.leftCols(n) = -by_q;
  right.middleCols(half, n) = -by_v;
  Map<RowMatrix> J(out, size, size);
  J.setZero();
  J.block(0, half, half, half).setIdentity();
  const int column[4] = {0, n, half, half + n};
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < 4; ++k) {
      const bool of_rotor = k == 1 || k == 3;
      if (of_rotor && rotor_slot_[j] < 0) continue;
      const int at = column[k] + (of_rotor ? rotor_slot_[j] : j);
      right(j, at) += slopes.link_by[k][j];
      if (rotor_slot_[j] >= 0) J(half + n + rotor_slot_[j], at) += slopes.rotor_by[k][j] / J_[j];
    }
  }
  for (int i = 0; i < internal_; ++i) {
    const int j = slopes.z_joint[i], row = 2 * half + i;
    right(j, row) += slopes.link_by_z[i];
    if (rotor_slot_[j] >= 0) J(half + n + rotor_slot_[j], row) += slopes.rotor_by_z[i] / J_[j];
    J(row, row) = slopes.z_self[i];
    for (int k = 0; k < 4; ++k) {
      const bool of_rotor = k == 1 || k == 3;
      if (of_rotor && rotor_slot_[j] < 0) continue;
      J(row, column[k] + (of_rotor ? rotor_slot_[j] : j)) += slopes.z_by[k][i];
    }
  }
  couple(w, t, x, right.data(), out);
  if (external) external_slopes(t, x, external, right.data());
  acceleration_slopes(w, M.data(), right.data(), out);
}

// A coupling acts on its joint through the other's rotor.
void Plant::couple(const Workspace& w, double t, const double* x, double* right, double* J) const {
  const int half = n_ + elastic(), size = state_size();
  for (const Law& law : friction_) {
    if (law.other < 0) continue;
    const int slot = rotor_slot_[law.joint], other = rotor_slot_[law.other];
    double* row = slot < 0 ? right + static_cast<std::ptrdiff_t>(law.joint) * size
                           : J + static_cast<std::ptrdiff_t>(half + n_ + slot) * size;
    const double slope = coupling_slope(law.kind, law.p);
    row[other < 0 ? half + law.other : half + n_ + other] -= slope / (slot < 0 ? 1.0 : J_[law.joint]);
  }
  couple_dry(w, t, x, right, J);
  if (!spans_) return;
  visit_spans(w, t, x, [&](const std::vector<double>& gain, double by_x, double by_u) {
    for (int i = 0; i < n_; ++i) {
      for (int k = 0; k < n_; ++k) {
        double* row = right + static_cast<std::ptrdiff_t>(i) * size;
        row[k] += gain[i] * gain[k] * by_x;
        row[half + k] += gain[i] * gain[k] * by_u;
      }
    }
  });
}

// Moving all joints at once let couplings see the other joint move too: take that out of the joint's own slopes.
void Plant::uncouple(LocalSlopes& slopes) const {
  for (const Law& law : friction_) {
    if (law.other < 0) continue;
    const int rate = rotor_slot_[law.other] < 0 ? 2 : 3;  // the other's rotor moved with v, or with omega
    (rotor_slot_[law.joint] < 0 ? slopes.link_by : slopes.rotor_by)[rate][law.joint] +=
        coupling_slope(law.kind, law.p);
  }
}

// With full rotor coupling the whole motion is differenced: Pinocchio has no derivatives of S(q).
void Plant::difference_jacobian(Workspace& w, double t, const double* x, const double* tau,
                                const ExternalTorque& external, double* out) const {
  const int size = state_size();
  std::vector<double> point(x, x + size), up(size), down(size);
  const auto rate = [&](std::vector<double>& dx) {
    derivative(w, t, point.data(), tau, external ? external(t, point.data()) : nullptr, dx.data());
  };
  for (int k = 0; k < size; ++k) {
    const double h = difference * (k < 2 * velocities() ? 1.0 : std::max(1e-3, std::abs(x[k])));
    point[k] = x[k] + h;
    rate(up);
    point[k] = x[k] - h;
    rate(down);
    point[k] = x[k];
    for (int i = 0; i < size; ++i) out[static_cast<std::ptrdiff_t>(i) * size + k] = (up[i] - down[i]) / (2.0 * h);
  }
  rate(up);  // leave the workspace at the point itself
}

void Plant::external_slopes(double t, const double* x, const ExternalTorque& external, double* right) const {
  std::vector<double> point(x, x + state_size()), up(n_), down(n_);
  for (int k = 0; k < n_; ++k) {
    for (const double sign : {1.0, -1.0}) {
      point[k] = x[k] + sign * difference;
      const double* torque = external(t, point.data());
      if (torque == nullptr) return;
      std::copy(torque, torque + n_, (sign > 0.0 ? up : down).begin());
    }
    point[k] = x[k];
    for (int j = 0; j < n_; ++j) {
      right[static_cast<std::ptrdiff_t>(j) * state_size() + k] += (up[j] - down[j]) / (2.0 * difference);
    }
  }
}

// Rows of v' = M^-1 right; what sticks has no acceleration to change.
void Plant::acceleration_slopes(const Workspace& w, const double* M_all, const double* right_all, double* out) const {
  if (w.located && couplings_) {
    if (const std::vector<Tie> stuck_ones = ties(w); !stuck_ones.empty()) {
      return tied_slopes(w, stuck_ones, M_all, right_all, out);
    }
  }
  const int size = state_size(), half = n_ + elastic();
  const Map<const RowMatrix> M(M_all, n_, n_), right(right_all, n_, size);
  Map<RowMatrix> J(out, size, size);
  std::vector<int> free;
  for (int j = 0; j < n_; ++j) {
    if (!w.located || !w.held[j]) free.push_back(j);
  }
  const int count = static_cast<int>(free.size());
  MatrixXd small(count, count), rows(count, size);
  for (int i = 0; i < count; ++i) {
    rows.row(i) = right.row(free[i]);
    for (int k = 0; k < count; ++k) small(i, k) = M(free[i], free[k]);
  }
  if (count > 0) small.llt().solveInPlace(rows);
  for (int i = 0; i < count; ++i) J.row(half + free[i]) = rows.row(i);
  for (std::size_t c = 0; w.located && c < dry_.size(); ++c) {
    if (w.motion[c] == stuck && !dry_[c].couples()) {
      J.row(static_cast<Eigen::Index>(velocity_index(dry_[c]))).setZero();
    }
  }
}

}  // namespace flexdyn
