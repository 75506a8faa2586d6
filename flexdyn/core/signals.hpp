// Signals over time as piecewise polynomials: degree 0 is held, 1 linear, 3 a cubic spline.
#pragma once

#include <vector>

namespace flexdyn {

struct PiecewisePolynomial {
  std::vector<double> breaks;  // (segments + 1,) [s], strictly increasing
  std::vector<double> coef;    // (segments, degree + 1, width): value = sum_k coef[s, k] (t - breaks[s])^k
  std::vector<double> last;    // (width,) value at the very end
  int degree = 0;
  int width = 0;

  int segments() const { return static_cast<int>(breaks.size()) - 1; }
  double end() const { return breaks.back(); }
  // The segment that holds t, right-continuous, clamped to the first and last.
  int segment(double t) const;
  void value(int segment, double t, double* out) const;
  void derivative(int segment, double t, double* out) const;
};

}  // namespace flexdyn
