// Eigen's names as the core writes them.
#pragma once

#include <Eigen/Core>

namespace flexdyn {

using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace flexdyn
