// Where the energy goes: powers integrated over the motion, each law apart.
#pragma once

#include <vector>

#include "drive.hpp"
#include "plant.hpp"
#include "steppers.hpp"

namespace flexdyn {

class Ledger {
 public:
  Ledger(const Plant& plant, Plant::Workspace& work, Drive& drive);
  // Add the work done from the last instant to t, within the step taken last (Gauss, order 6).
  void advance(Stepper& stepper, double t);
  // Nothing moved until t.
  void skip(double t) { t_ = t; }
  const std::vector<double>& sums() const { return sums_; }

 private:
  const Plant& plant_;
  Plant::Workspace& work_;
  Drive& drive_;
  double t_ = 0.0;
  std::vector<double> x_, dx_, power_, sums_;
};

}  // namespace flexdyn
