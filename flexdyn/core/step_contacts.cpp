#include "step_contacts.hpp"

#include <Eigen/LU>

#include "complementarity.hpp"
#include "matrices.hpp"

namespace flexdyn {

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

// Motions of the last step first.
VectorXd StepContacts::boxed_solve(const MatrixXd& A, const VectorXd& b) {
  const auto& contacts = plant_.contacts();
  load_.resize(contacts.size());
  state_.assign(plant_.state_size(), 0.0);
  const auto breaks_away = [&](std::size_t c) {
    const Box box = box_of(c);
    return load_[c] > box.above ? forward : load_[c] < -box.below ? backward : stuck;
  };
  settle_by_pivoting(
      plant_, every_, motion_, [&] { solve(A, b); },
      [&](std::size_t c) { return plant_.contact_speed(contacts[c], state_.data()); }, breaks_away,
      [&](std::size_t c) { motion_[c] = motion_[c] == stuck ? breaks_away(c) : stuck; });
  return Map<const VectorXd>(state_.data() + N_, N_);
}

// Velocities, and the load of each stuck contact, where every contact goes on as it is taken to.
void StepContacts::solve(const MatrixXd& A, const VectorXd& b) {
  const auto& contacts = plant_.contacts();
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
  if (plant_.has_couplings()) solve_tied(A, rest, held, ties);
  else solve_apart(A, rest, held);
}

// No motors are coupled by dry friction: a contact holds one velocity.
void StepContacts::solve_apart(const MatrixXd& A, const VectorXd& rest, const std::vector<char>& held) {
  const auto& contacts = plant_.contacts();
  Map<VectorXd> w(state_.data() + N_, N_);
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
    const int at = place(contacts[c]);
    if (motion_[c] == stuck) load_[c] = rest[at] - A.row(at).dot(w);
  }
}

// Where motors are coupled by dry friction.
void StepContacts::solve_tied(const MatrixXd& A, const VectorXd& rest, const std::vector<char>& held,
                              const std::vector<Tie>& ties) {
  const auto& contacts = plant_.contacts();
  Map<VectorXd> w(state_.data() + N_, N_);
  const MatrixXd T = free_moves(held, ties);
  w.setZero();
  if (T.cols() > 0) w = T * MatrixXd(T.transpose() * A * T).partialPivLu().solve(VectorXd(T.transpose() * rest));
  VectorXd reaction = rest - A * w;
  for (const Tie& tie : ties) {
    load_[tie.contact] = take_share(tie, held, box_of(tie.contact), box_at(tie.one), box_at(tie.other),
                                    reaction[tie.one], reaction[tie.other]);
  }
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (!contacts[c].couples()) load_[c] = reaction[place(contacts[c])];
  }
}

Box StepContacts::box_at(int velocity) const {
  const auto& contacts = plant_.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (!contacts[c].couples() && place(contacts[c]) == velocity) return box_of(c);
  }
  return {};
}

}  // namespace flexdyn
