// The link side of the arm: M(q), h(q, v) and a = M^-1 (tau - h), all from Pinocchio.
//
// Pinocchio's headers are seen by link_dynamics.cpp alone: they take a minute to compile.
#pragma once

#include <memory>
#include <vector>

namespace flexdyn {

// A fixed-base tree of revolute and prismatic joints as plain numbers, one row per joint, parents first.
struct Tree {
  std::vector<int> parent;          // index of the parent joint, -1 = base
  std::vector<char> prismatic;      // else revolute (unwrapped angle)
  std::vector<double> axis;         // (m, 3) unit vector in the joint frame
  std::vector<double> rotation;     // (m, 3, 3) joint frame in the parent's, row-major
  std::vector<double> translation;  // (m, 3) [m]
  std::vector<double> mass;         // [kg]
  std::vector<double> com;          // (m, 3) [m] in the joint frame
  std::vector<double> inertia;      // (m, 3, 3) [kg m^2] about the centre of mass, joint axes
  std::vector<double> armature;     // [kg m^2] rotor inertia of rigid joints
  std::vector<double> gain;         // (m, n) q_tree = gain q + offset; identity where no joint mimics another
  std::vector<double> offset;       // (m,)
  double gravity[3];                // [m/s^2]
  int size() const { return static_cast<int>(parent.size()); }
};

// Where an external wrench acts: a frame fixed to joint `joint`, axes of the world or of the frame.
struct WrenchPoint {
  int joint;
  double rotation[9];     // frame in the joint frame, row-major
  double translation[3];  // [m]
  bool world_axes;
};

class LinkDynamics {
 public:
  explicit LinkDynamics(const Tree& tree);
  ~LinkDynamics();
  LinkDynamics(const LinkDynamics&) = delete;
  LinkDynamics& operator=(const LinkDynamics&) = delete;

  // Scratch memory of one integration: threads share the dynamics, never a workspace. To make one takes as long as a
  // hundred evaluations, so that those no longer used are kept for the next integration.
  struct Workspace;
  struct Kept;
  struct Deleter {
    std::shared_ptr<Kept> kept;
    void operator()(Workspace* workspace) const;
  };
  using WorkspacePtr = std::unique_ptr<Workspace, Deleter>;
  WorkspacePtr workspace() const;

  int size() const { return n_; }
  // Bodies of the tree, each with the joint that moves it.
  int bodies() const;

  // a = M(q)^-1 (tau - h(q, v)); ABA where no joint mimics another, else the projected M and h.
  void acceleration(Workspace& w, const double* q, const double* v, const double* tau, double* a) const;
  // The same with some joints held: a = 0 exactly where `held`, and there `reaction` is the torque against tau that
  // holds them; other entries of `reaction` are left alone (it may be tau itself).
  void held_acceleration(Workspace& w, const double* q, const double* v, const double* tau, const char* held, double* a,
                         double* reaction) const;
  // M(q), (n, n) row-major, armature of rigid joints included.
  void mass_matrix(Workspace& w, const double* q, double* M) const;
  // M(q) a + h(q, v), armature of rigid joints included.
  void inverse_dynamics(Workspace& w, const double* q, const double* v, const double* a, double* tau) const;
  // Of every joint of the tree: mass, first moment (3), inertia about the joint's origin (xx, xy, yy, xz, yz, zz) and
  // armature.
  static constexpr int inertial_parameters = 11;
  // What `inverse_dynamics` gains where bodies gain inertia, to which it is linear: (count, n) of `more`,
  // (count, m, inertial_parameters).
  void inertial_torques(Workspace& w, const double* q, const double* v, const double* a, const double* more, int count,
                        double* tau) const;
  // Derivatives of M(q) a + h(q, v) by q and v at given q, v, a, (n, n) row-major.
  void inverse_derivatives(Workspace& w, const double* q, const double* v, const double* a, double* by_q,
                           double* by_v) const;
  // Rotors that ride on their joint's parent link and spin about the joint's axis with angular momentum spin * omega
  // (spin = J / gear ratio, omega reflected) act on the links as gyrostats and feel the link's turning:
  //   links:  S(q) alpha + link_bias,     rotors:  S(q)^T a + rotor_bias,     S (n, n) row-major.
  void rotor_coupling(Workspace& w, const double* q, const double* v, const double* spin, const double* omega, double* S,
                      double* link_bias, double* rotor_bias) const;
  // h(q, v): Coriolis, centrifugal and gravity torques.
  void bias(Workspace& w, const double* q, const double* v, double* h) const;
  // Kinetic (armature included) and gravitational energy [J].
  void energy(Workspace& w, const double* q, const double* v, double& kinetic, double& potential) const;
  // tau += J(q)^T wrench, wrench = (force, moment) at the point.
  void add_wrench(Workspace& w, const double* q, const WrenchPoint& point, const double* wrench, double* tau) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::shared_ptr<Kept> kept_;
  int n_;
};

}  // namespace flexdyn
