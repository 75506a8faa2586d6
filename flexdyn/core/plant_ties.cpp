// Couplings of motors by dry friction, and windings: what their laws add to the plant.
#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "matrices.hpp"
#include "plant.hpp"

namespace flexdyn {

// Couplings of one pair of motors at one ratio add up.
void Plant::sort_in_coupling(const Law& law) {
  couplings_ = true;
  const double ratio = coupling_ratio(law.p);
  auto contact = std::find_if(dry_.begin(), dry_.end(), [&](const DryContact& c) {
    return c.joint == law.joint && c.other == law.other && c.ratio == ratio;
  });
  if (contact == dry_.end()) contact = dry_.insert(contact, {law.joint, Side::motor, {}, law.other, ratio});
  contact->laws.push_back(law);
}

double Plant::relative_speed(const DryContact& contact, double u, const double* x) const {
  const double carried = contact.ratio * x[other_index(contact)];
  return u == carried ? 0.0 : u - carried;  // exact where a compiler contracts products, too
}

void Plant::bring_to_rest(const DryContact& contact, double* x) const {
  double& u = x[velocity_index(contact)];
  if (!contact.couples()) {
    u = 0.0;
  } else if (u == 0.0) {  // held by friction of its own
    x[other_index(contact)] = 0.0;
  } else {
    u = contact.ratio * x[other_index(contact)];
  }
}

std::vector<Tie> Plant::ties(const Workspace& w) const {
  std::vector<Tie> found;
  const std::size_t base = velocities();
  for (std::size_t c = 0; c < dry_.size(); ++c) {
    if (!dry_[c].couples() || w.motion[c] != stuck) continue;
    const std::size_t one = velocity_index(dry_[c]) - base, other = other_index(dry_[c]) - base;
    found.push_back({static_cast<int>(one), static_cast<int>(other), dry_[c].ratio, c});
  }
  return found;
}

// What the contact on one velocity can hold; nothing where there is none.
Box Plant::box_at(const Workspace& w, int velocity, double t, const double* x) const {
  const std::size_t at = static_cast<std::size_t>(velocity) + velocities();
  for (std::size_t c = 0; c < dry_.size(); ++c) {
    if (!dry_[c].couples() && velocity_index(dry_[c]) == at) return {level(w, c, t, x, -1.0), level(w, c, t, x, 1.0)};
  }
  return {};
}

void Plant::tied_solve(Workspace& w, const std::vector<Tie>& ties, double t, const double* x) const {
  const int N = velocities();
  RowMatrix H(N, N);
  VectorXd b(N);
  inertia(w, x, H.data());
  bias(w, x, b.data());
  b = Map<const VectorXd>(w.drive.data(), N) - b;
  const MatrixXd T = free_moves(w.held, ties);
  VectorXd a = VectorXd::Zero(N);
  if (T.cols() > 0) a = T * MatrixXd(T.transpose() * H * T).partialPivLu().solve(VectorXd(T.transpose() * b));
  Map<VectorXd>(w.acceleration.data(), N) = a;
  Map<VectorXd>(w.reaction.data(), N) = b - H * a;
  for (const Tie& tie : ties) {
    const Box own{level(w, tie.contact, t, x, -1.0), level(w, tie.contact, t, x, 1.0)};
    w.friction[tie.contact] = take_share(tie, w.held, own, box_at(w, tie.one, t, x), box_at(w, tie.other, t, x),
                                         w.reaction[tie.one], w.reaction[tie.other]);
  }
  for (std::size_t c = 0; c < dry_.size(); ++c) {
    if (w.motion[c] != stuck) continue;
    if (!dry_[c].couples()) w.friction[c] = w.reaction[velocity_index(dry_[c]) - N];
    rub(w, c);
  }
}

// Rows of v' where couplings stick: what moves as one has one acceleration.
void Plant::tied_slopes(const Workspace& w, const std::vector<Tie>& ties, const double* M_all, const double* right_all,
                        double* out) const {
  const int size = state_size(), N = velocities();
  Map<RowMatrix> J(out, size, size);
  RowMatrix force(N, size);
  MatrixXd H = MatrixXd::Zero(N, N);
  H.topLeftCorner(n_, n_) = Map<const RowMatrix>(M_all, n_, n_);
  force.topRows(n_) = Map<const RowMatrix>(right_all, n_, size);
  for (int e = 0; e < elastic(); ++e) {
    H(n_ + e, n_ + e) = J_[elastic_[e]];
    force.row(n_ + e) = J_[elastic_[e]] * J.row(N + n_ + e);
  }
  const MatrixXd T = free_moves(w.held, ties);
  RowMatrix rows = RowMatrix::Zero(N, size);
  if (T.cols() > 0) rows = T * MatrixXd(T.transpose() * H * T).partialPivLu().solve(MatrixXd(T.transpose() * force));
  J.middleRows(N, N) = rows;
}

// Smoothed friction of couplings sees both motors.
void Plant::couple_dry(const Workspace& w, double t, const double* x, double* right, double* J) const {
  if (w.located || !couplings_ || !std::isfinite(w.smoothing)) return;
  const int N = velocities(), size = state_size();
  for (std::size_t c = 0; c < dry_.size(); ++c) {
    const DryContact& dry = dry_[c];
    if (!dry.couples()) continue;
    const double u = contact_speed(dry, x), sign = smooth_sign(u, w.smoothing);
    const double slope = level(w, c, t, x, u < 0.0 ? -1.0 : 1.0) * (1.0 - sign * sign) / w.smoothing;
    const std::size_t column[2] = {velocity_index(dry), other_index(dry)};
    const double gain[2] = {1.0, -dry.ratio};
    const int joint[2] = {dry.joint, dry.other};
    for (int i = 0; i < 2; ++i) {
      const int slot = rotor_slot_[joint[i]];
      double* row = slot < 0 ? right + static_cast<std::ptrdiff_t>(joint[i]) * size
                             : J + static_cast<std::ptrdiff_t>(N + n_ + slot) * size;
      for (int k = 0; k < 2; ++k) row[column[k]] -= gain[i] * gain[k] * slope / (slot < 0 ? 1.0 : J_[joint[i]]);
    }
  }
}

void Plant::visit_spans(const Workspace& w, double t, const double* x, const VisitSpan& visit) const {
  constexpr double h = 6e-6;  // central differences of a smooth piece
  for (const Law& law : link_) {
    if (law.row.empty()) continue;
    const LawInput in = input(w, law, t, x);
    const int region = region_at(w, law, in);
    LawInput up = in, down = in;
    up.x += h;
    down.x -= h;
    const double by_x = (link_torque(law.kind, law.p, up, region) - link_torque(law.kind, law.p, down, region)) / (2 * h);
    up = down = in;
    up.u += h;
    down.u -= h;
    const double by_u = (link_torque(law.kind, law.p, up, region) - link_torque(law.kind, law.p, down, region)) / (2 * h);
    visit(law.row, by_x, by_u);
  }
}

void Plant::limit_currents(double* x) const {
  if (!windings_) return;
  double* state = x + 2 * velocities();
  for (const Law& law : actuator_) {
    const double limit = winding_limit(law.p);
    if (law.state >= 0) state[law.state] = std::clamp(state[law.state], -limit, limit);
  }
}

double Plant::magnetic_energy(const double* x) const {
  double sum = 0.0;
  for (const Law& law : actuator_) {
    if (law.state >= 0) sum += 0.5 * winding_inductance(law.p) * z(x)[law.state] * z(x)[law.state];
  }
  return sum;
}

}  // namespace flexdyn
