#include "core/trajectory/unequal_shares.hpp"

#include <algorithm>
#include <cmath>

#include "core/geometry/margin.hpp"

namespace fairlead {

void UnequalShares::add_row(JointSet joints, const Joints& lower, const Joints& upper,
                            bool leaves_rest) {
  joints_ = joints;
  leaves_rest_ |= leaves_rest;
  Joints& row = rows_[row_count_++];
  for (const std::size_t j : JointsIn(joints)) row[j] = upper[j] - lower[j];
}

void UnequalShares::bound(const Joints& stop, Joints& off) const {
  off.fill(0.0);
  raise_to_bound(nullptr, off);
  raise_to_bound(&stop, off);
}

// With d_k the rows, D their sum and weights w_k >= 0 that add up to 1, equal shares of the sum of
// w_k s_k lead to that times D. What is left, the sum of s_k (d_k - w_k D), has terms that add up
// to nothing for equal s_k, so it is half the sum of their sizes at most, whatever the weights.
// It is least for rows alike if each has the weight of how far it goes along D. Without weights it
// is how far they lead from where half of each does.
void UnequalShares::raise_to_bound(const Joints* stop, Joints& off) const {
  const auto width = [&](std::size_t row, std::size_t j) {
    return rows_[row][j] + (stop != nullptr && row + 1 == row_count_ ? (*stop)[j] : 0.0);
  };
  Joints total;
  for (const std::size_t j : JointsIn(joints_)) {
    total[j] = 0.0;
    for (std::size_t row = 0; row < row_count_; ++row) total[j] += width(row, j);
  }
  std::array<double, most_rows> weights;
  double sum = 0.0;
  for (std::size_t row = 0; row < row_count_; ++row) {
    double along = 0.0;
    for (const std::size_t j : JointsIn(joints_)) along += width(row, j) * total[j];
    weights[row] = leaves_rest_ ? 0.0 : std::max(along, 0.0);
    sum += weights[row];
  }
  if (!(sum > 0.0)) sum = 1.0;
  for (const std::size_t j : JointsIn(joints_)) {
    double sizes = 0.0;
    for (std::size_t row = 0; row < row_count_; ++row)
      sizes += std::abs(width(row, j) - weights[row] / sum * total[j]);
    off[j] = larger(off[j], 0.5 * sizes);
  }
}

}  // namespace fairlead
