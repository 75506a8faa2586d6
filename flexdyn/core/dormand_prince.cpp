// Dormand-Prince 5(4) with a proportional-integral step controller and fourth-order dense output.
//
// Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (2nd ed.), II.4-II.6 (DOPRI5).
#include <algorithm>
#include <array>
#include <cmath>

#include "steppers.hpp"

namespace flexdyn {

namespace {

constexpr int stages = 7;
constexpr double c[stages] = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0};
constexpr double a[stages][6] = {
    {},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
// Difference of the fifth- and the fourth-order result.
constexpr double e[stages] = {71.0 / 57600,      0.0,          -71.0 / 16695, 71.0 / 1920,
                              -17253.0 / 339200, 22.0 / 525,   -1.0 / 40};
constexpr double d[stages] = {-12715105075.0 / 11282082432.0, 0.0, 87487479700.0 / 32700410799.0,
                              -10690763975.0 / 1880347072.0,  701980252875.0 / 199316789632.0,
                              -1453857185.0 / 822651844.0,    69997945.0 / 29380423.0};

class DormandPrince : public Stepper {
 public:
  DormandPrince(RightHandSide f, double rtol, double atol, double max_step)
      : f_(std::move(f)), rtol_(rtol), atol_(atol), max_step_(max_step) {}

  void start(double t, const std::vector<double>& x) override {
    t_ = t;
    x_ = before_ = stage_ = next_ = x;
    for (auto& k : k_) k.assign(x.size(), 0.0);
    h_ = 0.0;
    fresh_ = true;
  }

  void restart() override { fresh_ = true; }

  bool step(double limit, Failure& failure) override {
    if (fresh_) evaluate(0, t_, x_);
    fresh_ = false;
    if (h_ == 0.0) h_ = initial_step(limit);
    while (true) {
      const StepPlan plan = plan_step(std::min({h_, max_step_, stable_step_}), limit - t_);
      const double h = plan.h;
      const bool last = plan.last;
      if (plan.vanishes(t_)) {
        failure = {"the step fell below what time can resolve: the motion is too stiff or not finite", t_};
        return false;
      }
      try_step(h, last ? limit : t_ + h);
      const double error = error_norm();
      if (error <= 1.0) {
        accept(h, last ? limit : t_ + h, error);
        return true;
      }
      stats_.rejected += 1;
      h_ = std::isfinite(error) ? h * std::max(0.2, 0.9 * std::pow(error, -0.2)) : 0.1 * h;
      if (!(h_ > 0.0)) {
        failure = {"the motion is not finite", t_};
        return false;
      }
    }
  }

  void interpolate(double t, double* x) override {
    const double s = (t - t_before_) / h_last_, r = 1.0 - s;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const double difference = x_[i] - before_[i];
      const double bump = h_last_ * first_[i] - difference;
      const double tail = difference - h_last_ * k_[0][i] - bump;
      x[i] = before_[i] + s * (difference + r * (bump + s * (tail + r * dense_[i])));
    }
  }

 private:
  void evaluate(int stage, double t, const std::vector<double>& x) {
    f_(t, x.data(), k_[stage].data());
    stats_.evaluations += 1;
  }

  void try_step(double h, double end) {
    const std::size_t size = x_.size();
    for (int s = 1; s < stages; ++s) {
      std::vector<double>& target = s == stages - 1 ? next_ : stage_;
      for (std::size_t i = 0; i < size; ++i) {
        double sum = 0.0;
        for (int j = 0; j < s; ++j) sum += a[s][j] * k_[j][i];
        target[i] = x_[i] + h * sum;
      }
      evaluate(s, c[s] == 1.0 ? end : t_ + c[s] * h, target);
    }
    h_try_ = h;
  }

  double error_norm() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      double error = 0.0;
      for (int s = 0; s < stages; ++s) error += e[s] * k_[s][i];
      const double scale = atol_ + rtol_ * std::max(std::abs(x_[i]), std::abs(next_[i]));
      sum += (h_try_ * error / scale) * (h_try_ * error / scale);
    }
    return std::sqrt(sum / static_cast<double>(x_.size()));
  }

  void accept(double h, double end, double error) {
    dense_.resize(x_.size());
    for (std::size_t i = 0; i < x_.size(); ++i) {
      double sum = 0.0;
      for (int s = 0; s < stages; ++s) sum += d[s] * k_[s][i];
      dense_[i] = h * sum;
    }
    first_ = k_[0];
    t_before_ = t_;
    h_last_ = h;
    before_.swap(x_);
    x_ = next_;
    t_ = end;
    std::swap(k_[0], k_[stages - 1]);  // first same as last
    stats_.steps += 1;
    const double bounded = std::max(error, 1e-10);
    const double grow = 0.9 * std::pow(bounded, -0.17) * std::pow(previous_error_, 0.04);
    // A step cut short by the limit says nothing against the longer one that was meant.
    h_ = std::max(h * std::clamp(grow, 0.2, 10.0), h < h_ && error <= 1.0 ? h_ : 0.0);
    previous_error_ = std::max(error, 1e-4);
  }

  double initial_step(double limit) {
    double size = 0.0, slope = 0.0;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const double scale = atol_ + rtol_ * std::abs(x_[i]);
      size += (x_[i] / scale) * (x_[i] / scale);
      slope += (k_[0][i] / scale) * (k_[0][i] / scale);
    }
    const double guess = size < 1e-10 || slope < 1e-10 ? 1e-6 : 0.01 * std::sqrt(size / slope);
    return std::min({guess, max_step_, limit - t_});
  }

  RightHandSide f_;
  double rtol_, atol_, max_step_;
  double h_ = 0.0, h_try_ = 0.0, h_last_ = 0.0, t_before_ = 0.0, previous_error_ = 1e-4;
  bool fresh_ = true;
  std::array<std::vector<double>, stages> k_;
  std::vector<double> before_, next_, stage_, first_, dense_;
};

}  // namespace

std::unique_ptr<Stepper> make_dormand_prince(RightHandSide f, double rtol, double atol, double max_step) {
  return std::make_unique<DormandPrince>(std::move(f), rtol, atol, max_step);
}

}  // namespace flexdyn
