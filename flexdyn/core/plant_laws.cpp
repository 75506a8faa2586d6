// The laws of the plant at one instant: what each gives, and on which piece it is.
#include <algorithm>
#include <cmath>
#include <limits>

#include "plant.hpp"

namespace flexdyn {

LawInput Plant::input(const Workspace& w, const Law& law, double t, const double* x) const {
  const int j = law.joint;
  const bool link = law.side == Side::link;
  LawInput in{t, link ? x[j] : w.theta[j], link ? v(x)[j] : w.omega[j]};
  if (!law.row.empty()) {
    in.x = in.u = 0.0;
    for (int k = 0; k < n_; ++k) {
      in.x += law.row[k] * x[k];
      in.u += law.row[k] * v(x)[k];
    }
  }
  in.tau_s = w.tau_s[j];
  if (law.state >= 0) in.z = z(x)[law.state];
  if (law.other >= 0) in.other = w.omega[law.other];
  return in;
}

LawInput Plant::spring_input(const Workspace& w, const Law& law, double t, const double* x) const {
  LawInput in{t, w.deflection[law.joint], w.deflection_rate[law.joint]};
  if (law.state >= 0) in.z = z(x)[law.state];
  return in;
}

void Plant::evaluate_laws(Workspace& w, double t, const double* x, const double* tau) const {
  rotor(x, w.theta.data(), w.omega.data());
  transmission(w, t, x);
  actuators(w, t, x, tau);
  frictions(w, t, x);
}

void Plant::transmission(Workspace& w, double t, const double* x) const {
  const double* v_ = v(x);
  if (plain_) {  // linear springs and dampers alone
    for (const int j : elastic_) {
      w.deflection[j] = w.theta[j] - x[j];
      w.tau_s[j] = w.tau_rotor[j] = K_[j] * w.deflection[j] + D_[j] * (w.omega[j] - v_[j]);
    }
    return;
  }
  for (const int j : elastic_) {
    w.deflection[j] = w.theta[j] - x[j];
    w.deflection_rate[j] = w.omega[j] - v_[j];
    w.rotor_gain[j] = 1.0;
  }
  for (const Law& law : deflection_) {
    const int j = law.joint;
    int region = 0;
    if (law.region >= 0) {
      w.switch_input[law.region] = w.deflection[j];
      if (!w.located) w.region[law.region] = current_region(w, law.region, t, x);
      region = w.region[law.region];
    }
    const double slope = deflection_slope(law.kind, law.p, w.theta[j]);
    w.deflection[j] = deflection_after(law.kind, law.p, w.deflection[j], w.theta[j], region);
    w.deflection_rate[j] = passes_deflection(law.kind, region) ? w.deflection_rate[j] + slope * w.omega[j] : 0.0;
    w.rotor_gain[j] += slope;
  }
  for (const int j : elastic_) w.spring[j] = K_[j] * w.deflection[j];
  for (const Law& law : spring_) {
    const int j = law.joint;
    if (law.state >= 0 && w.without_internal) continue;
    const LawInput in = spring_input(w, law, t, x);
    w.spring[j] += law.callback ? (*law.callback)(in, 0.0) : spring_torque(law.kind, law.p, in);
  }
  for (const int j : elastic_) {
    const double damping = D_[j] * (w.omega[j] - v_[j]);
    w.tau_s[j] = w.spring[j] + damping;
    w.tau_rotor[j] = w.rotor_gain[j] * w.spring[j] + damping;
  }
  for (const Law& law : damper_) {
    const double torque = spring_torque(law.kind, law.p, {t, 0.0, w.omega[law.joint] - v_[law.joint]});
    w.tau_s[law.joint] += torque;
    w.tau_rotor[law.joint] += torque;
  }
}

void Plant::actuators(Workspace& w, double t, const double* x, const double* tau) const {
  std::copy(tau, tau + n_, w.tau_applied.begin());
  for (const Law& law : actuator_) {
    double& torque = w.tau_applied[law.joint];
    LawInput in{t, w.theta[law.joint], w.omega[law.joint]};
    if (law.callback) {
      torque = (*law.callback)(in, torque);
      continue;
    }
    if (law.state >= 0) {
      in.z = z(x)[law.state];
      w.winding_input[law.state] = torque;
    }
    int region = 0;
    if (law.region >= 0) {
      w.switch_input[law.region] = torque;
      if (!w.located) w.region[law.region] = region_of(law.kind, law.p, in, torque);
      region = w.region[law.region];
    }
    const bool mean = law.state >= 0 && region == 0 && w.winding_step > 0.0;
    torque = mean ? winding_mean(law.p, in, torque, w.winding_step)
                  : actuator_torque(law.kind, law.p, in, torque, region);
  }
}

void Plant::frictions(Workspace& w, double t, const double* x) const {
  for (int j = 0; j < n_; ++j) w.f_link[j] = w.f_motor[j] = w.tau_link[j] = 0.0;
  for (const Law& law : friction_) {
    if (law.state >= 0 && w.without_internal) continue;
    const LawInput in = input(w, law, t, x);
    const int region = follow(w, law, in);
    const double torque = law.callback ? (*law.callback)(in, 0.0) : friction_torque(law.kind, law.p, in, region);
    (law.side == Side::link ? w.f_link : w.f_motor)[law.joint] += torque;
  }
  for (const Law& law : link_) {
    const LawInput in = input(w, law, t, x);
    const double torque = link_torque(law.kind, law.p, in, follow(w, law, in));
    if (law.row.empty()) w.tau_link[law.joint] += torque;
    for (std::size_t k = 0; !w.joint_local && k < law.row.size(); ++k) w.tau_link[k] += law.row[k] * torque;
  }
  dry_frictions(w, t, x);
}

void Plant::dry_frictions(Workspace& w, double t, const double* x) const {
  for (std::size_t c = 0; c < dry_.size(); ++c) {
    const DryContact& contact = dry_[c];
    if (contact.couples() && w.joint_local) continue;
    const double u = contact_speed(contact, x);
    for (const Law& law : contact.laws) {
      if (law.region >= 0) follow(w, law, input(w, law, t, x));
    }
    if (w.located) {
      w.friction[c] = w.motion[c] == stuck ? 0.0 : w.motion[c] * level(w, c, t, x, w.motion[c]);
    } else {
      w.friction[c] = level(w, c, t, x, u < 0.0 ? -1.0 : 1.0) * smooth_sign(u, w.smoothing);
    }
    rub(w, c);
  }
}

double Plant::level(const Workspace& w, std::size_t contact, double t, const double* x, double direction) const {
  double sum = 0.0;
  for (const Law& law : dry_[contact].laws) sum += level_of(w, law, t, x, direction);
  return sum;
}

double Plant::level_of(const Workspace& w, const Law& law, double t, const double* x, double direction) const {
  const LawInput in = input(w, law, t, x);
  return dry_level(law.kind, law.p, in, direction, region_at(w, law, in));
}

int Plant::region_at(const Workspace& w, const Law& law, const LawInput& in) const {
  if (law.region < 0) return 0;
  return w.located ? w.region[law.region] : region_of(law.kind, law.p, in, 0.0);
}

int Plant::follow(Workspace& w, const Law& law, const LawInput& in) const {
  if (law.region < 0) return 0;
  return w.region[law.region] = region_at(w, law, in);
}

bool Plant::at_zero_corner(const Workspace& w, int which, double t, const double* x) const {
  const Law& law = switches_[which];
  if (!has(law.kind, corner_at_zero)) return false;
  const double rounding = corner_rounding(law, x);
  return std::abs(region_margin(w, which, t, x) - rounding) <= rounding;
}

// An unloaded gear at rest must not change sign with every last bit.
double Plant::corner_rounding(const Law& law, const double* x) const {
  return is_of_load(law.kind) ? load_rounding(law.joint, x) : 0.0;
}

double Plant::load_rounding(int joint, const double* x) const {
  const int slot = rotor_slot_[joint];
  if (slot < 0) return 0.0;
  constexpr double bits = 4.0 * std::numeric_limits<double>::epsilon();
  const double *speed = v(x), *rotor = x + n_;
  const double bent = K_[joint] * (std::abs(x[joint]) + std::abs(rotor[slot]));
  return bits * (bent + D_[joint] * (std::abs(speed[joint]) + std::abs(speed[n_ + slot])));
}

int Plant::current_region(const Workspace& w, int which, double t, const double* x) const {
  const Law& law = switches_[which];
  return region_of(law.kind, law.p, input(w, law, t, x), w.switch_input[which]);
}

double Plant::region_margin(const Workspace& w, int which, double t, const double* x) const {
  const Law& law = switches_[which];
  const double margin = region_guard(law.kind, law.p, input(w, law, t, x), w.switch_input[which], w.region[which]);
  return margin + corner_rounding(law, x);
}

bool Plant::in_gap(const Workspace& w, int joint) const {
  return std::any_of(deflection_.begin(), deflection_.end(), [&](const Law& law) {
    return law.joint == joint && law.region >= 0 && !passes_deflection(law.kind, w.region[law.region]);
  });
}

void Plant::internal_rates(const Workspace& w, double t, const double* x, double* rate) const {
  for (const Law& law : actuator_) {
    if (law.state < 0) continue;
    const bool at_limit = law.region >= 0 && w.region[law.region] != 0;
    rate[law.state] = at_limit ? 0.0 : winding_rate(law.p, input(w, law, t, x), w.winding_input[law.state]);
  }
  for (const Law& law : friction_) {
    if (law.state >= 0) rate[law.state] = internal_rate(law.kind, law.p, input(w, law, t, x));
  }
  for (const Law& law : spring_) {
    if (law.state >= 0) rate[law.state] = internal_rate(law.kind, law.p, spring_input(w, law, t, x));
  }
}

double Plant::motor_share(const Workspace& w, std::size_t contact, double t, const double* x) const {
  const DryContact& dry = dry_[contact];
  if (dry.side != Side::link || rotor_slot_[dry.joint] >= 0 || w.friction[contact] == 0.0) return 0.0;
  const double direction = w.friction[contact] < 0.0 ? -1.0 : 1.0;
  double motor = 0.0, all = 0.0;
  for (const Law& law : dry.laws) {
    const double one = level_of(w, law, t, x, direction);
    all += one;
    if (law.side == Side::motor) motor += one;
  }
  return all > 0.0 ? w.friction[contact] * motor / all : 0.0;
}

}  // namespace flexdyn
