#include "time_stepping.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "matrices.hpp"
#include "step_contacts.hpp"

namespace flexdyn {

namespace {

// An internal state z' = u - decay |u| z over a step at constant u: exact, however stiff the bristle is.
struct Bristle {
  double z_end, torque, slope;  // z at the step's end, the torque there and its derivative by u
};

Bristle bristle(const Law& law, double z, double u, double h) {
  const BristleSpring spring = bristle_spring(law.kind, law.p);
  const double sign = u < 0.0 ? -1.0 : 1.0, kept = std::exp(-spring.decay * std::abs(u) * h);
  const double z_end = kept * z + (1.0 - kept) * sign / spring.decay;
  const double z_slope = h * kept * (1.0 - spring.decay * sign * z);
  return {z_end, spring.stiffness * z_end + spring.damping * (z_end - z) / h,
          (spring.stiffness + spring.damping / h) * z_slope};
}

class TimeStepping : public Stepper {
 public:
  TimeStepping(const Plant& plant, Plant::Workspace& work, Events::Torque torque, Events::External external,
               double step)
      : plant_(plant), work_(work), torque_(std::move(torque)), external_(std::move(external)), grid_(step),
        n_(plant.n()), N_(plant.velocities()), contacts_(plant) {
    work_.located = true;
    for (const auto* laws : {&plant.frictions(), &plant.springs()}) {
      for (const Law& law : *laws) bristles_ = bristles_ || law.state >= 0;
    }
  }

  void start(double t, const std::vector<double>& x) override {
    t_ = t;
    grid_.restart(t);
    x_ = before_ = x;
    H_.resize(N_, N_);
    by_q_.resize(n_, n_);
    by_v_.resize(n_, n_);
    bias_.resize(N_);
  }

  void restart() override { grid_.restart(t_); }

  bool step(double limit, Failure&) override {
    const double end = grid_.next(t_, limit);
    h_ = grid_.h();
    t_before_ = t_;
    before_ = x_;
    const double* tau = torque_(0.5 * (t_ + end));
    follow_regions(t_, x_.data(), tau);
    for (int attempt = 0; attempt < 8; ++attempt) {
      solve_step(tau);
      // A corner passed within the step: the piece at its end is the one that acts (a stop does not pull).
      const std::vector<int> assumed = work_.region;
      follow_regions(end, after_.data(), tau);
      if (work_.region == assumed) break;
    }
    x_ = after_;
    plant_.limit_currents(x_.data());
    t_ = end;
    stats_.steps += 1;
    return true;
  }

  // Positions are linear in between and velocities those of the step's end: what the method itself assumes.
  void interpolate(double t, double* x) override {
    const double s = (t - t_before_) / h_;
    for (std::size_t i = 0; i < x_.size(); ++i) x[i] = before_[i] + s * (x_[i] - before_[i]);
    for (const DryContact& contact : plant_.contacts()) {
      if (plant_.contact_speed(contact, x_.data()) == 0.0) plant_.bring_to_rest(contact, x);
    }
  }

 private:
  void follow_regions(double t, const double* x, const double* tau) {
    if (plant_.switches() == 0) return;
    work_.located = false;
    work_.smoothing = 1.0;  // friction of this call is not used
    plant_.evaluate_laws(work_, t, x, tau);
    work_.located = true;
  }

  void solve_step(const double* tau) {
    std::fill(work_.motion.begin(), work_.motion.end(), static_cast<int>(stuck));  // friction is solved for below
    work_.without_internal = true;
    work_.winding_step = h_;
    plant_.local_slopes(work_, t_, x_.data(), tau, slopes_);
    work_.winding_step = -h_;  // what it was: the ledger counts what a whole step left in a winding
    work_.without_internal = false;
    stats_.evaluations += 1;
    plant_.inertia(work_, x_.data(), H_.data());
    plant_.bias(work_, x_.data(), bias_.data());
    const std::vector<double> rest(n_, 0.0);
    plant_.links().inverse_derivatives(*work_.links, x_.data(), plant_.v(x_.data()), rest.data(), by_q_.data(),
                                       by_v_.data());
    assemble();
    contacts_.levels(work_, t_, x_, h_);
    VectorXd w = Map<const VectorXd>(plant_.v(x_.data()), N_);
    if (!bristles_) {
      w = contacts_.boxed_solve(A_, b_);
    } else {
      for (int newton = 0; newton < 20; ++newton) {
        const VectorXd guess = w;
        MatrixXd A = A_;
        VectorXd b = b_;
        add_bristles(guess, A, b);
        w = contacts_.boxed_solve(A, b);
        if ((w - guess).lpNorm<Eigen::Infinity>() <= 1e-12 * (1.0 + w.lpNorm<Eigen::Infinity>())) break;
      }
    }
    finish(w);
  }

  void assemble() {
    const double h = h_;
    const double* w = plant_.v(x_.data());
    const double* ext = external_(t_, x_.data());
    A_ = H_;
    if (plant_.coupled() && A_.llt().info() != Eigen::Success) A_.setConstant(std::numeric_limits<double>::quiet_NaN());
    b_ = A_ * Map<const VectorXd>(w, N_);
    // Velocity products bilinear in the old and the new velocity: explicit ones feed the arm energy.
    A_.topLeftCorner(n_, n_) += 0.5 * h * by_v_;
    b_.head(n_) += 0.5 * h * by_v_ * Map<const VectorXd>(w, n_);
    for (int j = 0; j < n_; ++j) {
      const int slot = plant_.rotor_slot(j), r = n_ + slot;
      const int column[2] = {j, slot < 0 ? j : r};
      b_[j] += h * (slopes_.link[j] - bias_[j] + (ext ? ext[j] : 0.0));
      if (slot >= 0) b_[r] += h * (slopes_.rotor[j] - bias_[r]);
      for (int k = 0; k < 2; ++k) {
        if (k == 1 && slot < 0) continue;
        const int c = column[k];
        A_(j, c) -= h * slopes_.link_by[2 + k][j] + h * h * slopes_.link_by[k][j];
        b_[j] -= h * slopes_.link_by[2 + k][j] * w[c];
        if (slot < 0) continue;
        A_(r, c) -= h * slopes_.rotor_by[2 + k][j] + h * h * slopes_.rotor_by[k][j];
        b_[r] -= h * slopes_.rotor_by[2 + k][j] * w[c];
      }
    }
    if (!plant_.has_spans()) return;
    plant_.visit_spans(work_, t_, x_.data(), [&](const std::vector<double>& row, double by_x, double by_u) {
      const Map<const VectorXd> gain(row.data(), n_);
      A_.topLeftCorner(n_, n_) -= (h * by_u + h * h * by_x) * gain * gain.transpose();
      b_.head(n_) -= h * by_u * gain.dot(Map<const VectorXd>(w, n_)) * gain;
    });
  }

  // Forces of laws with an internal state, linearised in the velocity that drives them.
  template <typename Visit>
  void visit_bristles(const VectorXd& w, Visit visit) const {
    const double* z = plant_.z(x_.data());
    for (const Law& law : plant_.frictions()) {
      if (law.state < 0) continue;
      const int slot = plant_.rotor_slot(law.joint);
      const int at = law.side == Side::link || slot < 0 ? law.joint : n_ + slot;
      visit(law, at, -1, bristle(law, z[law.state], w[at], h_));
    }
    for (const Law& law : plant_.springs()) {
      if (law.state < 0) continue;
      const int r = n_ + plant_.rotor_slot(law.joint);
      const double gain = work_.rotor_gain[law.joint];
      const double rate = plant_.in_gap(work_, law.joint) ? 0.0 : gain * w[r] - w[law.joint];
      visit(law, law.joint, r, bristle(law, z[law.state], rate, h_));
    }
  }

  void add_bristles(const VectorXd& w, MatrixXd& A, VectorXd& b) const {
    visit_bristles(w, [&](const Law& law, int at, int rotor, const Bristle& end) {
      const auto [z_end, torque, slope] = end;
      if (rotor < 0) {
        A(at, at) += h_ * slope;
        b[at] -= h_ * (torque - slope * w[at]);
        return;
      }
      const double gain = work_.rotor_gain[law.joint], rate = gain * w[rotor] - w[at];
      const double constant = h_ * (torque - slope * rate);
      b[at] += constant;
      b[rotor] -= gain * constant;
      A(at, at) += h_ * slope;
      A(at, rotor) -= h_ * slope * gain;
      A(rotor, at) -= h_ * slope * gain;
      A(rotor, rotor) += h_ * slope * gain * gain;
    });
  }

  void finish(const VectorXd& w) {
    after_ = x_;
    for (int i = 0; i < N_; ++i) {
      after_[i] = x_[i] + h_ * w[i];
      after_[N_ + i] = w[i];
    }
    for (const Law& law : plant_.actuators()) {
      if (law.state < 0) continue;
      const std::size_t at = 2 * static_cast<std::size_t>(N_) + law.state;
      const int region = law.region < 0 ? 0 : work_.region[law.region], slot = plant_.rotor_slot(law.joint);
      LawInput in;
      in.u = w[slot < 0 ? law.joint : n_ + slot];
      in.z = x_[at];
      after_[at] = region != 0 ? region * winding_limit(law.p)
                               : winding_end(law.p, in, work_.winding_input[law.state], h_);
    }
    if (!bristles_) return;
    visit_bristles(w, [&](const Law& law, int, int, const Bristle& end) {
      after_[2 * static_cast<std::size_t>(N_) + law.state] = end.z_end;
    });
  }

  const Plant& plant_;
  Plant::Workspace& work_;
  Events::Torque torque_;
  Events::External external_;
  EqualSteps grid_;
  double h_ = 0.0, t_before_ = 0.0;
  int n_, N_;
  bool bristles_ = false;
  StepContacts contacts_;
  LocalSlopes slopes_;
  RowMatrix H_, by_q_, by_v_;
  MatrixXd A_;
  VectorXd b_, bias_;
  std::vector<double> before_, after_;
};

}  // namespace

std::unique_ptr<Stepper> make_time_stepping(const Plant& plant, Plant::Workspace& work, Events::Torque torque,
                                            Events::External external, double step) {
  return std::make_unique<TimeStepping>(plant, work, std::move(torque), std::move(external), step);
}

}  // namespace flexdyn
