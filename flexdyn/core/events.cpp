#include "events.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "complementarity.hpp"
#include "stiffness.hpp"

namespace flexdyn {

Events::Events(const Plant& plant, Plant::Workspace& work, Torque torque, External external)
    : plant_(plant), work_(work), torque_(std::move(torque)), external_(std::move(external)),
      x_(plant.state_size()), dx_(plant.state_size()), slack_(plant.contacts().size(), 0.0) {
  work_.located = true;
}

// Margins of regions need the laws alone; what a stuck contact holds needs the motion of the rest.
void Events::evaluate(double t, const double* x, bool with_motion) {
  if (with_motion) {
    plant_.derivative(work_, t, x, torque_(t), external_(t, x), dx_.data());
  } else {
    plant_.evaluate_laws(work_, t, x, torque_(t));
  }
}

// Positive while what was assumed over the step still holds.
double Events::margin(double t, const double* x, std::size_t guard) const {
  const auto& contacts = plant_.contacts();
  if (guard >= contacts.size()) return plant_.region_margin(work_, static_cast<int>(guard - contacts.size()), t, x);
  if (work_.motion[guard] != stuck) return work_.motion[guard] * plant_.contact_speed(contacts[guard], x);
  const double friction = work_.friction[guard];
  const double forwards = plant_.level(work_, guard, t, x, 1.0) - friction;
  const double backwards = plant_.level(work_, guard, t, x, -1.0) + friction;
  return std::min(forwards, backwards) + slack_[guard];
}

bool Events::needs_evaluation(std::size_t guard) const {
  return guard >= plant_.contacts().size() || work_.motion[guard] == stuck;
}

double Events::margin_on_step(Stepper& stepper, double t, std::size_t guard) {
  stepper.interpolate(t, x_.data());
  if (needs_evaluation(guard)) evaluate(t, x_.data(), guard < plant_.contacts().size());
  return margin(t, x_.data(), guard);
}

double Events::find(Stepper& stepper, double t_before) {
  const double t_end = stepper.t();
  double first = t_end;
  bool found = false;
  // The middle is looked at too: a joint may come to rest and start back within one step.
  for (const double t : {0.5 * (t_before + t_end), t_end}) {
    stepper.interpolate(t, x_.data());
    bool evaluated = false;
    for (std::size_t guard = 0; guard < guards(); ++guard) {
      if (needs_evaluation(guard) && !evaluated) {
        evaluate(t, x_.data(), any_stuck_);
        evaluated = true;
      }
      if (margin(t, x_.data(), guard) >= 0.0) continue;
      const double event = locate(stepper, guard, t_before, t);
      if (!found || event < first) first = event;
      found = true;
      stepper.interpolate(t, x_.data());
      evaluated = false;
    }
    if (found) break;
  }
  event_found_ = found;
  return first;
}

// Illinois' variant of the false position; the instant returned lies just past the event.
double Events::locate(Stepper& stepper, std::size_t guard, double left, double right) {
  double at_left = std::max(margin_on_step(stepper, left, guard), 0.0);
  double at_right = margin_on_step(stepper, right, guard);
  const double resolution = 4e-16 * std::max(1.0, std::abs(right));
  int side = 0;
  for (int i = 0; i < 100 && right - left > resolution; ++i) {
    double t = at_left > 0.0 && i < 60 ? (left * -at_right + right * at_left) / (at_left - at_right) : 0.5 * (left + right);
    if (!(t > left && t < right)) t = 0.5 * (left + right);
    const double value = margin_on_step(stepper, t, guard);
    if (value < 0.0) {
      right = t;
      at_right = value;
      if (side == -1) at_left *= 0.5;
      side = -1;
    } else {
      left = t;
      at_left = value;
      if (side == 1) at_right *= 0.5;
      side = 1;
      if (value == 0.0) at_left = 0.0;
    }
  }
  return right;
}

void Events::apply(Stepper& stepper, double t_event) {
  std::vector<double> x(plant_.state_size());
  stepper.interpolate(t_event, x.data());
  const auto& contacts = plant_.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (work_.motion[c] == stuck || work_.motion[c] * plant_.contact_speed(contacts[c], x.data()) > 0.0) continue;
    plant_.bring_to_rest(contacts[c], x.data());  // exactly
  }
  tie(x.data());
  plant_.limit_currents(x.data());
  stepper.truncate(t_event, x);
  const std::vector<int> motion = work_.motion, region = work_.region;
  const bool moved_on = t_event - last_event_ > 1e-12 * std::max(1.0, std::abs(t_event));
  stalled_ = moved_on ? 0 : stalled_ + 1;
  last_event_ = t_event;
  settle(t_event, x);
  // At the very edge of breaking away a contact may turn out to be held: that is no event.
  if (motion != work_.motion || region != work_.region) count_ += 1;
  stepper.keep_stable(quiet_step());
}

void Events::tie(double* x) const {
  const auto& contacts = plant_.contacts();
  for (std::size_t c = 0; plant_.has_couplings() && c < contacts.size(); ++c) {
    if (contacts[c].couples() && work_.motion[c] == stuck) plant_.bring_to_rest(contacts[c], x);
  }
}

void Events::settle(double t, const std::vector<double>& x) {
  settle_regions(t, x.data());
  settle_contacts(t, x.data());
  settle_directions(t, x.data());
  any_stuck_ = std::any_of(work_.motion.begin(), work_.motion.end(), [](int m) { return m == stuck; });
  if (any_stuck_ && quiet_step_ == 0.0) find_quiet_step(t, x.data());
}

bool Events::at_rest(double t, const std::vector<double>& x) {
  const int n = plant_.n(), N = plant_.velocities();
  if (!any_stuck_ || plant_.has_callbacks()) return false;
  if (std::any_of(x.begin() + N, x.begin() + 2 * N, [](double u) { return u != 0.0; })) return false;
  evaluate(t, x.data(), true);
  if (std::any_of(dx_.begin() + 2 * N, dx_.end(), [](double rate) { return rate != 0.0; })) return false;
  MatrixXd H(N, N);  // symmetric
  plant_.inertia(work_, x.data(), H.data());
  const VectorXd left = H * Map<const VectorXd>(dx_.data() + N, N);
  for (int j = 0; j < n; ++j) {
    const int slot = plant_.rotor_slot(j);
    double size = std::abs(work_.drive[j]) + std::abs(work_.tau_applied[j]);
    if (slot >= 0) size += plant_.stiffness(j) * (std::abs(x[j]) + std::abs(x[n + slot]));
    const double rounding = 16.0 * std::numeric_limits<double>::epsilon() * size;
    const bool link_stands = work_.held[j] || std::abs(left[j]) <= rounding;
    const bool rotor_stands = slot < 0 || work_.held[n + slot] || std::abs(left[n + slot]) <= rounding;
    if (!link_stands || !rotor_stands) return false;
  }
  return true;
}

// Dormand-Prince damps vibrations up to about 1 rad a step; beyond it they grow until the tolerance stops them, and a
// tolerance of 1e-8 rad is 0.1 N m on a spring of 1e7 N m/rad.
void Events::find_quiet_step(double t, const double* x) {
  constexpr double angle = 0.7;
  const std::vector<int> motion = work_.motion;
  const double fastest = fastest_rate(plant_, work_, t, x, torque_(t));
  work_.located = true;
  work_.motion = motion;
  settle_regions(t, x);
  quiet_step_ = fastest > 0.0 ? angle / fastest : std::numeric_limits<double>::infinity();
}

void Events::settle_regions(double t, const double* x) {
  work_.located = false;
  work_.smoothing = 1.0;  // friction of this call is not used
  plant_.evaluate_laws(work_, t, x, torque_(t));
  work_.located = true;
}

// A law that is nothing at its corner, on either piece, leaves the accelerations as they are: so these say on which
// piece the motion goes on.
void Events::settle_directions(double t, const double* x) {
  std::vector<int> open;
  for (int which = 0; which < plant_.switches(); ++which) {
    if (plant_.at_zero_corner(work_, which, t, x)) open.push_back(which);
  }
  if (open.empty()) return;
  constexpr double soon = 1e-5;
  evaluate(t, x, true);
  const int half = plant_.velocities();
  std::vector<double> ahead(x, x + plant_.state_size());
  for (int i = 0; i < half; ++i) {
    ahead[i] += soon * (dx_[i] + 0.5 * soon * dx_[half + i]);
    ahead[half + i] += soon * dx_[half + i];
  }
  evaluate(t, ahead.data(), false);
  for (const int which : open) work_.region[which] = plant_.current_region(work_, which, t, ahead.data());
  evaluate(t, x, true);
}

void Events::settle_contacts(double t, const double* x) {
  const auto& contacts = plant_.contacts();
  std::vector<std::size_t> resting;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const double u = plant_.contact_speed(contacts[c], x);
    work_.motion[c] = u > 0.0 ? forward : u < 0.0 ? backward : stuck;
    if (u == 0.0) resting.push_back(c);
  }
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    slack_[c] = plant_.load_rounding(contacts[c].joint, x);
    if (contacts[c].couples()) slack_[c] += plant_.load_rounding(contacts[c].other, x);
  }
  if (!resting.empty()) settle_resting(resting, t, x);
}

// What is looked at are the very numbers that the integration goes on with, so that it finds no contradiction where this
// saw none.
void Events::settle_resting(const std::vector<std::size_t>& resting, double t, const double* x) {
  const auto& contacts = plant_.contacts();
  std::size_t freed = contacts.size();  // the contact of the last pivot if it broke away, and by how much
  double excess = 0.0;
  const auto breaks_away = [&](std::size_t c) {
    if (!(margin(t, x, c) < 0.0)) return stuck;
    return work_.friction[c] > 0.0 ? forward : backward;
  };
  const auto flip = [&](std::size_t c) {
    if (work_.motion[c] == stuck) {
      freed = c;
      excess = slack_[c] - margin(t, x, c);
      work_.motion[c] = breaks_away(c);
      return;
    }
    work_.motion[c] = stuck;
    // Alone it can neither stick nor slide: its load is at its level up to rounding. It sticks until the load is
    // clearly above, or else every instant from here on would be an event.
    if (c == freed) slack_[c] = std::max(slack_[c], 2.0 * excess);
    freed = contacts.size();
  };
  settle_by_pivoting(
      plant_, resting, work_.motion, [&] { evaluate(t, x, true); },
      [&](std::size_t c) { return plant_.contact_speed(contacts[c], dx_.data()); }, breaks_away, flip);
}

}  // namespace flexdyn
