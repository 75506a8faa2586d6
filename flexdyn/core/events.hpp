// Exact sticking and switching: which contacts slide, which stick, which piece each cornered law is on.
//
// Between events motions and regions are fixed and the equations are smooth. An event is the first instant at which
// one of them stops being true: a sliding contact comes to rest, a stuck one is loaded past its level, a law passes its
// corner. There the motions are found anew, all together: a contact at rest sticks if friction within its interval can
// hold it (a boxed linear complementarity problem, link contacts coupled through M(q)).
#pragma once

#include <limits>
#include <vector>

#include "plant.hpp"
#include "steppers.hpp"

namespace flexdyn {

class Events {
 public:
  // Torque asked for and external torque (may be null) at a point.
  using Torque = std::function<const double*(double t)>;
  using External = std::function<const double*(double t, const double* x)>;

  Events(const Plant& plant, Plant::Workspace& work, Torque torque, External external);

  // Find motions and regions at a point from nothing but the point.
  void settle(double t, const std::vector<double>& x);
  // While something sticks, a step that keeps the rest quiet: what noise there is must not shake it loose.
  double quiet_step() const { return any_stuck_ ? quiet_step_ : std::numeric_limits<double>::infinity(); }
  // Whether the arm stands still for good as long as nothing from outside changes: every velocity is exactly 0 and what
  // is left of the torques is rounding.
  bool at_rest(double t, const std::vector<double>& x);
  // What a step made of couplings that stick, mended to the last bit.
  void tie(double* x) const;
  // The first event within the step just taken from t_before; the step's end if there is none.
  double find(Stepper& stepper, double t_before);
  // End the step at the event found and settle what comes after it.
  void apply(Stepper& stepper, double t_event);
  bool found() const { return event_found_; }
  long count() const { return count_; }
  // Infinitely many events in finite time: time no longer moves on.
  bool stalled() const { return stalled_ > 400; }

 private:
  void evaluate(double t, const double* x, bool with_motion);
  void find_quiet_step(double t, const double* x);
  double margin(double t, const double* x, std::size_t guard) const;
  double margin_on_step(Stepper& stepper, double t, std::size_t guard);
  bool needs_evaluation(std::size_t guard) const;
  double locate(Stepper& stepper, std::size_t guard, double left, double right);
  void settle_regions(double t, const double* x);
  void settle_contacts(double t, const double* x);
  void settle_directions(double t, const double* x);
  void settle_resting(const std::vector<std::size_t>& resting, double t, const double* x);
  std::size_t guards() const { return plant_.contacts().size() + static_cast<std::size_t>(plant_.switches()); }

  const Plant& plant_;
  Plant::Workspace& work_;
  Torque torque_;
  External external_;
  std::vector<double> x_, dx_;
  std::vector<double> slack_;  // of each stuck contact: what rounding makes of its load beyond its level
  bool any_stuck_ = false;
  double quiet_step_ = 0.0;  // 0: not known yet
  bool event_found_ = false;
  long count_ = 0;
  int stalled_ = 0;
  double last_event_ = -1.0;
};

}  // namespace flexdyn
