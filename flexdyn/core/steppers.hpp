// One step of x' = f(t, x): what a solver is to the march.
//
// A stepper knows nothing of commands, samples or output; it integrates from `t` towards a limit and can tell
// the state anywhere in the step it took last.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace flexdyn {

using RightHandSide = std::function<void(double t, const double* x, double* dx)>;
using Jacobian = std::function<void(double t, const double* x, double* J)>;  // (nx, nx) row-major

struct StepperStats {
  long steps = 0;
  long rejected = 0;
  long evaluations = 0;
};

// Why an integration stopped; empty reason: it did not.
struct Failure {
  std::string reason;
  double t = 0.0;
};

class Stepper {
 public:
  virtual ~Stepper() = default;
  virtual void start(double t, const std::vector<double>& x) = 0;
  // f has just jumped (a command switched): nothing remembered of it holds any longer.
  virtual void restart() = 0;
  // Take one step, at most to `limit`; false with `failure` set if none can be taken.
  virtual bool step(double limit, Failure& failure) = 0;
  // End the last step early, at t with state x (an event lies there).
  void truncate(double t, const std::vector<double>& x) {
    t_ = t;
    x_ = x;
    restart();
  }
  // State at t within the last step.
  virtual void interpolate(double t, double* x) = 0;

  // Explicit methods only: the step within which the fastest vibration dies down instead of building up out of
  // rounding errors to the size of the tolerance.
  void keep_stable(double step) { stable_step_ = step; }

  double t() const { return t_; }
  const std::vector<double>& x() const { return x_; }
  const StepperStats& stats() const { return stats_; }
  // Go on counting where another stepper left off.
  void take_over(const StepperStats& stats) { stats_ = stats; }

 protected:
  double stable_step_ = std::numeric_limits<double>::infinity();
  double t_ = 0.0;
  std::vector<double> x_;
  StepperStats stats_;
};

// Equal steps, none longer than asked, that end on every limit: command switches fall between steps.
class EqualSteps {
 public:
  explicit EqualSteps(double step) : step_(step) {}
  void restart(double t) { limit_ = t; }
  // End of the step that starts at t; h() is its length.
  double next(double t, double limit);
  double h() const { return h_; }

 private:
  double step_, h_ = 0.0, limit_ = 0.0, origin_ = 0.0;
  long count_ = 0, done_ = 0;
};

// The step to try out of the one wanted: it ends on the limit or leaves no sliver before it.
struct StepPlan {
  double h;
  bool last;
  // Whether time at t cannot resolve it.
  bool vanishes(double t) const;
};
StepPlan plan_step(double wanted, double left);

struct SolverSettings {
  std::string name;
  double step = 0.0;
  double rtol = 0.0;
  double atol = 0.0;
  double max_step = 0.0;
  double smoothing = 0.0;
  long most = 0;       // evaluations of f after which a run has failed; 0: as many as it takes
  long max_steps = 0;  // steps tried after which a run has failed, besides 10 for every interval; 0: as many as it takes
  // DormandPrince goes on as Rosenbrock, with these tolerances, where it meets a faster rate [1/s], or from a time on.
  double stiff_rate = std::numeric_limits<double>::infinity(), until = std::numeric_limits<double>::infinity();
  double stiff_rtol = 0.0, stiff_atol = 0.0;
};

std::unique_ptr<Stepper> make_runge_kutta4(RightHandSide f, double step);
std::unique_ptr<Stepper> make_dormand_prince(RightHandSide f, double rtol, double atol, double max_step);
std::unique_ptr<Stepper> make_rosenbrock(RightHandSide f, Jacobian jacobian, double rtol, double atol, double max_step);

}  // namespace flexdyn
