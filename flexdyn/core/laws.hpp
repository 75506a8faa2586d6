// The formula of every law is written once, here: Python classes give it units and bounds and call it to draw it.
//
// Laws with a corner (dead zone, end stop, torque-speed line) take a region: the piece they are on. Solvers that
// locate events fix the region over a step and go on smoothly past the corner; the others ask for it at every point.
//
// A new law needs a kind and a row in law_table.hpp, its formula in the function of its stage, and its cases in the
// functions that its traits name. No other file of the core names one.
#pragma once

#include <algorithm>
#include <cmath>

#include "law_table.hpp"

namespace flexdyn {

// What a law sees at one instant: position and velocity of its side (transmission: delta and its rate).
struct LawInput {
  double t = 0.0;
  double x = 0.0;
  double u = 0.0;
  double z = 0.0;      // internal state of the law
  double tau_s = 0.0;  // transmission torque, for load-dependent friction
  double other = 0.0;  // velocity of another joint's rotor, for joint coupling
};

// The spring of a law that remembers, of torque stiffness z + damping z' and z' = u - decay |u| z.
struct BristleSpring {
  double stiffness, damping, decay;
};

inline BristleSpring bristle_spring(LawKind kind, const double* p) {
  switch (kind) {
    case LawKind::presliding_friction: return {p[1], p[2], p[1] / p[0]};
    case LawKind::spring_hysteresis: return {p[0], 0.0, 1.0 / p[1]};
    default: return {0.0, 0.0, 1.0};
  }
}

// z' of a law with an internal state; u is the velocity that drives it.
inline double internal_rate(LawKind kind, const double* p, const LawInput& in) {
  switch (kind) {
    case LawKind::presliding_friction: return in.u - p[1] * std::abs(in.u) * in.z / p[0];  // LuGre without Stribeck
    case LawKind::spring_hysteresis: return in.u - std::abs(in.u) * in.z / p[1];           // Bouc-Wen
    default: return 0.0;
  }
}

// f_link or f_motor of a law that is 0 at rest or remembers [N m].
inline double friction_torque(LawKind kind, const double* p, const LawInput& in, int region) {
  switch (kind) {
    case LawKind::viscous_friction: return p[0] * in.u;
    case LawKind::asymmetric_viscous_friction: return (region > 0 ? p[0] : p[1]) * in.u;
    case LawKind::quadratic_drag: return p[0] * in.u * std::abs(in.u);
    case LawKind::warm_up_friction: return p[0] * std::exp(-in.t / p[1]) * in.u;
    case LawKind::joint_coupling: return p[0] * in.other;
    case LawKind::presliding_friction: return p[1] * in.z + p[2] * internal_rate(kind, p, in);
    default: return 0.0;
  }
}

// Its slope by the velocity of the other joint [N m s/rad].
inline double coupling_slope(LawKind kind, const double* p) { return kind == LawKind::joint_coupling ? p[0] : 0.0; }

// A dry law between two motors rubs at omega - ratio omega of the other.
inline double coupling_ratio(const double* p) { return p[1]; }

// Level L >= 0 of a dry law on its region in a direction of motion (+1 or -1); its torque is direction * L [N m].
inline double dry_level(LawKind kind, const double* p, const LawInput& in, double direction, int region) {
  switch (kind) {
    case LawKind::coulomb_friction:
    case LawKind::dry_coupling: return p[0];
    case LawKind::asymmetric_friction: return direction > 0.0 ? p[0] : p[1];
    case LawKind::stribeck_friction: {
      // Paper eq. 1: (b^s - b^d) exp(-|u|/epsilon); the exponent generalises it. With exponent 1 the branch goes on
      // smoothly past u = 0, so that a step which overshoots the end of sliding stays smooth.
      const double ratio = direction * in.u / p[1];
      const double power = p[2] == 1.0 ? ratio : std::pow(std::abs(ratio), p[2]);
      return p[0] * std::exp(-power);
    }
    // The region is the sign of the load: past its zero the branch goes on smoothly.
    case LawKind::load_dependent_friction: return p[0] * region * in.tau_s;
    case LawKind::directional_gear_loss: return (direction * region > 0.0 ? p[0] : p[1]) * region * in.tau_s;
    case LawKind::stribeck_gear_loss:
      return (direction * region > 0.0 ? p[0] : p[1]) * std::exp(-direction * in.u / p[2]) * region * in.tau_s;
    case LawKind::position_dependent_friction: return p[0] * (1.0 + std::sin(p[1] * in.x + p[2]));
    default: return 0.0;
  }
}

// Contribution to the spring's torque [N m]; x is the effective deflection, u its rate.
inline double spring_torque(LawKind kind, const double* p, const LawInput& in) {
  switch (kind) {
    case LawKind::transmission_damping: return p[0] * in.u;
    case LawKind::hardening_spring: return p[0] * in.x * in.x * in.x;
    case LawKind::spring_hysteresis: return p[0] * in.z;
    default: return 0.0;
  }
}

// The deflection as spring laws see it [rad or m]; theta is the rotor's position.
inline double deflection_after(LawKind kind, const double* p, double delta, double theta, int region) {
  switch (kind) {
    case LawKind::kinematic_error: return delta + p[0] * std::sin(p[1] * theta + p[2]);
    case LawKind::backlash: return region == 0 ? 0.0 : delta - region * p[0];
    default: return delta;
  }
}

// What it grows by as the rotor turns while delta stays [1]: the rotor's torque is larger by this share.
inline double deflection_slope(LawKind kind, const double* p, double theta) {
  return kind == LawKind::kinematic_error ? p[0] * p[1] * std::cos(p[1] * theta + p[2]) : 0.0;
}

// Whether a deflection that changes changes it: not in a gap.
inline bool passes_deflection(LawKind kind, int region) { return kind != LawKind::backlash || region != 0; }

// Torque on the link, right side of its equation [N m]. An end stop presses, it never pulls.
inline double link_torque(LawKind kind, const double* p, const LawInput& in, int region) {
  switch (kind) {
    case LawKind::parallel_spring: return -p[0] * (in.x - p[1]);
    case LawKind::position_torque:
      return -(p[0] * std::cos(in.x) + p[1] * std::sin(in.x) + p[2] * std::cos(2.0 * in.x) + p[3] * std::sin(2.0 * in.x));
    case LawKind::end_stop:
      return region == 0 ? 0.0 : -(p[2] * (in.x - (region > 0 ? p[1] : p[0])) + p[3] * in.u);
    default: return 0.0;
  }
}

// Energy that the spring of a law holds [J]: 0 of one that has none.
inline double spring_energy(LawKind kind, const double* p, const LawInput& in) {
  switch (kind) {
    case LawKind::hardening_spring: return 0.25 * p[0] * in.x * in.x * in.x * in.x;
    case LawKind::parallel_spring: return 0.5 * p[0] * (in.x - p[1]) * (in.x - p[1]);
    case LawKind::position_torque:
      return p[0] * std::sin(in.x) - p[1] * std::cos(in.x) +
             0.5 * (p[2] * std::sin(2.0 * in.x) - p[3] * std::cos(2.0 * in.x));
    default: return 0.5 * bristle_spring(kind, p).stiffness * in.z * in.z;
  }
}

// Torque of a DC motor whose current nothing limits: p is gain on tau, back-EMF kt^2/R, and the limit kt i_max.
inline double free_torque(const double* p, const LawInput& in, double tau) { return p[0] * tau - p[1] * in.u; }

// A winding, p of `free_torque` and the time constant L/R: L i' = V - R i - kt omega, times kt/R.
inline double winding_rate(const double* p, const LawInput& in, double tau) {
  return (free_torque(p, in, tau) - in.z) / p[3];
}

// Its torque at the end of a step at constant speed and voltage, and its mean over it: exact.
inline double winding_end(const double* p, const LawInput& in, double tau, double h) {
  return in.z - std::expm1(-h / p[3]) * (free_torque(p, in, tau) - in.z);
}
inline double winding_mean(const double* p, const LawInput& in, double tau, double h) {
  const double settled = free_torque(p, in, tau), share = -std::expm1(-h / p[3]) * p[3] / h;
  return settled + share * (in.z - settled);
}

inline double winding_limit(const double* p) { return p[2]; }
// L/k^2 = (L/R)/(k^2/R) [J/(N m)^2]: half of it times the square of the torque is the energy in its inductance.
inline double winding_inductance(const double* p) { return p[3] / p[1]; }

// Part of a winding's limit that rounding may make of a current at it.
constexpr double winding_slack = 1e-12;

// Whether a law with these numbers has its corner at all: a winding without a limit has none.
inline bool reaches_corner(LawKind kind, const double* p) {
  return has(kind, has_corner) && !(kind == LawKind::dc_winding && std::isinf(winding_limit(p)));
}

// Inside, above or below a limit on both sides.
inline int piece_of(double value, double limit) { return value > limit ? 1 : value < -limit ? -1 : 0; }
inline double piece_margin(double value, double limit, int region) {
  return region == 0 ? limit - std::abs(value) : region * value - limit;
}

// tau_applied out of tau [N m]; x, u are theta, omega.
inline double actuator_torque(LawKind kind, const double* p, const LawInput& in, double tau, int region) {
  switch (kind) {
    case LawKind::torque_offset: return tau + p[0];
    case LawKind::torque_constant_error: return (1.0 + p[0]) * tau;
    case LawKind::torque_saturation: return tau / (1.0 + std::abs(tau) / p[0]);
    case LawKind::torque_ripple: return tau + p[0] * std::sin(p[1] * in.x + p[2]);
    case LawKind::torque_speed_limit:
      // Regions: 0 inside, +-1 on the upper or lower line, +-2 past its end, where nothing is left.
      if (region == 0) return tau;
      return std::abs(region) == 2 ? 0.0 : region * p[0] - p[0] * in.u / p[1];
    // Regions of both: 0 inside, +-1 at the upper or lower limit.
    case LawKind::supply_limit: return region == 0 ? tau : region * p[0];
    case LawKind::dc_motor: return region == 0 ? free_torque(p, in, tau) : region * p[2];
    case LawKind::dc_winding: return region == 0 ? in.z : region * p[2];
    default: return tau;
  }
}

// The piece of a law with a corner at this point.
inline int region_of(LawKind kind, const double* p, const LawInput& in, double value) {
  switch (kind) {
    case LawKind::torque_speed_limit: {
      const double upper = p[0] * (1.0 - in.u / p[1]), lower = -p[0] * (1.0 + in.u / p[1]);
      if (value > std::max(0.0, upper)) return upper > 0.0 ? 1 : 2;
      if (value < std::min(0.0, lower)) return lower < 0.0 ? -1 : -2;
      return 0;
    }
    case LawKind::end_stop:
      // It holds while it presses: the damper may not pull the link back.
      if (in.x > p[1]) return p[2] * (in.x - p[1]) + p[3] * in.u > 0.0 ? 1 : 0;
      if (in.x < p[0]) return p[2] * (in.x - p[0]) + p[3] * in.u < 0.0 ? -1 : 0;
      return 0;
    case LawKind::backlash:
    case LawKind::supply_limit: return piece_of(value, p[0]);
    case LawKind::dc_motor: return piece_of(free_torque(p, in, value), p[2]);
    case LawKind::dc_winding: {
      // The driver holds the current at its limit while the voltage would raise it further.
      const int beyond = piece_of(free_torque(p, in, value), p[2]);
      return beyond * in.z >= p[2] * (1.0 - winding_slack) ? beyond : 0;
    }
    case LawKind::asymmetric_viscous_friction: return in.u < 0.0 ? -1 : 1;
    case LawKind::load_dependent_friction:
    case LawKind::directional_gear_loss:
    case LawKind::stribeck_gear_loss: return in.tau_s < 0.0 ? -1 : 1;
    default: return 0;
  }
}

// How far a point is inside its region: negative once the law has left the piece it was on.
inline double region_guard(LawKind kind, const double* p, const LawInput& in, double value, int region) {
  switch (kind) {
    case LawKind::torque_speed_limit: {
      const double upper = p[0] * (1.0 - in.u / p[1]), lower = -p[0] * (1.0 + in.u / p[1]);
      if (region == 0) return std::min(std::max(0.0, upper) - value, value - std::min(0.0, lower));
      if (region > 0) return region == 1 ? std::min(value - upper, upper) : std::min(value, -upper);
      return region == -1 ? std::min(lower - value, -lower) : std::min(-value, lower);
    }
    case LawKind::end_stop: {
      const double up = p[2] * (in.x - p[1]) + p[3] * in.u, down = -(p[2] * (in.x - p[0]) + p[3] * in.u);
      if (region == 0) return -std::max(std::min(in.x - p[1], up), std::min(p[0] - in.x, down));
      return region > 0 ? std::min(up, in.x - p[1]) : std::min(down, p[0] - in.x);
    }
    case LawKind::backlash:
    case LawKind::supply_limit: return piece_margin(value, p[0], region);
    case LawKind::dc_motor: return piece_margin(free_torque(p, in, value), p[2], region);
    case LawKind::dc_winding:
      return region == 0 ? p[2] * (1.0 + winding_slack) - std::abs(in.z)
                         : piece_margin(free_torque(p, in, value), p[2], region);
    case LawKind::asymmetric_viscous_friction: return region * in.u;
    case LawKind::load_dependent_friction:
    case LawKind::directional_gear_loss:
    case LawKind::stribeck_gear_loss: return region * in.tau_s;
    default: return 1.0;
  }
}

// Sgn(u) made smooth where a solver cannot take a set-valued law: width eps [rad/s].
inline double smooth_sign(double u, double eps) { return std::tanh(u / eps); }

}  // namespace flexdyn
