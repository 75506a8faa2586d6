#include "link_dynamics.hpp"

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/energy.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include <Eigen/Cholesky>

#include "joint_collection.hpp"

namespace flexdyn {

namespace pin = pinocchio;
using Eigen::Map;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct LinkDynamics::Impl {
  std::vector<char> prismatic;
  std::vector<int> own_row;  // independent joint -> its own row in the tree, not that of one that mimics it
  Model model;
  MatrixXd gain;
  VectorXd offset;
  bool mimics = false;
};

struct LinkDynamics::Workspace {
  explicit Workspace(const Impl& impl, int n)
      : data(impl.model), M(n, n), h(n), factor(n), q(impl.offset), v(impl.offset), a(impl.offset), free(n) {}
  Data data;
  MatrixXd M;
  VectorXd h;
  Eigen::LLT<MatrixXd> factor;
  VectorXd q, v, a;       // of the whole tree, mimic joints included
  std::vector<int> free;  // joints that are not held
};

void LinkDynamics::Deleter::operator()(Workspace* workspace) const { delete workspace; }

namespace {

pin::JointIndex add_joint(Model& model, const Tree& tree, int i) {
  const RowMatrix3 rotation = Map<const RowMatrix3>(&tree.rotation[9 * i]);
  const Vector3d translation = Map<const Vector3d>(&tree.translation[3 * i]);
  const Vector3d axis = Map<const Vector3d>(&tree.axis[3 * i]);
  const pin::SE3 placement(rotation, translation);
  const auto parent = static_cast<pin::JointIndex>(tree.parent[i] + 1);
  const std::string name = std::to_string(i);
  if (tree.prismatic[i]) {
    return model.addJoint(parent, Joints::JointModelPrismaticUnaligned(axis), placement, name);
  }
  // Aligned axes have cheaper kinematics; the unaligned joint is right for every other axis.
  if (axis == Vector3d::UnitX()) return model.addJoint(parent, Joints::JointModelRX(), placement, name);
  if (axis == Vector3d::UnitY()) return model.addJoint(parent, Joints::JointModelRY(), placement, name);
  if (axis == Vector3d::UnitZ()) return model.addJoint(parent, Joints::JointModelRZ(), placement, name);
  return model.addJoint(parent, Joints::JointModelRevoluteUnaligned(axis), placement, name);
}

// Direction in which a joint turns or slides, in the axes of the base.
Vector3d world_axis(const Data& data, pin::JointIndex joint) {
  const Eigen::Matrix<double, 6, 1> S = data.joints[joint].S().matrix().col(0);
  return data.oMi[joint].rotation() * (S.tail<3>().isZero() ? S.head<3>() : S.tail<3>());
}

}  // namespace

LinkDynamics::LinkDynamics(const Tree& tree) : impl_(std::make_unique<Impl>()) {
  Impl& impl = *impl_;
  const int m = tree.size();
  for (int i = 0; i < m; ++i) {
    const auto id = add_joint(impl.model, tree, i);
    const Matrix3d inertia = Map<const RowMatrix3>(&tree.inertia[9 * i]);
    impl.model.appendBodyToJoint(id, pin::Inertia(tree.mass[i], Map<const Vector3d>(&tree.com[3 * i]), inertia));
    impl.model.armature[i] = tree.armature[i];
  }
  impl.model.gravity.linear() = Map<const Vector3d>(tree.gravity);
  n_ = m == 0 ? 0 : static_cast<int>(tree.gain.size()) / m;
  impl.gain = Map<const RowMatrix>(tree.gain.data(), m, n_);
  impl.offset = Map<const VectorXd>(tree.offset.data(), m);
  impl.prismatic = tree.prismatic;
  for (int j = 0; j < n_; ++j) {
    int row = 0;
    while (row < m - 1 && !(impl.offset[row] == 0.0 && impl.gain.row(row).transpose() == VectorXd::Unit(n_, j))) ++row;
    impl.own_row.push_back(row);
  }
  impl.mimics = !(m == n_ && impl.gain.isIdentity(0.0) && impl.offset.isZero(0.0));
}

LinkDynamics::~LinkDynamics() = default;

LinkDynamics::WorkspacePtr LinkDynamics::workspace() const { return WorkspacePtr(new Workspace(*impl_, n_)); }

void LinkDynamics::acceleration(Workspace& w, const double* q, const double* v, const double* tau, double* a) const {
  Map<VectorXd> result(a, n_);
  if (!impl_->mimics) {
    result = pin::aba(impl_->model, w.data, Map<const VectorXd>(q, n_), Map<const VectorXd>(v, n_),
                      Map<const VectorXd>(tau, n_), pin::Convention::LOCAL);
    return;
  }
  // Pinocchio's ABA takes no mimic joints: project M and h of the whole tree on the independent joints.
  RowMatrix M(n_, n_);
  mass_matrix(w, q, M.data());
  bias(w, q, v, w.h.data());
  w.factor.compute(M);
  result = w.factor.solve(Map<const VectorXd>(tau, n_) - w.h);
}

void LinkDynamics::held_acceleration(Workspace& w, const double* q, const double* v, const double* tau,
                                     const char* held, double* a, double* reaction) const {
  mass_matrix(w, q, w.M.data());  // symmetric: row-major or column-major is the same
  bias(w, q, v, w.h.data());
  w.h = Map<const VectorXd>(tau, n_) - w.h;
  int free = 0;
  for (int j = 0; j < n_; ++j) {
    if (!held[j]) w.free[free++] = j;
  }
  MatrixXd M(free, free);
  VectorXd b(free);
  for (int i = 0; i < free; ++i) {
    b[i] = w.h[w.free[i]];
    for (int k = 0; k < free; ++k) M(i, k) = w.M(w.free[i], w.free[k]);
  }
  const VectorXd moving = free > 0 ? VectorXd(M.llt().solve(b)) : b;
  std::fill(a, a + n_, 0.0);
  for (int i = 0; i < free; ++i) a[w.free[i]] = moving[i];
  for (int j = 0; j < n_; ++j) {
    if (!held[j]) continue;
    double coupling = 0.0;
    for (int i = 0; i < free; ++i) coupling += w.M(j, w.free[i]) * moving[i];
    reaction[j] = w.h[j] - coupling;
  }
}

void LinkDynamics::mass_matrix(Workspace& w, const double* q, double* M) const {
  w.q.noalias() = impl_->gain * Map<const VectorXd>(q, n_) + impl_->offset;
  pin::crba(impl_->model, w.data, w.q, pin::Convention::WORLD);
  w.data.M.triangularView<Eigen::StrictlyLower>() = w.data.M.transpose().triangularView<Eigen::StrictlyLower>();
  Map<RowMatrix>(M, n_, n_) = impl_->gain.transpose() * w.data.M * impl_->gain;
}

void LinkDynamics::bias(Workspace& w, const double* q, const double* v, double* h) const {
  w.q.noalias() = impl_->gain * Map<const VectorXd>(q, n_) + impl_->offset;
  w.v.noalias() = impl_->gain * Map<const VectorXd>(v, n_);
  Map<VectorXd>(h, n_) = impl_->gain.transpose() * pin::nonLinearEffects(impl_->model, w.data, w.q, w.v);
}

void LinkDynamics::inverse_derivatives(Workspace& w, const double* q, const double* v, const double* a, double* by_q,
                                       double* by_v) const {
  const MatrixXd& gain = impl_->gain;
  w.q.noalias() = gain * Map<const VectorXd>(q, n_) + impl_->offset;
  w.v.noalias() = gain * Map<const VectorXd>(v, n_);
  w.a.noalias() = gain * Map<const VectorXd>(a, n_);
  pin::computeRNEADerivatives(impl_->model, w.data, w.q, w.v, w.a);
  Map<RowMatrix>(by_q, n_, n_) = gain.transpose() * w.data.dtau_dq * gain;
  Map<RowMatrix>(by_v, n_, n_) = gain.transpose() * w.data.dtau_dv * gain;
}

void LinkDynamics::rotor_coupling(Workspace& w, const double* q, const double* v, const double* spin,
                                  const double* omega, double* S, double* link_bias, double* rotor_bias) const {
  const MatrixXd& gain = impl_->gain;
  w.q.noalias() = gain * Map<const VectorXd>(q, n_) + impl_->offset;
  w.v.noalias() = gain * Map<const VectorXd>(v, n_);
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
  w.q.noalias() = impl_->gain * Map<const VectorXd>(q, n_) + impl_->offset;
  w.v.noalias() = impl_->gain * Map<const VectorXd>(v, n_);
  kinetic = pin::computeKineticEnergy(impl_->model, w.data, w.q, w.v);
  potential = pin::computePotentialEnergy(impl_->model, w.data, w.q);
}

void LinkDynamics::add_wrench(Workspace& w, const double* q, const WrenchPoint& point, const double* wrench,
                              double* tau) const {
  if (point.joint < 0) return;  // the base does not move
  const Model& model = impl_->model;
  w.q.noalias() = impl_->gain * Map<const VectorXd>(q, n_) + impl_->offset;
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
