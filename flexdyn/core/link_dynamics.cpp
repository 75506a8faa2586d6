// Building the arm, and its forward dynamics. ABA stands in a file of its own kind: the compiler inlines Pinocchio's
// small functions best where little else is instantiated.
#include <string>

#include <pinocchio/algorithm/aba.hpp>

#include "link_dynamics_impl.hpp"

namespace flexdyn {

void LinkDynamics::Deleter::operator()(Workspace* workspace) const {
  const std::lock_guard<std::mutex> lock(kept->mutex);
  kept->unused.emplace_back(workspace);
}

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

LinkDynamics::LinkDynamics(const Tree& tree) : impl_(std::make_unique<Impl>()), kept_(std::make_shared<Kept>()) {
  Impl& impl = *impl_;
  const int m = tree.size();
  for (int i = 0; i < m; ++i) {
    const auto id = add_joint(impl.model, tree, i);
    const Matrix3d inertia = Map<const RowMatrix3>(&tree.inertia[9 * i]);
    impl.model.appendBodyToJoint(id, pin::Inertia(tree.mass[i], Map<const Vector3d>(&tree.com[3 * i]), inertia));
    impl.model.armature[i] = tree.armature[i];
    impl.axis.push_back(Map<const Vector3d>(&tree.axis[3 * i]));
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

int LinkDynamics::bodies() const { return static_cast<int>(impl_->axis.size()); }

LinkDynamics::WorkspacePtr LinkDynamics::workspace() const {
  {
    const std::lock_guard<std::mutex> lock(kept_->mutex);
    if (!kept_->unused.empty()) {
      Workspace* workspace = kept_->unused.back().release();
      kept_->unused.pop_back();
      return WorkspacePtr(workspace, Deleter{kept_});
    }
  }
  return WorkspacePtr(new Workspace(*impl_, n_), Deleter{kept_});
}

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

}  // namespace flexdyn
