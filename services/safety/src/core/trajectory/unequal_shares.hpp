// Of each row another share may happen: how far that can leave the joints from where equal shares
// do.
#pragma once

#include "core/kinematics/forward_kinematics.hpp"
#include "core/kinematics/robot_model.hpp"

namespace fairlead {

/// What decides which share of a row happens.
struct SharedBy {
  const Gain* gain = nullptr;  // nullptr: other parts' shares, which move it along
  bool goes_on = false;        // what the row before left to do is asked for again
};

/// A row of one part: how far the lower and the upper ends of all gains take each joint.
struct SharedRow {
  const Joints& lower;
  const Joints& upper;
  SharedBy by;
};

/// Row by row, how much further the upper ends of one part's gain take each joint than the lower.
/// Of k rows any shares leave a joint at the sum of s_k times that, 0 <= s_k <= 1. And how far the
/// newest row takes it at least and at most: where little of the rows before happened, by more than
/// either end says.
class UnequalShares {
 public:
  void begin(JointSet joints) {
    joints_ = joints;
    row_count_ = first_open_ = 0;
    follows_others_ = goes_on_ = false;
  }
  void add_row(const SharedRow& row);

  /// Raises `off`, by joint, to how far it can be at most from the nearest of where equal shares
  /// leave the part; with `stop`, what the upper end adds to the last row more than the lower.
  void raise_to_bound(const Joints* stop, Joints& off) const;

  /// Moves `joints` to where they are if the least of that row happened, not the most, by first
  /// order. Whether that is elsewhere.
  bool shift_to_least(std::size_t row, Joints& joints) const;

  /// Widens, by joint, `lowest` to `highest` to how fast any shares make the newest row [rad/s,
  /// m/s], and so much `less` or `more` [rad, m] by where it starts. Whether that can be faster
  /// than its ends.
  bool widen_speeds(double period_s, const Joints& less, const Joints& more, Joints& lowest,
                    Joints& highest) const;

 private:
  void note_asked(const SharedRow& row, std::size_t j);
  [[nodiscard]] double width(std::size_t row, std::size_t j, const Joints* stop) const;

  static constexpr std::size_t most_rows = max_rows + 1;  // one acts already
  struct Row {
    Joints asked;  // of all of it
    // What is left of it to do after all rows so far, for either end; their difference is its
    // width.
    double left_by_lower;
    double left_by_upper;
  };
  std::array<Row, most_rows> rows_;  // not set beyond the joints and rows
  std::size_t row_count_ = 0;
  std::size_t first_open_ = 0;  // of this and later ones what is left is still asked for
  bool follows_others_ = false;
  bool goes_on_ = false;  // the newest row
  Joints last_lower_, last_upper_;
  // Of the newest row, whatever shares happened: what it does, and what it leaves.
  Joints least_, most_;
  Joints least_left_, most_left_;
  JointSet joints_ = 0;
};

}  // namespace fairlead
