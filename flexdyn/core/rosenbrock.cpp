// RODAS: a Rosenbrock method of order 4(3), L-stable and stiffly accurate, six stages, one factorisation a step.
//
// Source: Hairer, Wanner, Solving Ordinary Differential Equations II (2nd ed.), IV.7 and VI.4 (code RODAS).
#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

#include "matrices.hpp"
#include "steppers.hpp"

namespace flexdyn {

namespace {

constexpr int stages = 6;
constexpr double gamma_ = 0.25;
constexpr double a[stages][5] = {
    {},
    {1.544},
    {0.9466785280815826, 0.2557011698983284},
    {3.314825187068521, 2.896124015972201, 0.9986419139977817},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0}};
constexpr double c[stages][5] = {
    {},
    {-5.6688},
    {-2.430093356833875, -0.2063599157091915},
    {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
    {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
    {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054}};
constexpr double alpha[stages] = {0.0, 0.386, 0.21, 0.63, 1.0, 1.0};
constexpr double dt_weight[stages] = {0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0};
constexpr double dense_a[5] = {10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823,
                               1.025137723295662};
constexpr double dense_b[5] = {-0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386,
                               -6.594389125716872};

class Rosenbrock : public Stepper {
 public:
  Rosenbrock(RightHandSide f, Jacobian jacobian, double rtol, double atol, double max_step)
      : f_(std::move(f)), jacobian_(std::move(jacobian)), rtol_(rtol), atol_(atol), max_step_(max_step) {}

  void start(double t, const std::vector<double>& x) override {
    t_ = t;
    x_ = before_ = x;
    const auto size = static_cast<Eigen::Index>(x.size());
    J_.resize(size, size);
    for (auto& u : u_) u.resize(size);
    f0_.resize(size);
    ft_.resize(size);
    value_.resize(size);
    stage_.resize(size);
    h_ = 0.0;
    fresh_ = true;
  }

  void restart() override { fresh_ = true; }

  bool step(double limit, Failure& failure) override {
    if (fresh_) linearise(limit);
    if (h_ == 0.0) h_ = std::min(1e-6, limit - t_);
    while (true) {
      const StepPlan plan = plan_step(std::min(h_, max_step_), limit - t_);
      const double h = plan.h;
      const bool last = plan.last;
      if (plan.vanishes(t_)) {
        failure = {"the step fell below what time can resolve: the motion is not finite", t_};
        return false;
      }
      const double error = try_step(h, last ? limit : t_ + h);
      const double scale = std::isfinite(error) ? std::clamp(0.9 * std::pow(std::max(error, 1e-12), -0.25), 0.2, 6.0) : 0.1;
      if (error <= 1.0) {
        accept(h, last ? limit : t_ + h);
        h_ = std::max(h * scale, h < h_ ? h_ : 0.0);
        return true;
      }
      stats_.rejected += 1;
      h_ = h * std::min(scale, 0.9);
      if (!(h_ > 0.0)) {
        failure = {"the motion is not finite", t_};
        return false;
      }
    }
  }

  void interpolate(double t, double* x) override {
    const double s = (t - t_before_) / h_last_, r = 1.0 - s;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      x[i] = before_[i] + s * (x_[i] - before_[i] + r * (bend_[k] + s * twist_[k]));
    }
  }

 private:
  // f, df/dx and df/dt at the start of a step; t_ is kept inside the interval begun last.
  void linearise(double limit) {
    f_(t_, x_.data(), f0_.data());
    jacobian_(t_, x_.data(), J_.data());
    const double delta = std::min(1e-6 * std::max(1.0, std::abs(t_)), 0.5 * (limit - t_));
    f_(t_ + delta, x_.data(), ft_.data());
    ft_ = (ft_ - f0_) / delta;
    stats_.evaluations += 2;
    fresh_ = false;
    find_resting();
  }

  // Entries that do not change because nothing they depend on does, such as what friction holds. Elimination with
  // pivoting would mix their rows with those that move, and they would creep by rounding.
  void find_resting() {
    const Eigen::Index size = f0_.size();
    resting_.assign(static_cast<std::size_t>(size), 0);
    for (Eigen::Index i = 0; i < size; ++i) resting_[i] = f0_[i] == 0.0 && ft_[i] == 0.0;
    for (bool changed = true; changed;) {
      changed = false;
      for (Eigen::Index i = 0; i < size; ++i) {
        for (Eigen::Index j = 0; resting_[i] && j < size; ++j) {
          if (J_(i, j) == 0.0 || resting_[j]) continue;
          resting_[i] = 0;
          changed = true;
        }
      }
    }
  }

  double try_step(double h, double end) {
    const auto size = static_cast<Eigen::Index>(x_.size());
    const Map<const VectorXd> x(x_.data(), size);
    MatrixXd system = -J_;
    system.diagonal().array() += 1.0 / (h * gamma_);
    factor_.compute(system);
    for (int s = 0; s < stages; ++s) {
      if (s == 0) {
        value_ = f0_;
      } else {
        stage_ = x;
        for (int j = 0; j < s; ++j) stage_ += a[s][j] * u_[j];
        f_(alpha[s] == 1.0 ? end : t_ + alpha[s] * h, stage_.data(), value_.data());
        stats_.evaluations += 1;
      }
      for (int j = 0; j < s; ++j) value_ += (c[s][j] / h) * u_[j];
      if (dt_weight[s] != 0.0) value_ += (h * dt_weight[s]) * ft_;
      u_[s] = factor_.solve(value_);
      for (Eigen::Index i = 0; i < size; ++i) {
        if (resting_[i] && value_[i] == 0.0) u_[s][i] = 0.0;
      }
    }
    next_ = stage_ + u_[stages - 1];
    double sum = 0.0;
    for (Eigen::Index i = 0; i < size; ++i) {
      const double scale = atol_ + rtol_ * std::max(std::abs(x[i]), std::abs(next_[i]));
      sum += (u_[stages - 1][i] / scale) * (u_[stages - 1][i] / scale);
    }
    return std::sqrt(sum / static_cast<double>(size));
  }

  void accept(double h, double end) {
    bend_ = dense_a[0] * u_[0];
    twist_ = dense_b[0] * u_[0];
    for (int s = 1; s < 5; ++s) {
      bend_ += dense_a[s] * u_[s];
      twist_ += dense_b[s] * u_[s];
    }
    before_ = x_;
    Map<VectorXd>(x_.data(), next_.size()) = next_;
    t_before_ = t_;
    h_last_ = h;
    t_ = end;
    fresh_ = true;
    stats_.steps += 1;
  }

  RightHandSide f_;
  Jacobian jacobian_;
  double rtol_, atol_, max_step_;
  double h_ = 0.0, h_last_ = 0.0, t_before_ = 0.0;
  bool fresh_ = true;
  RowMatrix J_;
  Eigen::PartialPivLU<MatrixXd> factor_;
  std::array<VectorXd, stages> u_;
  VectorXd f0_, ft_, value_, stage_, next_, bend_, twist_;
  std::vector<double> before_;
  std::vector<char> resting_;
};

}  // namespace

std::unique_ptr<Stepper> make_rosenbrock(RightHandSide f, Jacobian jacobian, double rtol, double atol,
                                         double max_step) {
  return std::make_unique<Rosenbrock>(std::move(f), std::move(jacobian), rtol, atol, max_step);
}

}  // namespace flexdyn
