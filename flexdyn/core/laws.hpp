// Every law is written once, here: Python classes give it its name, units and bounds and call it to draw it.
//
// A law belongs to a stage, which says where in the equations of motion it stands (SPEC signs):
//   actuator  tau_applied = law(tau, theta, omega)            on the way from command to rotor
//   spring    tau_s += law(delta, omega - v)                  transmission
//   friction  left side, += law(x, u)                         smooth in u
//   dry       left side, += level(x, u) Sgn(u)                set-valued at u = 0
#pragma once

#include <algorithm>
#include <cmath>

namespace flexdyn {

enum class Stage { actuator, spring, friction, dry };
enum class Side { link, motor, transmission };

enum class LawKind {
  viscous_friction,
  coulomb_friction,
  stribeck_friction,
  transmission_damping,
  torque_offset,
  torque_speed_limit,
  callback,  // a law written in Python
};

// What a law sees at one instant: position and velocity of its side (transmission: delta and its rate).
struct LawInput {
  double t;
  double x;
  double u;
};

// f_link or f_motor of a law smooth in u [N m].
inline double friction_torque(LawKind kind, const double* p, const LawInput& in) {
  switch (kind) {
    case LawKind::viscous_friction: return p[0] * in.u;
    default: return 0.0;
  }
}

// Level L >= 0 of a dry law in the direction u moves or, at rest, would move; its torque is L Sgn(u) [N m].
inline double dry_level(LawKind kind, const double* p, const LawInput& in) {
  switch (kind) {
    case LawKind::coulomb_friction: return p[0];
    // Paper eq. 1: (b^s - b^d) exp(-|u|/epsilon); the exponent generalises it.
    case LawKind::stribeck_friction: return p[0] * std::exp(-std::pow(std::abs(in.u) / p[1], p[2]));
    default: return 0.0;
  }
}

// Contribution to tau_s [N m]; x is the deflection delta, u its rate omega - v.
inline double spring_torque(LawKind kind, const double* p, const LawInput& in) {
  switch (kind) {
    case LawKind::transmission_damping: return p[0] * in.u;
    default: return 0.0;
  }
}

// tau_applied out of tau [N m]; x, u are theta, omega.
inline double actuator_torque(LawKind kind, const double* p, const LawInput& in, double tau) {
  switch (kind) {
    case LawKind::torque_offset: return tau + p[0];
    case LawKind::torque_speed_limit: {
      const double upper = std::max(0.0, p[0] * (1.0 - in.u / p[1]));
      const double lower = std::min(0.0, -p[0] * (1.0 + in.u / p[1]));
      return std::min(std::max(tau, lower), upper);
    }
    default: return tau;
  }
}

// Sgn(u) made smooth where a solver cannot take a set-valued law: width eps [rad/s].
inline double smooth_sign(double u, double eps) { return std::tanh(u / eps); }

}  // namespace flexdyn
