// The one loop that integrates: from switch to switch of the command, writing samples on the way.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "commands.hpp"
#include "plant.hpp"
#include "steppers.hpp"

namespace flexdyn {

struct ExternalWrench {
  WrenchPoint point;
  std::shared_ptr<const PiecewisePolynomial> samples;  // (force, moment), zero after its end
};

// Where samples go: row-major arrays (times, n) owned by the caller.
struct Output {
  const double* times;
  std::size_t count;
  double *q, *theta, *v, *omega, *tau, *tau_applied, *tau_s;
};

struct Report {
  Failure failure;
  StepperStats stats;
  long events = 0;
  std::size_t written = 0;      // samples in the output that are valid
  std::vector<double> x;        // last state reached
};

// Called some ten times a second of computing; may throw to stop the run.
using Poll = std::function<void(double t)>;

Report march(const Plant& plant, Command& command, const std::vector<ExternalWrench>& external,
             const std::vector<double>& x0, double duration, const SolverSettings& solver, const Output& output,
             const Poll& poll);

}  // namespace flexdyn
