// The whole arm: links, rotors, transmissions and the laws on them, as x' = f(t, x, tau).
//
//   M(q) a + h(q, v) + f_link = tau_s + tau_link + tau_ext    (paper, eq. 3)
//   J alpha + f_motor         = tau_applied - g tau_s         (paper, eq. 4)
//
// g = 1 but for a kinematic error, whose rotor feels the spring through the slope of the error.
// State x = [q (n), theta (e), v (n), omega (e), z (internal states)], e = number of elastic joints.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "laws.hpp"
#include "link_dynamics.hpp"
#include "ties.hpp"

namespace flexdyn {

constexpr int max_law_parameters = 6;

// A law written in Python; the binding layer holds the callable and the GIL.
class CallbackLaw {
 public:
  virtual ~CallbackLaw() = default;
  // `tau` is the torque before the law (actuator stage), else 0.
  virtual double operator()(const LawInput& in, double tau) const = 0;
};

struct Law {
  LawKind kind;
  Stage stage;
  int joint;
  Side side;
  double p[max_law_parameters];
  std::shared_ptr<const CallbackLaw> callback;
  int other = -1;   // joint of a coupling
  int state = -1;   // place of its internal state among the z
  int region = -1;  // place of its region among the switches
  int index = 0;    // place among all laws of the plant
  // Of a law on the link side that sees a combination of joints: their coefficients (n); empty: its joint alone.
  std::vector<double> row = {};
};

// All dry laws on one velocity: they add to one interval [-L_negative, L_positive], one contact that sticks as a
// whole. On a rigid joint link and motor laws share the velocity and so the contact.
// One that couples holds two motors to each other instead: its velocity is omega - ratio omega of the other joint.
struct DryContact {
  int joint;
  Side side;
  std::vector<Law> laws;
  int other = -1;  // joint of the other motor
  double ratio = 0.0;
  bool couples() const { return other >= 0; }
};

// How a contact moves: sliding in a direction, or stuck.
enum Motion : int { backward = -1, stuck = 0, forward = 1 };

// Torques of the laws on every link and rotor, and how they change with that joint's own state (dry friction of
// stuck contacts left out). Column order of `by`: q, theta, v, omega.
struct LocalSlopes {
  std::vector<double> link, rotor;          // (n,) [N m]
  std::vector<double> link_by[4], rotor_by[4];
  std::vector<double> z_rate;               // (z,)
  std::vector<double> z_by[4];              // (z,) of the joint the state belongs to
  std::vector<double> z_self, link_by_z, rotor_by_z;
  std::vector<int> z_joint;
};

// tau_ext (n) at a position, or null.
using ExternalTorque = std::function<const double*(double t, const double* x)>;

class Plant {
 public:
  Plant(std::shared_ptr<const LinkDynamics> links, std::vector<double> stiffness, std::vector<double> damping,
        std::vector<double> rotor_inertia, std::vector<double> spin, const std::vector<Law>& laws);

  // Everything of one instant. With `located` the motions and regions are held fixed and sticking is exact; without,
  // dry friction is smoothed and regions follow the point.
  struct Workspace {
    LinkDynamics::WorkspacePtr links;
    std::vector<double> theta, omega;
    std::vector<double> deflection, deflection_rate, rotor_gain;  // after kinematic error and dead zone
    std::vector<double> spring, tau_applied, tau_s, tau_rotor;    // tau_rotor: what the transmission asks of the rotor
    std::vector<double> tau_link, f_link, f_motor;
    std::vector<double> friction;        // of each contact, positive against forward motion
    std::vector<double> switch_input;    // of each switch: torque before a limit, deflection before a gap
    std::vector<int> motion;             // of each contact
    std::vector<int> region;             // of each switch
    std::vector<char> held;              // velocities that stick: links (n), then rotors (e)
    std::vector<double> drive, acceleration, reaction;  // (n + e): links, then rotors
    std::vector<double> S, link_bias, rotor_bias;       // of the full rotor coupling
    std::vector<double> winding_input;                  // (z,) torque asked of each winding
    bool located = false;
    bool joint_local = false;            // leave out laws that see several joints: slopes add them themselves
    // Of TimeStepping. Above 0: windings give their mean torque over a step so long. Below: the last step was one.
    double winding_step = 0.0;
    bool without_internal = false;       // leave out laws with an internal state (TimeStepping adds them itself)
    double smoothing = 0.0;              // width of the smoothed Sgn [rad/s]
  };
  Workspace workspace() const;

  int n() const { return n_; }
  int elastic() const { return static_cast<int>(elastic_.size()); }
  int internal_states() const { return internal_; }
  int state_size() const { return 2 * (n_ + elastic()) + internal_; }
  bool has_events() const { return !dry_.empty() || !switches_.empty(); }
  bool has_callbacks() const { return callbacks_; }
  bool has_dry_friction() const { return !dry_.empty(); }
  const LinkDynamics& links() const { return *links_; }
  const std::vector<DryContact>& contacts() const { return dry_; }
  const std::vector<Law>& frictions() const { return friction_; }
  const std::vector<Law>& springs() const { return spring_; }
  int switches() const { return static_cast<int>(switches_.size()); }
  double delay(int joint) const { return delay_[joint]; }
  bool has_delay() const;
  double rotor_inertia(int joint) const { return J_[joint]; }
  double stiffness(int joint) const { return K_[joint]; }
  double damping(int joint) const { return D_[joint]; }
  int rotor_slot(int joint) const { return rotor_slot_[joint]; }

  bool coupled() const { return coupled_; }
  int velocities() const { return n_ + elastic(); }  // links, then rotors

  // Views into x, and where a contact's velocity stands in it.
  const double* q(const double* x) const { return x; }
  const double* v(const double* x) const { return x + n_ + elastic(); }
  const double* z(const double* x) const { return x + 2 * (n_ + elastic()); }
  std::size_t velocity_index(const DryContact& contact) const { return velocity_index(contact.joint, contact.side); }
  std::size_t other_index(const DryContact& contact) const { return velocity_index(contact.other, Side::motor); }
  // What a contact rubs at, or its rate of change out of dx; exactly 0 where one that couples was brought to rest.
  double contact_speed(const DryContact& contact, const double* x) const {
    const double u = x[velocity_index(contact)];
    return contact.couples() ? relative_speed(contact, u, x) : u;
  }
  void bring_to_rest(const DryContact& contact, double* x) const;
  bool has_couplings() const { return couplings_; }
  bool has_spans() const { return spans_; }
  // Currents that a step took past their limit, back to it.
  void limit_currents(double* x) const;
  std::size_t velocity_index(int joint, Side side) const {
    const int base = n_ + elastic(), slot = rotor_slot_[joint];
    return side == Side::link || slot < 0 ? base + joint : base + n_ + slot;
  }
  // theta and omega of every joint; rigid joints read q and v.
  void rotor(const double* x, double* theta, double* omega) const;

  // dx = f(t, x, tau); tau_ext (n) may be null. Leaves all torques of this instant in the workspace.
  void derivative(Workspace& w, double t, const double* x, const double* tau, const double* tau_ext, double* dx) const;
  // All torques of this instant into the workspace. On a rigid joint tau_s is what the gear carries:
  // tau_applied - f_motor - J a.
  void torques(Workspace& w, double t, const double* x, const double* tau, const double* tau_ext) const;

  // d(dx)/dx (state_size, state_size) row-major at a point where motions and regions hold: links from Pinocchio's
  // analytic derivatives, joint-local laws by central differences of their scalar torques.
  void jacobian(Workspace& w, double t, const double* x, const double* tau, const ExternalTorque& external,
                double* out) const;
  // The torques that act on links and rotors and their slopes: the laws without the links' own dynamics.
  void local_slopes(Workspace& w, double t, const double* x, const double* tau, LocalSlopes& out) const;
  // Laws on combinations of joints at a point: coefficients (n), slopes by position and by velocity.
  using VisitSpan = std::function<void(const std::vector<double>& row, double by_x, double by_u)>;
  void visit_spans(const Workspace& w, double t, const double* x, const VisitSpan& visit) const;
  const std::vector<Law>& actuators() const { return actuator_; }

  bool in_gap(const Workspace& w, int joint) const;

  // Energy: powers of this instant after `derivative`, and what springs of all kinds hold at a point.
  std::size_t ledger_size() const { return 2 * static_cast<std::size_t>(n_) + 1 + static_cast<std::size_t>(laws_); }
  void powers(const Workspace& w, double t, const double* x, const double* tau_ext, double* out) const;
  double stored_energy(Workspace& w, const double* x) const;
  double magnetic_energy(const double* x) const;  // in the windings' inductances

  // For the event layer: all torques but those of stuck contacts, and what one contact could hold.
  void evaluate_laws(Workspace& w, double t, const double* x, const double* tau) const;
  // What drives links and rotors into w.drive, after evaluate_laws.
  void assemble_drive(Workspace& w, const double* tau_ext) const;
  // Accelerations of all velocities under w.drive, those in `held` at 0 by `reaction` (other entries are not set).
  void held_solve(Workspace& w, const double* x, const std::vector<char>& held, std::vector<double>& acceleration,
                  std::vector<double>& reaction) const;
  // Inertia of all velocities, (N, N) row-major, and their velocity-dependent and gravity torques (N).
  void inertia(Workspace& w, const double* x, double* H) const;
  void bias(Workspace& w, const double* x, double* b) const;
  double level(const Workspace& w, std::size_t contact, double t, const double* x, double direction) const;
  int current_region(const Workspace& w, int which, double t, const double* x) const;
  double region_margin(const Workspace& w, int which, double t, const double* x) const;
  // What rounding of the state makes of the torque in a joint's spring.
  double load_rounding(int joint, const double* x) const;
  // Whether a law is at the corner at which it is nothing itself, to rounding: on either piece.
  bool at_zero_corner(const Workspace& w, int which, double t, const double* x) const;

 private:
  void sort_in(Law law);
  void sort_in_coupling(const Law& law);
  void local_torques(Workspace& w, double t, const double* x, const double* tau, double* link, double* rotor,
                     double* z_rate) const;
  void couple(const Workspace& w, double t, const double* x, double* right, double* J) const;
  void couple_dry(const Workspace& w, double t, const double* x, double* right, double* J) const;
  void uncouple(LocalSlopes& slopes) const;
  void external_slopes(double t, const double* x, const ExternalTorque& external, double* right) const;
  void acceleration_slopes(const Workspace& w, const double* M, const double* right, double* out) const;
  void tied_slopes(const Workspace& w, const std::vector<Tie>& ties, const double* M, const double* right,
                   double* out) const;
  void internal_rates(const Workspace& w, double t, const double* x, double* rate) const;
  void transmission(Workspace& w, double t, const double* x) const;
  void actuators(Workspace& w, double t, const double* x, const double* tau) const;
  void frictions(Workspace& w, double t, const double* x) const;
  void dry_frictions(Workspace& w, double t, const double* x) const;
  void coupled_solve(Workspace& w, const double* x, const std::vector<char>& held, std::vector<double>& acceleration,
                     std::vector<double>& reaction) const;
  void difference_jacobian(Workspace& w, double t, const double* x, const double* tau, const ExternalTorque& external,
                           double* out) const;
  void couple_rotors(Workspace& w, const double* x) const;
  void solve(Workspace& w, double t, const double* x, const double* tau_ext) const;
  double relative_speed(const DryContact& contact, double u, const double* x) const;
  void rub(Workspace& w, std::size_t contact) const {  // its friction into f_link or f_motor
    const DryContact& dry = dry_[contact];
    (dry.side == Side::link ? w.f_link : w.f_motor)[dry.joint] += w.friction[contact];
    if (dry.couples()) w.f_motor[dry.other] -= dry.ratio * w.friction[contact];
  }
  // Couplings that stick, and the accelerations they leave: friction of each into the workspace.
  std::vector<Tie> ties(const Workspace& w) const;
  void tied_solve(Workspace& w, const std::vector<Tie>& ties, double t, const double* x) const;
  Box box_at(const Workspace& w, int velocity, double t, const double* x) const;
  // Of a rigid joint's dry friction, the part of its motor-side laws: before the gear.
  double motor_share(const Workspace& w, std::size_t contact, double t, const double* x) const;
  LawInput input(const Workspace& w, const Law& law, double t, const double* x) const;
  LawInput spring_input(const Workspace& w, const Law& law, double t, const double* x) const;
  double level_of(const Workspace& w, const Law& law, double t, const double* x, double direction) const;
  double corner_rounding(const Law& law, const double* x) const;
  // The piece that a friction, dry or link law is on: the one held, else that of the point, which `follow` notes down.
  int region_at(const Workspace& w, const Law& law, const LawInput& in) const;
  int follow(Workspace& w, const Law& law, const LawInput& in) const;

  std::shared_ptr<const LinkDynamics> links_;
  int n_;
  int internal_ = 0;
  int laws_ = 0;
  std::vector<int> elastic_;     // joints with a finite stiffness
  std::vector<int> rotor_slot_;  // joint -> place among the elastic ones, -1 = rigid
  std::vector<double> K_, D_, J_, spin_, delay_;
  bool callbacks_ = false;  // laws in Python: they may depend on time
  bool plain_ = true;      // no law in any transmission
  bool coupled_ = false;  // spin_ is not all zero
  bool couplings_ = false;  // some contact couples
  bool spans_ = false;      // some law sees a combination of joints
  bool windings_ = false;   // some motor has inductance
  std::vector<Law> actuator_, deflection_, spring_, damper_, friction_, link_;
  std::vector<DryContact> dry_;
  std::vector<Law> switches_;    // laws with a corner, each with its region's place
};

}  // namespace flexdyn
