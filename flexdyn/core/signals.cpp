#include "signals.hpp"

#include <algorithm>

namespace flexdyn {

int PiecewisePolynomial::segment(double t) const {
  const auto after = std::upper_bound(breaks.begin(), breaks.end(), t);
  const int s = static_cast<int>(after - breaks.begin()) - 1;
  return std::clamp(s, 0, segments() - 1);
}

void PiecewisePolynomial::value(int segment, double t, double* out) const {
  const double* c = &coef[static_cast<std::size_t>(segment) * (degree + 1) * width];
  const double s = t - breaks[segment];
  for (int i = 0; i < width; ++i) {
    double sum = c[degree * width + i];
    for (int k = degree - 1; k >= 0; --k) sum = sum * s + c[k * width + i];
    out[i] = sum;
  }
}

void PiecewisePolynomial::derivative(int segment, double t, double* out) const {
  const double* c = &coef[static_cast<std::size_t>(segment) * (degree + 1) * width];
  const double s = t - breaks[segment];
  for (int i = 0; i < width; ++i) {
    double sum = degree * c[degree * width + i];
    if (degree == 0) sum = 0.0;
    for (int k = degree - 1; k >= 1; --k) sum = sum * s + k * c[k * width + i];
    out[i] = sum;
  }
}

}  // namespace flexdyn
