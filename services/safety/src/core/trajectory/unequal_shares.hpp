// Of each row another share may happen: how far that can leave the joints from where equal shares
// do.
#pragma once

#include "core/kinematics/forward_kinematics.hpp"
#include "core/kinematics/robot_model.hpp"

namespace fairlead {

/// Row by row, how much further the upper ends of the gains take each joint than the lower ones.
/// Shares of k rows leave a joint at the sum of s_k times that, 0 <= s_k <= 1.
class UnequalShares {
 public:
  void clear() { row_count_ = 0; }
  /// Of a row, for those of `joints`: the same in each row. `leaves_rest`: what does not happen of
  /// a row is asked for again in the next; so a share of one changes what the others are shares of.
  void add_row(JointSet joints, const Joints& lower, const Joints& upper, bool leaves_rest);
  /// Of a single row any share lies between the ends of its gain.
  [[nodiscard]] bool can_differ() const { return row_count_ > 1; }

  /// By joint, how far it can be at most from the nearest of where equal shares leave all of them;
  /// also behind a stop that takes it `stop` further by the upper ends than by the lower.
  void bound(const Joints& stop, Joints& off) const;

 private:
  void raise_to_bound(const Joints* stop, Joints& off) const;

  static constexpr std::size_t most_rows = max_rows + 1;  // one acts already
  std::array<Joints, most_rows> rows_;                    // not set beyond the joints and rows
  std::size_t row_count_ = 0;
  JointSet joints_ = 0;
  bool leaves_rest_ = false;
};

}  // namespace fairlead
