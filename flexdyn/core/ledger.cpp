#include "ledger.hpp"

namespace flexdyn {

Ledger::Ledger(const Plant& plant, Plant::Workspace& work, Drive& drive)
    : plant_(plant), work_(work), drive_(drive), x_(plant.state_size()), dx_(plant.state_size()),
      power_(plant.ledger_size()), sums_(plant.ledger_size(), 0.0) {}

void Ledger::advance(Stepper& stepper, double t) {
  constexpr double node = 0.7745966692414834, weight[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  const double h = t - t_;
  if (h <= 0.0) return;
  if (work_.winding_step < 0.0) {
    stepper.interpolate(t_, x_.data());
    stepper.interpolate(t, dx_.data());
    for (const Law& law : plant_.actuators()) {
      if (law.state < 0) continue;
      const double before = plant_.z(x_.data())[law.state], after = plant_.z(dx_.data())[law.state];
      sums_[law.joint] += 0.5 * winding_inductance(law.p) * (after * after - before * before);
    }
  }
  for (int i = 0; i < 3; ++i) {
    const double at = t_ + 0.5 * h * (1.0 + (i - 1) * node);
    stepper.interpolate(at, x_.data());
    const double* external = drive_.external(at, x_.data());
    plant_.derivative(work_, at, x_.data(), drive_.torque(at), external, dx_.data());
    plant_.powers(work_, at, x_.data(), external, power_.data());
    for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k] += h * weight[i] * power_[k];
  }
  t_ = t;
}

}  // namespace flexdyn
