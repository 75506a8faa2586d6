// Energy of the plant: what springs hold, and what each law takes out of the motion.
#include <algorithm>

#include "plant.hpp"

namespace flexdyn {

// [supplied by each motor (n), by wrenches (1), lost in each joint's damping (n), lost in each law (laws)] [W].
void Plant::powers(const Workspace& w, double t, const double* x, const double* tau_ext, double* out) const {
  const double* v_ = v(x);
  std::fill(out, out + ledger_size(), 0.0);
  double* damping = out + n_ + 1;
  double* law_power = damping + n_;
  for (int j = 0; j < n_; ++j) {
    out[j] = w.tau_applied[j] * w.omega[j];
    if (tau_ext) out[n_] += tau_ext[j] * v_[j];
  }
  for (const Law& law : actuator_) {  // what a winding takes into its inductance comes from its driver as well
    if (law.state < 0 || w.winding_step < 0.0 || (law.region >= 0 && w.region[law.region] != 0)) continue;
    const LawInput in = input(w, law, t, x);
    out[law.joint] += winding_inductance(law.p) * in.z * winding_rate(law.p, in, w.winding_input[law.state]);
  }
  for (const int j : elastic_) damping[j] = D_[j] * (w.omega[j] - v_[j]) * (w.omega[j] - v_[j]);
  for (const Law& law : damper_) {
    const double rate = w.omega[law.joint] - v_[law.joint];
    law_power[law.index] = spring_torque(law.kind, law.p, {t, 0.0, rate}) * rate;
  }
  for (const Law& law : spring_) {
    if (has(law.kind, conservative)) continue;
    const LawInput in = spring_input(w, law, t, x);
    const double torque = law.callback ? (*law.callback)(in, 0.0) : spring_torque(law.kind, law.p, in);
    // In a gap the loop stands still while its torque still acts on what moves: the ledger counts that too.
    const double rate = w.rotor_gain[law.joint] * w.omega[law.joint] - v_[law.joint];
    law_power[law.index] = torque * (law.state < 0 ? in.u : rate - internal_rate(law.kind, law.p, in));
  }
  for (const Law& law : friction_) {
    const LawInput in = input(w, law, t, x);
    const double torque = law.callback ? (*law.callback)(in, 0.0) : friction_torque(law.kind, law.p, in, region_at(w, law, in));
    // What a bristle stores is not lost: 1/2 stiffness z^2.
    const double stored = bristle_spring(law.kind, law.p).stiffness * in.z * internal_rate(law.kind, law.p, in);
    law_power[law.index] = torque * in.u - stored;
  }
  for (const Law& law : link_) {
    if (has(law.kind, conservative)) continue;
    const LawInput in = input(w, law, t, x);
    law_power[law.index] = -link_torque(law.kind, law.p, in, region_at(w, law, in)) * in.u;
  }
  for (std::size_t c = 0; c < dry_.size(); ++c) {
    const double u = contact_speed(dry_[c], x);
    if (u == 0.0) continue;  // what sticks does no work
    const double direction = u < 0.0 ? -1.0 : 1.0;
    const double share = w.located ? direction : smooth_sign(u, w.smoothing);
    for (const Law& law : dry_[c].laws) {
      law_power[law.index] = level_of(w, law, t, x, direction) * share * u;
    }
  }
}

// Energy held by springs of all kinds [J]: transmissions, bristles, parallel springs, counterbalances.
double Plant::stored_energy(Workspace& w, const double* x) const {
  rotor(x, w.theta.data(), w.omega.data());
  w.located = false;  // regions follow the point
  transmission(w, 0.0, x);
  double sum = 0.0;
  for (const int j : elastic_) sum += 0.5 * K_[j] * w.deflection[j] * w.deflection[j];
  for (const Law& law : spring_) sum += spring_energy(law.kind, law.p, spring_input(w, law, 0.0, x));
  for (const auto* laws : {&friction_, &link_}) {
    for (const Law& law : *laws) sum += spring_energy(law.kind, law.p, input(w, law, 0.0, x));
  }
  return sum;
}

}  // namespace flexdyn
