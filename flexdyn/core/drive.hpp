// What acts on the arm from outside at an instant: the command, its delays on the way to the motors, wrenches.
#pragma once

#include <memory>
#include <vector>

#include "commands.hpp"
#include "plant.hpp"

namespace flexdyn {

struct ExternalWrench {
  WrenchPoint point;
  std::shared_ptr<const PiecewisePolynomial> samples;  // (force, moment), zero after its end
};

// Times closer than this are one instant: k / rate and k * step differ in their last bits.
bool same_instant(double a, double b);

class Drive {
 public:
  Drive(const Plant& plant, Command& command, const std::vector<ExternalWrench>& wrenches, double duration);

  // Where the interval that starts at t ends: the next switch of anything, or the end of the run.
  double next_limit(double t) const;
  // A new interval starts at t with state x; `final` if the run ends here.
  void begin(double t, const std::vector<double>& x, bool final);

  double t_begin() const { return t_begin_; }
  // Whether nothing from outside changes within the interval begun last.
  bool constant() const;
  const double* asked(double t) { return command_.at(t); }  // tau of the command (n)
  const double* torque(double t);                           // what reaches the motors (n)
  const double* external(double t, const double* x);        // J^T of all wrenches (n), null if there are none

 private:
  double next_command_switch(double t) const;

  const Plant& plant_;
  Command& command_;
  const std::vector<ExternalWrench>& wrenches_;
  double duration_, t_begin_ = 0.0, t_inside_ = 0.0;
  bool delayed_, final_ = false;
  LinkDynamics::WorkspacePtr links_;
  std::vector<double> theta_, omega_, tau_ext_, late_;
};

}  // namespace flexdyn
