#include "plant.hpp"

#include <algorithm>
#include <cmath>

namespace flexdyn {

Plant::Plant(std::shared_ptr<const LinkDynamics> links, std::vector<double> stiffness, std::vector<double> damping,
             std::vector<double> rotor_inertia, std::vector<double> spin, const std::vector<Law>& laws)
    : links_(std::move(links)), n_(links_->size()), rotor_slot_(n_, -1), K_(std::move(stiffness)),
      D_(std::move(damping)), J_(std::move(rotor_inertia)), spin_(std::move(spin)), delay_(n_, 0.0),
      coupled_(std::any_of(spin_.begin(), spin_.end(), [](double spin) { return spin != 0.0; })) {
  for (int j = 0; j < n_; ++j) {
    if (std::isinf(K_[j])) continue;
    rotor_slot_[j] = elastic();
    elastic_.push_back(j);
  }
  for (Law law : laws) {
    law.index = laws_++;
    callbacks_ = callbacks_ || law.callback != nullptr;
    sort_in(law);
  }
  plain_ = deflection_.empty() && spring_.empty() && damper_.empty();
  // Smooth laws, such as the kinematic error, come before the dead zone.
  std::stable_partition(deflection_.begin(), deflection_.end(), [](const Law& law) { return law.region < 0; });
}

void Plant::sort_in(Law law) {
  if (has(law.kind, adds_up)) {  // gaps in one transmission are one dead zone
    for (Law& known : deflection_) {
      if (known.kind != law.kind || known.joint != law.joint) continue;
      known.p[0] += law.p[0];
      if (known.region >= 0) switches_[known.region].p[0] = known.p[0];
      return;
    }
  }
  if (has(law.kind, delays_command)) {
    delay_[law.joint] += law.p[0];
    return;
  }
  if (has(law.kind, has_state)) law.state = internal_++;
  if (reaches_corner(law.kind, law.p)) {
    law.region = switches();
    switches_.push_back(law);
  }
  switch (law.stage) {
    case Stage::actuator:
      windings_ = windings_ || law.state >= 0;
      actuator_.push_back(law);
      return;
    case Stage::deflection: deflection_.push_back(law); return;
    case Stage::spring: (has(law.kind, beside_gap) ? damper_ : spring_).push_back(law); return;
    case Stage::friction: friction_.push_back(law); return;
    case Stage::link:
      spans_ = spans_ || !law.row.empty();
      link_.push_back(law);
      return;
    case Stage::dry: break;
  }
  if (law.other >= 0) return sort_in_coupling(law);
  const bool rigid = rotor_slot_[law.joint] < 0;
  auto contact = std::find_if(dry_.begin(), dry_.end(), [&](const DryContact& c) {
    return !c.couples() && c.joint == law.joint && (rigid || c.side == law.side);
  });
  if (contact == dry_.end()) contact = dry_.insert(contact, {law.joint, rigid ? Side::link : law.side, {}, -1, 0.0});
  contact->laws.push_back(law);
}

Plant::Workspace Plant::workspace() const {
  Workspace w;
  w.links = links_->workspace();
  for (auto* array : {&w.theta, &w.omega, &w.deflection, &w.deflection_rate, &w.rotor_gain, &w.spring,
                      &w.tau_applied, &w.tau_s, &w.tau_rotor, &w.tau_link, &w.f_link, &w.f_motor}) {
    array->assign(n_, 0.0);
  }
  w.friction.assign(dry_.size(), 0.0);
  w.motion.assign(dry_.size(), stuck);
  w.region.assign(switches_.size(), 0);
  w.switch_input.assign(switches_.size(), 0.0);
  w.winding_input.assign(internal_, 0.0);
  w.held.assign(velocities(), 0);
  for (auto* array : {&w.drive, &w.acceleration, &w.reaction}) array->assign(velocities(), 0.0);
  return w;
}

bool Plant::has_delay() const {
  return std::any_of(delay_.begin(), delay_.end(), [](double delay) { return delay > 0.0; });
}

void Plant::rotor(const double* x, double* theta, double* omega) const {
  const double* v_ = v(x);
  std::copy(x, x + n_, theta);
  std::copy(v_, v_ + n_, omega);
  for (int e = 0; e < elastic(); ++e) {
    theta[elastic_[e]] = x[n_ + e];
    omega[elastic_[e]] = v_[n_ + e];
  }
}

void Plant::assemble_drive(Workspace& w, const double* tau_ext) const {
  for (int j = 0; j < n_; ++j) {
    const int slot = rotor_slot_[j];
    const double drive = slot < 0 ? w.tau_applied[j] - w.f_motor[j] : w.tau_s[j];
    w.drive[j] = w.tau_link[j] + drive - w.f_link[j] + (tau_ext ? tau_ext[j] : 0.0);
    if (slot >= 0) w.drive[n_ + slot] = w.tau_applied[j] - w.tau_rotor[j] - w.f_motor[j];
  }
}

void Plant::held_solve(Workspace& w, const double* x, const std::vector<char>& held, std::vector<double>& acceleration,
                       std::vector<double>& reaction) const {
  if (coupled_) return coupled_solve(w, x, held, acceleration, reaction);
  const bool any = std::any_of(held.begin(), held.begin() + n_, [](char h) { return h != 0; });
  if (any) {
    links_->held_acceleration(*w.links, x, v(x), w.drive.data(), held.data(), acceleration.data(), reaction.data());
  } else {
    links_->acceleration(*w.links, x, v(x), w.drive.data(), acceleration.data());
  }
  for (int e = 0; e < elastic(); ++e) {
    const int i = n_ + e;
    acceleration[i] = held[i] ? 0.0 : w.drive[i] / J_[elastic_[e]];
    if (held[i]) reaction[i] = w.drive[i];
  }
}

void Plant::solve(Workspace& w, double t, const double* x, const double* tau_ext) const {
  assemble_drive(w, tau_ext);
  if (w.located && !dry_.empty()) {
    std::fill(w.held.begin(), w.held.end(), 0);
    for (std::size_t c = 0; c < dry_.size(); ++c) {
      if (w.motion[c] == stuck && !dry_[c].couples()) w.held[velocity_index(dry_[c]) - velocities()] = 1;
    }
    if (couplings_) {
      if (const std::vector<Tie> stuck_ones = ties(w); !stuck_ones.empty()) return tied_solve(w, stuck_ones, t, x);
    }
  }
  held_solve(w, x, w.held, w.acceleration, w.reaction);
  if (!w.located) return;
  for (std::size_t c = 0; c < dry_.size(); ++c) {
    if (w.motion[c] != stuck) continue;
    w.friction[c] = w.reaction[velocity_index(dry_[c]) - velocities()];  // what holds it
    rub(w, c);
  }
}

void Plant::derivative(Workspace& w, double t, const double* x, const double* tau, const double* tau_ext,
                       double* dx) const {
  evaluate_laws(w, t, x, tau);
  solve(w, t, x, tau_ext);
  const int half = n_ + elastic();
  std::copy(x + half, x + 2 * half, dx);  // q' = v, theta' = omega
  std::copy(w.acceleration.begin(), w.acceleration.end(), dx + half);
  internal_rates(w, t, x, dx + 2 * half);
}

void Plant::torques(Workspace& w, double t, const double* x, const double* tau, const double* tau_ext) const {
  evaluate_laws(w, t, x, tau);
  if (elastic() == n_) return;
  solve(w, t, x, tau_ext);
  if (coupled_) couple_rotors(w, x);
  for (int j = 0; j < n_; ++j) {
    if (rotor_slot_[j] >= 0) continue;
    double rotor = J_[j] * w.acceleration[j];
    if (coupled_) rotor += w.rotor_bias[j];  // the rotor's own inertia also turns with the link it rides on
    for (int k = 0; coupled_ && k < n_; ++k) rotor += w.S[static_cast<std::size_t>(k * n_ + j)] * w.acceleration[k];
    w.tau_s[j] = w.tau_applied[j] - w.f_motor[j] - rotor;
  }
  for (std::size_t c = 0; c < dry_.size(); ++c) w.tau_s[dry_[c].joint] -= motor_share(w, c, t, x);
}

}  // namespace flexdyn
