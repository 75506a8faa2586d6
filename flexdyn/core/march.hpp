// The one loop that integrates: from switch to switch of the command, writing samples on the way.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "commands.hpp"
#include "drive.hpp"
#include "plant.hpp"
#include "steppers.hpp"

namespace flexdyn {

// Where samples go: row-major arrays (times, n) owned by the caller.
struct Output {
  const double* times;
  std::size_t count;
  double *q, *theta, *v, *omega, *tau, *tau_applied, *tau_s;
  double* z;                  // (times, internal states)
  double* ledger = nullptr;   // (times, Plant::ledger_size()), null: not kept
};

struct Report {
  Failure failure;
  StepperStats stats;
  long events = 0;
  double switched = std::numeric_limits<double>::infinity();  // when Rosenbrock took over
  std::size_t written = 0;      // samples in the output that are valid
  std::vector<double> x;        // last state reached
};

// Called some ten times a second of computing; may throw to stop the run.
using Poll = std::function<void(double t)>;

Report march(const Plant& plant, Command& command, const std::vector<ExternalWrench>& external,
             const std::vector<double>& x0, double duration, const SolverSettings& solver, const Output& output,
             const Poll& poll);

}  // namespace flexdyn
