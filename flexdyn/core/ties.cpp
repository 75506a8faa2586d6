#include "ties.hpp"

#include <algorithm>

namespace flexdyn {

MatrixXd free_moves(const std::vector<char>& held, const std::vector<Tie>& ties) {
  const auto size = static_cast<Eigen::Index>(held.size());
  std::vector<char> still = held, led(held.size(), 0);
  for (const Tie& tie : ties) {
    still[tie.one] = still[tie.other] = still[tie.one] || still[tie.other];
    led[tie.one] = 1;
  }
  std::vector<Eigen::Index> column(held.size(), -1);
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (!still[i] && !led[i]) column[i] = count++;
  }
  MatrixXd moves = MatrixXd::Zero(size, count);
  for (Eigen::Index i = 0; i < size; ++i) {
    if (column[i] >= 0) moves(i, column[i]) = 1.0;
  }
  for (const Tie& tie : ties) {
    if (column[tie.other] >= 0) moves(tie.one, column[tie.other]) = tie.ratio;
  }
  return moves;
}

double take_share(const Tie& tie, const std::vector<char>& held, const Box& own, const Box& of_one, const Box& of_other,
                  double& on_one, double& on_other) {
  double share = on_one;
  if (held[tie.one]) {
    share = -on_other / tie.ratio;
    if (held[tie.other]) {
      const double a = (-of_other.below - on_other) / tie.ratio, b = (of_other.above - on_other) / tie.ratio;
      const double least = std::max({on_one - of_one.above, std::min(a, b), -own.below});
      const double most = std::min({on_one + of_one.below, std::max(a, b), own.above});
      share = std::clamp(0.5 * (least + most), -own.below, own.above);
    }
  }
  on_one -= share;
  on_other += tie.ratio * share;
  return share;
}

}  // namespace flexdyn
