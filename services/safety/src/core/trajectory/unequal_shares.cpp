#include "core/trajectory/unequal_shares.hpp"

#include <algorithm>
#include <cmath>

#include "core/geometry/distances.hpp"

namespace fairlead {
namespace {

// How far a row asks a joint to go, of which that share happened: what the row before left is no
// part of it.
double asked_by(double way, double way_before, double share) {
  return (way - (1.0 - share) * way_before) / share;
}

}  // namespace

// Where what is left of a row is asked for again, the rows after it do more of it: together all but
// what each of their shares leaves.
void UnequalShares::add_row(const SharedRow& row) {
  const auto& [gain, goes_on] = row.by;
  const double lower = gain != nullptr ? gain->lower : 0.0;
  const double upper = gain != nullptr ? gain->upper : 1.0;
  if (!goes_on) first_open_ = row_count_;
  for (std::size_t k = first_open_; k < row_count_; ++k) {
    rows_[k].left_by_lower *= 1.0 - lower;
    rows_[k].left_by_upper *= 1.0 - upper;
  }
  goes_on_ = goes_on && row_count_ > 0;
  Row& added = rows_[row_count_];
  for (const std::size_t j : JointsIn(joints_)) {
    if (gain != nullptr) {
      note_asked(row, j);
      continue;
    }
    added.asked[j] = row.upper[j] - row.lower[j];
    follows_others_ |= added.asked[j] != 0.0;
    last_lower_[j] = last_upper_[j] = least_left_[j] = most_left_[j] = 0.0;
  }
  added.left_by_lower = 1.0 - lower;
  added.left_by_upper = 1.0 - upper;
  ++row_count_;
}

// The ends ask it of a joint by the tool's Jacobian where each of them leads. Between them it is
// taken to be asked for the least or the most of both: exact where the Jacobian stays the same.
void UnequalShares::note_asked(const SharedRow& row, std::size_t j) {
  const auto [lower, upper] = *row.by.gain;
  const double one = asked_by(row.upper[j], goes_on_ ? last_upper_[j] : 0.0, upper);
  const double other =
      lower > 0.0 ? asked_by(row.lower[j], goes_on_ ? last_lower_[j] : 0.0, lower) : one;
  rows_[row_count_].asked[j] = one;
  last_lower_[j] = row.lower[j];
  last_upper_[j] = row.upper[j];
  const double least = smaller(one, other) + (goes_on_ ? least_left_[j] : 0.0);
  const double most = larger(one, other) + (goes_on_ ? most_left_[j] : 0.0);
  least_[j] = std::min(lower * least, upper * least);
  most_[j] = std::max(lower * most, upper * most);
  least_left_[j] = std::min((1.0 - lower) * least, (1.0 - upper) * least);
  most_left_[j] = std::max((1.0 - lower) * most, (1.0 - upper) * most);
}

double UnequalShares::width(std::size_t row, std::size_t j, const Joints* stop) const {
  const Row& of = rows_[row];
  const double more = stop != nullptr && row + 1 == row_count_ ? (*stop)[j] : 0.0;
  return of.asked[j] * (of.left_by_lower - of.left_by_upper) + more;
}

// With d_k the rows, D their sum and weights w_k >= 0 that add up to 1, equal shares of the sum of
// w_k s_k lead to that times D. What is left, the sum of s_k (d_k - w_k D), has terms that add up
// to nothing for equal s_k, so it is half the sum of their sizes at most, whatever the weights.
// It is least for rows alike if each has the weight of how far it goes along D. Of joints that
// other parts move along nobody knows which shares are equal: they are off by all of it.
void UnequalShares::raise_to_bound(const Joints* stop, Joints& off) const {
  Joints total;
  for (const std::size_t j : JointsIn(joints_)) {
    total[j] = 0.0;
    for (std::size_t row = 0; row < row_count_; ++row) total[j] += width(row, j, stop);
  }
  std::array<double, most_rows> weights;
  double sum = 0.0;
  for (std::size_t row = 0; row < row_count_; ++row) {
    double along = 0.0;
    for (const std::size_t j : JointsIn(joints_)) along += width(row, j, stop) * total[j];
    weights[row] = follows_others_ ? 0.0 : std::max(along, 0.0);
    sum += weights[row];
  }
  const double half = follows_others_ ? 1.0 : 0.5;
  if (!(sum > 0.0)) sum = 1.0;
  for (const std::size_t j : JointsIn(joints_)) {
    double sizes = 0.0;
    for (std::size_t row = 0; row < row_count_; ++row)
      sizes += std::abs(width(row, j, stop) - weights[row] / sum * total[j]);
    off[j] = larger(off[j], half * sizes);
  }
}

bool UnequalShares::shift_to_least(std::size_t row, Joints& joints) const {
  bool moves = false;
  for (const std::size_t j : JointsIn(joints_)) {
    const double way = width(row, j, nullptr);
    joints[j] -= way;
    moves |= way != 0.0;
  }
  return moves;
}

// Of a row that begins anew the ends of its own gain say all.
bool UnequalShares::widen_speeds(double period_s, const Joints& less, const Joints& more,
                                 Joints& lowest, Joints& highest) const {
  if (!goes_on_) return false;
  for (const std::size_t j : JointsIn(joints_)) {
    lowest[j] = smaller(lowest[j], (least_[j] - less[j]) / period_s);
    highest[j] = larger(highest[j], (most_[j] + more[j]) / period_s);
  }
  return true;
}

}  // namespace fairlead
