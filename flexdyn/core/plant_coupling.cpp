// Full rotor coupling: the inertial terms between rotors and links that the reduced model drops.
//
//   [M(q)   S(q)] [a    ]   [h(q, v) + n(q, v, omega)]
//   [S(q)^T J   ] [alpha] + [r(q, v)                 ] = drive
//
// Source: Tomei 1991; De Luca, Book, Robots with Flexible Elements (Springer Handbook of Robotics), the complete model.
#include <algorithm>
#include <limits>

#include <Eigen/Cholesky>

#include "matrices.hpp"
#include "plant.hpp"

namespace flexdyn {

void Plant::couple_rotors(Workspace& w, const double* x) const {
  const std::size_t n = n_;
  w.S.resize(n * n);
  w.link_bias.resize(n);
  w.rotor_bias.resize(n);
  rotor(x, w.theta.data(), w.omega.data());
  links_->rotor_coupling(*w.links, x, v(x), spin_.data(), w.omega.data(), w.S.data(), w.link_bias.data(),
                         w.rotor_bias.data());
}

void Plant::inertia(Workspace& w, const double* x, double* out) const {
  const int N = velocities();
  Map<RowMatrix> H(out, N, N);
  H.setZero();
  RowMatrix M(n_, n_);
  links_->mass_matrix(*w.links, x, M.data());
  H.topLeftCorner(n_, n_) = M;
  for (int e = 0; e < elastic(); ++e) H(n_ + e, n_ + e) = J_[elastic_[e]];
  if (!coupled_) return;
  couple_rotors(w, x);
  const Map<const RowMatrix> S(w.S.data(), n_, n_);
  for (int i = 0; i < n_; ++i) {
    const int column = rotor_slot_[i] < 0 ? i : n_ + rotor_slot_[i];  // a rigid rotor turns with its link
    for (int k = 0; k < n_; ++k) {
      H(k, column) += S(k, i);
      H(column, k) += S(k, i);
    }
  }
}

void Plant::bias(Workspace& w, const double* x, double* out) const {
  std::fill(out, out + velocities(), 0.0);
  links_->bias(*w.links, x, v(x), out);
  if (!coupled_) return;
  couple_rotors(w, x);
  for (int i = 0; i < n_; ++i) {
    out[i] += w.link_bias[i];
    out[rotor_slot_[i] < 0 ? i : n_ + rotor_slot_[i]] += w.rotor_bias[i];
  }
}

void Plant::coupled_solve(Workspace& w, const double* x, const std::vector<char>& held,
                          std::vector<double>& acceleration, std::vector<double>& reaction) const {
  const int N = velocities();
  RowMatrix H(N, N);
  VectorXd b(N);
  inertia(w, x, H.data());
  bias(w, x, b.data());
  b = Map<const VectorXd>(w.drive.data(), N) - b;
  std::vector<int> free;
  for (int i = 0; i < N; ++i) {
    if (!held[i]) free.push_back(i);
  }
  VectorXd a = VectorXd::Zero(N);
  if (!free.empty()) {
    const Eigen::LLT<MatrixXd> factor(MatrixXd(H(free, free)));
    VectorXd moving = factor.solve(VectorXd(b(free)));
    // Links lighter than the rotors they carry: there is no motion, and not finite is what the march stops at.
    if (factor.info() != Eigen::Success) moving.setConstant(std::numeric_limits<double>::quiet_NaN());
    a(free) = moving;
  }
  const VectorXd rest = b - H * a;
  for (int i = 0; i < N; ++i) {
    acceleration[i] = a[i];
    if (held[i]) reaction[i] = rest[i];
  }
}

}  // namespace flexdyn
