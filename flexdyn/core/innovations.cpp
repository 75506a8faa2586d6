#include "innovations.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace flexdyn {

namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;
using In = Eigen::Map<const Matrix>;
using Out = Eigen::Map<Matrix>;
using InVector = Eigen::Map<const Vector>;
using OutVector = Eigen::Map<Vector>;

template <typename Any>
void bound(Any& numbers, double limit) {
  numbers = numbers.cwiseMax(-limit).cwiseMin(limit);
}

// Inverse of the lower Cholesky factor of a covariance; of its diagonal where rounding has made it indefinite.
Matrix inverse_root(const Matrix& covariance, const InVector& sensor) {
  const Eigen::LLT<Matrix> root(covariance);
  const Eigen::Index many = covariance.rows();
  if (root.info() == Eigen::Success) return root.matrixL().solve(Matrix::Identity(many, many));
  return Matrix(covariance.diagonal().cwiseMax(sensor).cwiseSqrt().cwiseInverse().asDiagonal());
}

}  // namespace

void window_gains(const WindowResponse& window, const double* prior, const WindowGains& found) {
  const auto nx = static_cast<Eigen::Index>(window.nx), many = static_cast<Eigen::Index>(window.channels);
  Matrix P = In(prior, nx, nx);
  Matrix cross = P, first = P, moved = Matrix::Identity(nx, nx), V = Matrix::Zero(nx, nx);
  Matrix levers(static_cast<Eigen::Index>(window.blocks) * many, nx), work(nx, nx);
  for (std::size_t k = 0; k < window.blocks; ++k) {
    const auto square = k * window.nx * window.nx, tall = k * window.nx * window.channels, row = k * window.channels;
    const In F(window.flow + square, nx, nx), push(window.push + square, nx, nx);
    const InVector sensor(window.sensor + row, many);
    const Matrix C = InVector(window.counted + row, many).asDiagonal() * In(window.seen + tall, many, nx);
    work.noalias() = F * P;
    P.noalias() = work * F.transpose();
    P += push;
    work.noalias() = F * V;
    V.noalias() = work * F.transpose();
    V += push;
    cross = (cross * F.transpose()).eval();
    moved = (F * moved).eval();
    for (Matrix* each : {&P, &V, &cross, &moved}) bound(*each, window.limit);
    const Matrix PC = P * C.transpose(), XC = cross * C.transpose();
    Matrix covariance = C * PC;
    covariance.diagonal() += sensor;
    Out W(found.whitener + k * window.channels * window.channels, many, many);
    W = inverse_root(covariance, sensor);
    const Matrix inverse = W.transpose() * W;
    Out G(found.gain + tall, nx, many), G0(found.first_gain + tall, nx, many);
    G.noalias() = PC * inverse;
    G0.noalias() = XC * inverse;
    P.noalias() -= G * PC.transpose();
    first.noalias() -= G0 * XC.transpose();
    cross.noalias() -= G0 * PC.transpose();
    OutVector(found.carried + row, many) = (C * V).cwiseProduct(C).rowwise().sum();
    levers.middleRows(static_cast<Eigen::Index>(k) * many, many).noalias() = C * moved;
  }
  OutVector(found.doubt, levers.rows()) = (levers * first).cwiseProduct(levers).rowwise().sum();
}

void window_innovations(const WindowResponse& window, const KnownGains& known, const double* mean, double* first,
                        double* white) {
  const auto nx = static_cast<Eigen::Index>(window.nx), many = static_cast<Eigen::Index>(window.channels);
  OutVector error(first, nx);
  Vector now = error, innovation(many);
  for (std::size_t k = 0; k < window.blocks; ++k) {
    const auto tall = k * window.nx * window.channels, row = k * window.channels;
    now = (In(window.flow + k * window.nx * window.nx, nx, nx) * now).eval();
    innovation.noalias() = In(window.seen + tall, many, nx) * now;
    innovation = InVector(mean + row, many) - InVector(window.counted + row, many).cwiseProduct(innovation);
    now.noalias() += In(known.gain + tall, nx, many) * innovation;
    error.noalias() += In(known.first_gain + tall, nx, many) * innovation;
    bound(now, window.limit);
    bound(error, window.limit);
    OutVector(white + row, many).noalias() = In(known.whitener + k * window.channels * window.channels, many, many) *
                                             innovation;
  }
}

}  // namespace flexdyn
