// Every built-in law by name: where it stands, how many parameters it has, and its traits. Its formula: laws.hpp.
//
// A law belongs to a stage, which says where in the equations of motion it stands (docs/contract.md, section 3):
//   actuator    tau_applied = law(tau, theta, omega)            on the way from command to rotor
//   deflection  delta -> law(delta, theta)                      before every spring law
//   spring      tau_s += law(delta, delta')                     transmission
//   friction    left side, += law(x, u)                         smooth in u
//   dry         left side, += level(x, u) Sgn(u)                set-valued at u = 0
//   link        right side, += law(q, v)                        on the link
#pragma once

#include <string_view>

namespace flexdyn {

enum class Stage { actuator, deflection, spring, friction, dry, link };
// In the order of Stage.
inline constexpr std::string_view stage_names[] = {"actuator", "deflection", "spring", "friction", "dry", "link"};
enum class Side { link, motor, transmission };

enum class LawKind {
  viscous_friction,
  coulomb_friction,
  asymmetric_friction,
  stribeck_friction,
  asymmetric_viscous_friction,
  quadratic_drag,
  load_dependent_friction,
  directional_gear_loss,
  position_dependent_friction,
  presliding_friction,
  warm_up_friction,
  joint_coupling,
  transmission_damping,
  hardening_spring,
  backlash,
  spring_hysteresis,
  kinematic_error,
  torque_offset,
  torque_constant_error,
  torque_ripple,
  torque_saturation,
  torque_speed_limit,
  supply_limit,
  dc_motor,
  dc_winding,  // a DC motor whose current has inductance: its state is the torque of the current
  command_delay,
  parallel_spring,
  position_torque,
  end_stop,
  callback,  // a law written in Python
  stribeck_gear_loss,
  dry_coupling,
};

// What the core must know of a law besides its stage and its formula.
enum Trait : unsigned {
  plain = 0,
  has_corner = 1,                   // it has pieces: region_of and region_guard say which, for each
  corner_at_zero = 2 + has_corner,  // they meet where it is nothing itself: from there the motion decides on which it is
  has_state = 4,                    // it remembers: internal_rate, of an actuator winding_rate
  conservative = 8,                 // it gives back what it takes: spring_energy
  adds_up = 16,                     // of a deflection: several at one joint are one, their first parameters added
  delays_command = 32,              // it acts on the command's time, not on its value
  beside_gap = 64,                  // it acts between rotor and link themselves, beside gap and kinematic error
};

struct LawRow {
  std::string_view name;
  LawKind kind;
  Stage stage;
  int parameters;
  unsigned traits = plain;
  std::string_view stage_name() const { return stage_names[static_cast<int>(stage)]; }
  bool has(Trait trait) const { return (traits & trait) == trait; }
};

// One row a law. Python reads it: a class of a law in it declares none of this again (flexdyn/effects/law_table.py).
inline constexpr LawRow law_table[] = {
    {"viscous_friction", LawKind::viscous_friction, Stage::friction, 1},
    {"coulomb_friction", LawKind::coulomb_friction, Stage::dry, 1},
    {"asymmetric_friction", LawKind::asymmetric_friction, Stage::dry, 2},
    {"stribeck_friction", LawKind::stribeck_friction, Stage::dry, 3},
    {"asymmetric_viscous_friction", LawKind::asymmetric_viscous_friction, Stage::friction, 2, corner_at_zero},
    {"quadratic_drag", LawKind::quadratic_drag, Stage::friction, 1},
    {"load_dependent_friction", LawKind::load_dependent_friction, Stage::dry, 1, corner_at_zero},
    {"directional_gear_loss", LawKind::directional_gear_loss, Stage::dry, 2, corner_at_zero},
    {"stribeck_gear_loss", LawKind::stribeck_gear_loss, Stage::dry, 3, corner_at_zero},
    {"position_dependent_friction", LawKind::position_dependent_friction, Stage::dry, 3},
    {"dry_coupling", LawKind::dry_coupling, Stage::dry, 2},
    {"presliding_friction", LawKind::presliding_friction, Stage::friction, 3, has_state},
    {"warm_up_friction", LawKind::warm_up_friction, Stage::friction, 2},
    {"joint_coupling", LawKind::joint_coupling, Stage::friction, 1},
    {"transmission_damping", LawKind::transmission_damping, Stage::spring, 1, beside_gap},
    {"hardening_spring", LawKind::hardening_spring, Stage::spring, 1, conservative},
    {"backlash", LawKind::backlash, Stage::deflection, 1, has_corner | adds_up},
    {"spring_hysteresis", LawKind::spring_hysteresis, Stage::spring, 2, has_state},
    {"kinematic_error", LawKind::kinematic_error, Stage::deflection, 3},
    {"torque_offset", LawKind::torque_offset, Stage::actuator, 1},
    {"torque_constant_error", LawKind::torque_constant_error, Stage::actuator, 1},
    {"torque_ripple", LawKind::torque_ripple, Stage::actuator, 3},
    {"torque_saturation", LawKind::torque_saturation, Stage::actuator, 1},
    {"torque_speed_limit", LawKind::torque_speed_limit, Stage::actuator, 2, has_corner},
    {"supply_limit", LawKind::supply_limit, Stage::actuator, 1, has_corner},
    {"dc_motor", LawKind::dc_motor, Stage::actuator, 3, has_corner},
    {"dc_winding", LawKind::dc_winding, Stage::actuator, 4, has_corner | has_state},
    {"command_delay", LawKind::command_delay, Stage::actuator, 1, delays_command},
    {"parallel_spring", LawKind::parallel_spring, Stage::link, 2, conservative},
    {"position_torque", LawKind::position_torque, Stage::link, 4, conservative},
    {"end_stop", LawKind::end_stop, Stage::link, 4, has_corner},
};

// The row of a name, null if there is none.
inline const LawRow* named(std::string_view name) {
  for (const LawRow& row : law_table) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

// The row of a kind, null for a law written in Python.
inline const LawRow* row_of(LawKind kind) {
  for (const LawRow& row : law_table) {
    if (row.kind == kind) return &row;
  }
  return nullptr;
}

inline bool has(LawKind kind, Trait trait) { return row_of(kind) != nullptr && row_of(kind)->has(trait); }
// Dry friction in proportion to a load, which is nothing at no load.
inline bool is_of_load(const LawRow& row) { return row.has(corner_at_zero) && row.stage == Stage::dry; }
inline bool is_of_load(LawKind kind) { return row_of(kind) != nullptr && is_of_load(*row_of(kind)); }

}  // namespace flexdyn
