// What the files of LinkDynamics share: Pinocchio's model and data behind it. Nobody else includes this.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include <Eigen/Cholesky>

#include "joint_collection.hpp"
#include "link_dynamics.hpp"
#include "matrices.hpp"

namespace flexdyn {

namespace pin = pinocchio;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct LinkDynamics::Impl {
  // The independent joints' numbers as those of the whole tree.
  void expand_position(const double* q, VectorXd& tree) const {
    if (mimics) tree.noalias() = gain * Map<const VectorXd>(q, gain.cols()) + offset;
    else tree = Map<const VectorXd>(q, gain.cols());
  }
  void expand_rate(const double* v, VectorXd& tree) const {
    if (mimics) tree.noalias() = gain * Map<const VectorXd>(v, gain.cols());
    else tree = Map<const VectorXd>(v, gain.cols());
  }
  // A row-major matrix of the whole tree as that of the independent joints, gain^T matrix gain. (Eigen's blocked
  // products would take longer to compile, and no less time for so few joints.)
  void project(const double* matrix, double* result) const {
    const Map<const RowMatrix> tree(matrix, gain.rows(), gain.rows());
    Map<RowMatrix> independent(result, gain.cols(), gain.cols());
    if (mimics) independent = gain.transpose().lazyProduct(tree.lazyProduct(gain).eval());
    else independent = tree;
  }

  std::vector<char> prismatic;
  std::vector<Vector3d> axis;  // in the joint's own axes
  std::vector<int> own_row;  // independent joint -> its own row in the tree, not that of one that mimics it
  Model model;
  MatrixXd gain;
  VectorXd offset;
  bool mimics = false;
};

struct LinkDynamics::Workspace {
  explicit Workspace(const Impl& impl, int n)
      : data(impl.model), M(n, n), h(n), factor(n), q(impl.offset), v(impl.offset), a(impl.offset),
        tau(impl.offset), pulls(impl.model.joints.size()), free(n) {}
  Data data;
  MatrixXd M;
  VectorXd h;
  MatrixXd M_free;        // rows and columns of M of the joints that are not held
  VectorXd a_free;
  Eigen::LLT<MatrixXd> factor;
  VectorXd q, v, a;       // of the whole tree, mimic joints included
  VectorXd tau;
  std::vector<pin::Force> pulls;  // on every body of the tree
  std::vector<int> free;  // joints that are not held
};

struct LinkDynamics::Kept {
  std::mutex mutex;
  std::vector<std::unique_ptr<Workspace>> unused;
};

}  // namespace flexdyn
