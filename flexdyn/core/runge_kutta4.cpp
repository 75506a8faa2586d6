// The classical fourth-order method at a fixed step.

#include "steppers.hpp"

namespace flexdyn {

namespace {

class RungeKutta4 : public Stepper {
 public:
  RungeKutta4(RightHandSide f, double step) : f_(std::move(f)), grid_(step) {}

  void start(double t, const std::vector<double>& x) override {
    t_ = t;
    x_ = before_ = stage_ = x;
    for (auto* k : {&k1_, &k2_, &k3_, &k4_}) k->assign(x.size(), 0.0);
    grid_.restart(t);
  }

  void restart() override { grid_.restart(t_); }

  bool step(double limit, Failure&) override {
    const double end = grid_.next(t_, limit);
    before_ = x_;
    t_before_ = t_;
    h_ = grid_.h();
    const std::size_t size = x_.size();
    f_(t_, x_.data(), k1_.data());
    for (std::size_t i = 0; i < size; ++i) stage_[i] = x_[i] + 0.5 * h_ * k1_[i];
    f_(t_ + 0.5 * h_, stage_.data(), k2_.data());
    for (std::size_t i = 0; i < size; ++i) stage_[i] = x_[i] + 0.5 * h_ * k2_[i];
    f_(t_ + 0.5 * h_, stage_.data(), k3_.data());
    for (std::size_t i = 0; i < size; ++i) stage_[i] = x_[i] + h_ * k3_[i];
    f_(end, stage_.data(), k4_.data());
    for (std::size_t i = 0; i < size; ++i) x_[i] += h_ / 6.0 * (k1_[i] + 2.0 * (k2_[i] + k3_[i]) + k4_[i]);
    t_ = end;
    stats_.steps += 1;
    stats_.evaluations += 4;
    return true;
  }

  // Its own continuous extension: of order 3, whose error is of the method's own, h^4 (Hairer, Norsett, Wanner, II.6).
  void interpolate(double t, double* x) override {
    const double s = (t - t_before_) / h_, ss = s * s;
    const double first = h_ * (s - ss * (1.5 - 2.0 / 3.0 * s)), middle = h_ * ss * (1.0 - 2.0 / 3.0 * s);
    const double last = h_ * ss * (2.0 / 3.0 * s - 0.5);
    for (std::size_t i = 0; i < x_.size(); ++i) {
      x[i] = before_[i] + first * k1_[i] + middle * (k2_[i] + k3_[i]) + last * k4_[i];
    }
  }

 private:
  RightHandSide f_;
  EqualSteps grid_;
  double h_ = 0.0, t_before_ = 0.0;
  std::vector<double> before_, stage_, k1_, k2_, k3_, k4_;
};

}  // namespace

std::unique_ptr<Stepper> make_runge_kutta4(RightHandSide f, double step) {
  return std::make_unique<RungeKutta4>(std::move(f), step);
}

}  // namespace flexdyn
