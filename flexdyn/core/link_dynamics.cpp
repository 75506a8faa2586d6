#include "link_dynamics.hpp"

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/energy.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
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
  Model model;
  MatrixXd gain;
  VectorXd offset;
  bool mimics = false;
};

struct LinkDynamics::Workspace {
  explicit Workspace(const Impl& impl, int n)
      : data(impl.model), M(n, n), h(n), factor(n), q(impl.offset), v(impl.offset) {}
  Data data;
  MatrixXd M;
  VectorXd h;
  Eigen::LLT<MatrixXd> factor;
  VectorXd q, v;  // of the whole tree, mimic joints included
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
