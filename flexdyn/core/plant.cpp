#include "plant.hpp"

#include <algorithm>
#include <cmath>

namespace flexdyn {

Plant::Plant(std::shared_ptr<const LinkDynamics> links, std::vector<double> stiffness, std::vector<double> damping,
             std::vector<double> rotor_inertia, const std::vector<Law>& laws)
    : links_(std::move(links)), n_(links_->size()), rotor_slot_(n_, -1), K_(std::move(stiffness)),
      D_(std::move(damping)), J_(std::move(rotor_inertia)) {
  for (int j = 0; j < n_; ++j) {
    if (std::isinf(K_[j])) continue;
    rotor_slot_[j] = elastic();
    elastic_.push_back(j);
  }
  for (const Law& law : laws) {
    switch (law.stage) {
      case Stage::actuator: actuator_.push_back(law); break;
      case Stage::spring: spring_.push_back(law); break;
      case Stage::friction: friction_.push_back(law); break;
      case Stage::dry: {
        auto contact = std::find_if(dry_.begin(), dry_.end(), [&](const DryContact& c) {
          return c.joint == law.joint && c.side == law.side;
        });
        if (contact == dry_.end()) contact = dry_.insert(contact, {law.joint, law.side, {}});
        contact->laws.push_back(law);
        break;
      }
    }
  }
}

Plant::Workspace Plant::workspace() const {
  Workspace w;
  w.links = links_->workspace();
  for (auto* array : {&w.tau_applied, &w.tau_s, &w.tau_link, &w.f_link, &w.f_motor, &w.theta, &w.omega, &w.a}) {
    array->assign(n_, 0.0);
  }
  return w;
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

void Plant::evaluate_laws(Workspace& w, double t, const double* x, const double* tau) const {
  const double* q_ = x;
  const double* v_ = v(x);
  rotor(x, w.theta.data(), w.omega.data());
  for (int j = 0; j < n_; ++j) {
    w.tau_applied[j] = tau[j];
    w.f_link[j] = 0.0;
    w.f_motor[j] = 0.0;
  }
  for (const int j : elastic_) w.tau_s[j] = K_[j] * (w.theta[j] - q_[j]) + D_[j] * (w.omega[j] - v_[j]);
  for (const Law& law : spring_) {
    const int j = law.joint;
    const LawInput in{t, w.theta[j] - q_[j], w.omega[j] - v_[j]};
    w.tau_s[j] += law.callback ? (*law.callback)(in, 0.0) : spring_torque(law.kind, law.p, in);
  }
  for (const Law& law : actuator_) {
    double& torque = w.tau_applied[law.joint];
    const LawInput in{t, w.theta[law.joint], w.omega[law.joint]};
    torque = law.callback ? (*law.callback)(in, torque) : actuator_torque(law.kind, law.p, in, torque);
  }
  for (const Law& law : friction_) {
    const int j = law.joint;
    const bool link = law.side == Side::link;
    const LawInput in{t, link ? q_[j] : w.theta[j], link ? v_[j] : w.omega[j]};
    (link ? w.f_link : w.f_motor)[j] += law.callback ? (*law.callback)(in, 0.0) : friction_torque(law.kind, law.p, in);
  }
  for (const DryContact& contact : dry_) {
    const int j = contact.joint;
    const bool link = contact.side == Side::link;
    const LawInput in{t, link ? q_[j] : w.theta[j], link ? v_[j] : w.omega[j]};
    double level = 0.0;
    for (const Law& law : contact.laws) {
      level += law.callback ? (*law.callback)(in, 0.0) : dry_level(law.kind, law.p, in);
    }
    (link ? w.f_link : w.f_motor)[j] += level * smooth_sign(in.u, w.smoothing);
  }
}

void Plant::solve_links(Workspace& w, const double* x, const double* tau_ext) const {
  for (int j = 0; j < n_; ++j) {
    const double drive = rotor_slot_[j] < 0 ? w.tau_applied[j] - w.f_motor[j] : w.tau_s[j];
    w.tau_link[j] = drive - w.f_link[j] + (tau_ext ? tau_ext[j] : 0.0);
  }
  links_->acceleration(*w.links, x, v(x), w.tau_link.data(), w.a.data());
}

void Plant::derivative(Workspace& w, double t, const double* x, const double* tau, const double* tau_ext,
                       double* dx) const {
  evaluate_laws(w, t, x, tau);
  solve_links(w, x, tau_ext);
  const int half = n_ + elastic();
  std::copy(x + half, x + 2 * half, dx);  // q' = v, theta' = omega
  std::copy(w.a.begin(), w.a.end(), dx + half);
  for (int e = 0; e < elastic(); ++e) {
    const int j = elastic_[e];
    dx[half + n_ + e] = (w.tau_applied[j] - w.tau_s[j] - w.f_motor[j]) / J_[j];
  }
}

void Plant::torques(Workspace& w, double t, const double* x, const double* tau, const double* tau_ext) const {
  evaluate_laws(w, t, x, tau);
  if (elastic() == n_) return;
  solve_links(w, x, tau_ext);
  for (int j = 0; j < n_; ++j) {
    if (rotor_slot_[j] < 0) w.tau_s[j] = w.tau_applied[j] - w.f_motor[j] - J_[j] * w.a[j];
  }
}

}  // namespace flexdyn
