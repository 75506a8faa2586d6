// The whole arm: links, rotors, transmissions and the laws on them, as x' = f(t, x, tau).
//
//   M(q) a + h(q, v) + f_link = tau_s + tau_ext       (paper, eq. 3)
//   J alpha + f_motor         = tau_applied - tau_s   (paper, eq. 4)
//
// State x = [q (n), theta (e), v (n), omega (e), z (internal states)], e = number of elastic joints.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "laws.hpp"
#include "link_dynamics.hpp"

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
};

// All dry laws on one joint and side: they add to one interval [-L_negative, L_positive], one contact that
// sticks as a whole.
struct DryContact {
  int joint;
  Side side;
  std::vector<Law> laws;
};

class Plant {
 public:
  Plant(std::shared_ptr<const LinkDynamics> links, std::vector<double> stiffness, std::vector<double> damping,
        std::vector<double> rotor_inertia, const std::vector<Law>& laws);

  struct Workspace {
    LinkDynamics::WorkspacePtr links;
    std::vector<double> tau_applied, tau_s, tau_link, f_link, f_motor, theta, omega, a;
    double smoothing = 0.0;  // width of the smoothed Sgn [rad/s]
  };
  Workspace workspace() const;

  int n() const { return n_; }
  int elastic() const { return static_cast<int>(elastic_.size()); }
  int state_size() const { return 2 * (n_ + elastic()); }
  bool has_dry_friction() const { return !dry_.empty(); }
  const LinkDynamics& links() const { return *links_; }

  // Views into x.
  const double* q(const double* x) const { return x; }
  const double* v(const double* x) const { return x + n_ + elastic(); }
  // theta and omega of every joint; rigid joints read q and v.
  void rotor(const double* x, double* theta, double* omega) const;

  // dx = f(t, x, tau); tau_ext (n) may be null. Leaves all torques of this instant in the workspace.
  void derivative(Workspace& w, double t, const double* x, const double* tau, const double* tau_ext, double* dx) const;
  // tau_applied and tau_s of this instant into the workspace. On a rigid joint tau_s is what the gear carries:
  // tau_applied - f_motor - J a.
  void torques(Workspace& w, double t, const double* x, const double* tau, const double* tau_ext) const;

 private:
  void evaluate_laws(Workspace& w, double t, const double* x, const double* tau) const;
  void solve_links(Workspace& w, const double* x, const double* tau_ext) const;

  std::shared_ptr<const LinkDynamics> links_;
  int n_;
  std::vector<int> elastic_;         // joints with a finite stiffness
  std::vector<int> rotor_slot_;      // joint -> place among the elastic ones, -1 = rigid
  std::vector<double> K_, D_, J_;
  std::vector<Law> actuator_, spring_, friction_;
  std::vector<DryContact> dry_;
};

}  // namespace flexdyn
