// The terms of the link side one by one: M, h, their derivatives, energies, wrenches, rotors that ride on links.
#include <algorithm>

#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/energy.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "link_dynamics_impl.hpp"

namespace flexdyn {

namespace {

// Direction in which a joint turns or slides, in the axes of the base.
Vector3d world_axis(const Data& data, pin::JointIndex joint) {
  const Eigen::Matrix<double, 6, 1> S = data.joints[joint].S().matrix().col(0);
  return data.oMi[joint].rotation() * (S.tail<3>().isZero() ? S.head<3>() : S.tail<3>());
}

// What a body of given mass, first moment and inertia about the origin asks for, by its velocity and its acceleration
// less gravity's: I a + v x* (I v), all in its own axes.
pin::Force pull(const double* body, const pin::Motion& v, const pin::Motion& a) {
  const double mass = body[0];
  const Map<const Vector3d> moment(body + 1);
  Matrix3d inertia;
  inertia << body[4], body[5], body[7], body[5], body[6], body[8], body[7], body[8], body[9];
  const Vector3d w = v.angular(), p = mass * v.linear() + w.cross(moment);
  const Vector3d L = inertia * w + moment.cross(v.linear());
  return pin::Force(mass * a.linear() + a.angular().cross(moment) + w.cross(p),
                    inertia * a.angular() + moment.cross(a.linear()) + w.cross(L) + v.linear().cross(p));
}

}  // namespace

void LinkDynamics::held_acceleration(Workspace& w, const double* q, const double* v, const double* tau,
                                     const char* held, double* a, double* reaction) const {
  mass_matrix(w, q, w.M.data());  // symmetric: row-major or column-major is the same
  bias(w, q, v, w.h.data());
  w.h = Map<const VectorXd>(tau, n_) - w.h;
  int free = 0;
  for (int j = 0; j < n_; ++j) {
    if (!held[j]) w.free[free++] = j;
  }
  w.M_free.resize(free, free);
  w.a_free.resize(free);
  for (int i = 0; i < free; ++i) {
    w.a_free[i] = w.h[w.free[i]];
    for (int k = 0; k < free; ++k) w.M_free(i, k) = w.M(w.free[i], w.free[k]);
  }
  if (free > 0) w.factor.compute(w.M_free).solveInPlace(w.a_free);
  std::fill(a, a + n_, 0.0);
  for (int i = 0; i < free; ++i) a[w.free[i]] = w.a_free[i];
  for (int j = 0; j < n_; ++j) {
    if (!held[j]) continue;
    double coupling = 0.0;
    for (int i = 0; i < free; ++i) coupling += w.M(j, w.free[i]) * w.a_free[i];
    reaction[j] = w.h[j] - coupling;
  }
}

void LinkDynamics::mass_matrix(Workspace& w, const double* q, double* M) const {
  impl_->expand_position(q, w.q);
  pin::crba(impl_->model, w.data, w.q, pin::Convention::WORLD);
  w.data.M.triangularView<Eigen::StrictlyLower>() = w.data.M.transpose().triangularView<Eigen::StrictlyLower>();
  impl_->project(w.data.M.data(), M);  // symmetric, so that its order does not matter
}

void LinkDynamics::bias(Workspace& w, const double* q, const double* v, double* h) const {
  impl_->expand_position(q, w.q);
  impl_->expand_rate(v, w.v);
  const auto& whole = pin::nonLinearEffects(impl_->model, w.data, w.q, w.v);
  if (impl_->mimics) Map<VectorXd>(h, n_) = impl_->gain.transpose() * whole;
  else Map<VectorXd>(h, n_) = whole;
}

void LinkDynamics::inverse_dynamics(Workspace& w, const double* q, const double* v, const double* a,
                                    double* tau) const {
  impl_->expand_position(q, w.q);
  impl_->expand_rate(v, w.v);
  impl_->expand_rate(a, w.a);
  const auto& whole = pin::rnea(impl_->model, w.data, w.q, w.v, w.a);
  if (impl_->mimics) Map<VectorXd>(tau, n_) = impl_->gain.transpose() * whole;
  else Map<VectorXd>(tau, n_) = whole;
}

void LinkDynamics::inertial_torques(Workspace& w, const double* q, const double* v, const double* a, const double* more,
                                    int count, double* tau) const {
  constexpr int numbers = inertial_parameters;
  inverse_dynamics(w, q, v, a, tau);  // leaves velocities and accelerations of all bodies behind
  const int m = static_cast<int>(impl_->axis.size());
  for (int k = 0; k < count; ++k, more += numbers * m) {
    for (int i = 0; i < m; ++i) {
      const double* body = more + numbers * i;
      const bool none = std::all_of(body, body + 10, [](double x) { return x == 0.0; });
      w.pulls[i] = none ? pin::Force::Zero() : pull(body, w.data.v[i + 1], w.data.a_gf[i + 1]);
    }
    for (int i = m - 1; i >= 0; --i) {
      const auto parent = impl_->model.parents[i + 1];
      const pin::Force& force = w.pulls[i];
      w.tau[i] = impl_->axis[i].dot(impl_->prismatic[i] ? force.linear() : force.angular());
      w.tau[i] += more[numbers * i + 10] * (impl_->mimics ? w.a[i] : a[i]);
      if (parent > 0) w.pulls[parent - 1] += w.data.liMi[i + 1].act(force);
    }
    Map<VectorXd> result(tau + k * n_, n_);
    if (impl_->mimics) result = impl_->gain.transpose() * w.tau;
    else result = w.tau;
  }
}

void LinkDynamics::inverse_derivatives(Workspace& w, const double* q, const double* v, const double* a, double* by_q,
                                       double* by_v) const {
  impl_->expand_position(q, w.q);
  impl_->expand_rate(v, w.v);
  impl_->expand_rate(a, w.a);
  pin::computeRNEADerivatives(impl_->model, w.data, w.q, w.v, w.a);
  static_assert(decltype(w.data.dtau_dq)::IsRowMajor && decltype(w.data.dtau_dv)::IsRowMajor);
  impl_->project(w.data.dtau_dq.data(), by_q);
  impl_->project(w.data.dtau_dv.data(), by_v);
}

void LinkDynamics::rotor_coupling(Workspace& w, const double* q, const double* v, const double* spin,
                                  const double* omega, double* S, double* link_bias, double* rotor_bias) const {
  const MatrixXd& gain = impl_->gain;
  impl_->expand_position(q, w.q);
  impl_->expand_rate(v, w.v);
  w.a.setZero();
  pin::forwardKinematics(impl_->model, w.data, w.q, w.v, w.a);
  Map<RowMatrix> coupling(S, n_, n_);
  Map<VectorXd> on_links(link_bias, n_), on_rotors(rotor_bias, n_);
  coupling.setZero();
  on_links.setZero();
  on_rotors.setZero();
  for (int i = 0; i < n_; ++i) {
    if (spin[i] == 0.0) continue;
    const auto own = static_cast<pin::JointIndex>(impl_->own_row[i] + 1), parent = impl_->model.parents[own];
    if (parent == 0) continue;  // it rides on the base
    const Vector3d axis = world_axis(w.data, own);
    const Matrix3d& R = w.data.oMi[parent].rotation();
    const Vector3d turning = R * w.data.v[parent].angular(), gyration = turning.cross(axis);
    on_rotors[i] = spin[i] * axis.dot(R * w.data.a[parent].angular());
    for (pin::JointIndex k = parent; k > 0; k = impl_->model.parents[k]) {
      if (impl_->prismatic[k - 1]) continue;
      const Vector3d link_axis = world_axis(w.data, k);
      const auto row = gain.row(static_cast<Eigen::Index>(k) - 1).transpose();
      coupling.col(i) += spin[i] * link_axis.dot(axis) * row;
      on_links += spin[i] * omega[i] * link_axis.dot(gyration) * row;
    }
  }
}

void LinkDynamics::energy(Workspace& w, const double* q, const double* v, double& kinetic, double& potential) const {
  impl_->expand_position(q, w.q);
  impl_->expand_rate(v, w.v);
  kinetic = pin::computeKineticEnergy(impl_->model, w.data, w.q, w.v);
  potential = pin::computePotentialEnergy(impl_->model, w.data, w.q);
}

void LinkDynamics::add_wrench(Workspace& w, const double* q, const WrenchPoint& point, const double* wrench,
                              double* tau) const {
  if (point.joint < 0) return;  // the base does not move
  const Model& model = impl_->model;
  impl_->expand_position(q, w.q);
  pin::forwardKinematics(model, w.data, w.q);
  const auto tip = static_cast<pin::JointIndex>(point.joint + 1);
  const pin::SE3& placement = w.data.oMi[tip];
  const Vector3d at = placement.act(Vector3d(Map<const Vector3d>(point.translation)));
  const Matrix3d axes = point.world_axes ? Matrix3d(Matrix3d::Identity())
                                         : Matrix3d(placement.rotation() * Map<const RowMatrix3>(point.rotation));
  const Vector3d force = axes * Map<const Vector3d>(wrench);
  const Vector3d moment = axes * Map<const Vector3d>(wrench + 3);
  for (pin::JointIndex k = tip; k > 0; k = model.parents[k]) {
    // S in joint axes: (linear, angular) of a unit joint velocity.
    const Eigen::Matrix<double, 6, 1> S = w.data.joints[k].S().matrix().col(0);
    const Matrix3d& R = w.data.oMi[k].rotation();
    const Vector3d lever = at - w.data.oMi[k].translation();
    const double torque = (R * S.head<3>()).dot(force) + (R * S.tail<3>()).dot(moment + lever.cross(force));
    Map<VectorXd>(tau, n_) += impl_->gain.row(static_cast<Eigen::Index>(k) - 1).transpose() * torque;
  }
}

}  // namespace flexdyn
