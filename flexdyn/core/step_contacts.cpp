#include "step_contacts.hpp"

#include <algorithm>

#include <Eigen/LU>

namespace flexdyn {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Rotor velocities that laws see are kept in the workspace: the level of a contact as if it moved at another one.
double level_at(const Plant& plant, Plant::Workspace& work, std::size_t c, double t, const double* x, int direction) {
  const DryContact& contact = plant.contacts()[c];
  const double saved = work.omega[contact.joint];
  if (contact.side == Side::motor) work.omega[contact.joint] = x[plant.velocity_index(contact)];
  const double level = plant.level(work, c, t, x, direction);
  work.omega[contact.joint] = saved;
  return level;
}

}  // namespace

void StepContacts::levels(Plant::Workspace& work, double t, const std::vector<double>& state, double h) {
  const auto& contacts = plant_.contacts();
  level_.resize(2 * contacts.size());
  std::vector<double> x = state;
  work.located = false;  // a level is that of the load as it is, on whatever piece the step ends
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const std::size_t at = plant_.velocity_index(contacts[c]);
    for (const int direction : {backward, forward}) {
      double& level = level_[2 * c + (direction > 0)];
      if (contacts[c].couples()) {
        level = h * plant_.level(work, c, t, x.data(), direction);
        continue;
      }
      x[at] = direction * state[at] > 0.0 ? state[at] : 0.0;
      level = h * level_at(plant_, work, c, t, x.data(), direction);
    }
    x[at] = state[at];
  }
  work.located = true;
}

// Bard's pivoting: flip the first contact that contradicts itself until none does; motions of the last step first.
VectorXd StepContacts::boxed_solve(const MatrixXd& A, const VectorXd& b) {
  const auto& contacts = plant_.contacts();
  VectorXd w(N_);
  for (int pivot = 0; pivot < 1000; ++pivot) {
    VectorXd rest = b;
    std::vector<char> held(N_, 0);
    std::vector<Tie> ties;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const int at = place(contacts[c]);
      const double sliding = motion_[c] * level_[2 * c + (motion_[c] > 0)];
      if (contacts[c].couples()) {
        const int other = other_place(contacts[c]);
        if (motion_[c] == stuck) ties.push_back({at, other, contacts[c].ratio, c});
        rest[at] -= sliding;
        rest[other] += contacts[c].ratio * sliding;
      } else if (motion_[c] == stuck) {
        held[at] = 1;
      } else {
        rest[at] -= sliding;
      }
    }
    if (plant_.has_couplings() ? settled(A, rest, held, ties, w) : consistent(A, rest, held, w)) break;
  }
  return w;
}

// One pivot: the velocities that are not held, the motion of the contacts, and whether none contradicts it.
bool StepContacts::consistent(const MatrixXd& A, const VectorXd& rest, const std::vector<char>& held, VectorXd& w) {
  const auto& contacts = plant_.contacts();
  std::vector<int> free;
  for (int i = 0; i < N_; ++i) {
    if (!held[i]) free.push_back(i);
  }
  w.setZero();
  if (!free.empty()) {
    const VectorXd moving = MatrixXd(A(free, free)).partialPivLu().solve(VectorXd(rest(free)));
    w(free) = moving;
  }
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const int at = place(contacts[c]), before = motion_[c];
    if (before != stuck) {
      if (before * w[at] <= 0.0) motion_[c] = stuck;
    } else {
      const double reaction = rest[at] - A.row(at).dot(w);
      if (reaction > level_[2 * c + 1]) motion_[c] = forward;
      else if (reaction < -level_[2 * c]) motion_[c] = backward;
    }
    if (motion_[c] != before) return false;
  }
  return true;
}

// One pivot where motors are coupled by dry friction: the motion of these contacts, and whether none contradicts it.
bool StepContacts::settled(const MatrixXd& A, const VectorXd& rest, const std::vector<char>& held,
                           const std::vector<Tie>& ties, VectorXd& w) {
  const auto& contacts = plant_.contacts();
  const MatrixXd T = free_moves(held, ties);
  w.setZero();
  if (T.cols() > 0) w = T * MatrixXd(T.transpose() * A * T).partialPivLu().solve(VectorXd(T.transpose() * rest));
  VectorXd reaction = rest - A * w;
  std::vector<double> friction(contacts.size(), 0.0);
  for (const Tie& tie : ties) {
    friction[tie.contact] = take_share(tie, held, box_of(tie.contact), box_at(tie.one), box_at(tie.other),
                                       reaction[tie.one], reaction[tie.other]);
  }
  std::vector<double> velocities(plant_.state_size(), 0.0);
  std::copy(w.data(), w.data() + N_, velocities.begin() + N_);
  int* pinned = nullptr;  // taken to slide and held by others and a coupling: these have to give way first
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const int before = motion_[c];
    if (before != stuck) {
      const double speed = before * plant_.contact_speed(contacts[c], velocities.data());
      if (speed == 0.0 && pinned == nullptr) pinned = &motion_[c];
      if (speed < 0.0) motion_[c] = stuck;
    } else {
      const double load = contacts[c].couples() ? friction[c] : reaction[place(contacts[c])];
      const Box box = box_of(c);
      if (load > box.above) motion_[c] = forward;
      else if (load < -box.below) motion_[c] = backward;
    }
    if (motion_[c] != before) return false;
  }
  if (pinned != nullptr) *pinned = stuck;
  return pinned == nullptr;
}

Box StepContacts::box_at(int velocity) const {
  const auto& contacts = plant_.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (!contacts[c].couples() && place(contacts[c]) == velocity) return box_of(c);
  }
  return {};
}

}  // namespace flexdyn
