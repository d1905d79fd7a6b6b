// Where the rows take the joints, row by row from what is measured.
//
// Joint targets are reached within their tick. Of velocities, deltas and twists the declared gain
// says which share happens: both ends of it are carried, as two branches. A torque leads nowhere
// that could be known: the joint stays where it is measured, as fast as it is measured. What
// nothing commands, grippers and passive joints stay where they are measured.
#pragma once

#include "../row_view.hpp"
#include "fairlead_safety/path.hpp"
#include "frames.hpp"

namespace fairlead {

/// One end of the gain: the configuration after a row, how fast the joints go there, and the
/// configuration before the row.
struct Branch {
  Joints now;
  Joints speed;
  Joints before;
};

class Prediction {
 public:
  Prediction(const PathPlan& plan, const ClaimLimits& claim, const MeasuredState& state,
             const ActionChunk& chunk, std::size_t first_row, const RowBefore& before,
             Companions companions);

  /// Goes on by one row, of the chunk and of its companions. G030 where the chunk's leads nowhere.
  Evidence advance();

  [[nodiscard]] std::size_t row() const { return row_; }  // the one that was gone to last
  [[nodiscard]] std::size_t branch_count() const { return branch_count_; }
  [[nodiscard]] const Branch& branch(std::size_t index) const { return branches_[index]; }
  /// Joints that the chunk's own rows command.
  [[nodiscard]] JointSet commanded() const { return commanded_; }
  /// Joints whose position or speed changes on the way.
  [[nodiscard]] JointSet moving() const { return moving_; }

 private:
  struct Command {
    const ActionPart& action;
    const ModeLimits& modes;
    Setpoint row;
    [[nodiscard]] double gain(std::size_t branch) const;
  };

  void start_still();
  void include(const ActionChunk& chunk, JointSet& joints);
  void note_targets(const ActionChunk& chunk, std::size_t row);
  Evidence apply_rows(const RowBefore& own, std::size_t steps, bool before);
  Evidence apply_row(const ActionChunk& chunk, std::size_t row, bool own, bool poses);
  Evidence apply(const Command& command, std::size_t branch);
  void apply_targets(const Command& command, Branch& branch);
  void apply_velocities(const Command& command, std::size_t index);
  void apply_torques(const Command& command, Branch& branch);
  Evidence apply_tool_motion(const Command& command, std::size_t index);
  Evidence apply_pose(const Command& command, Branch& branch);
  void apply_body_twist(const Command& command, std::size_t index);
  void note_speed(Branch& branch, std::size_t joint, double change) const;
  [[nodiscard]] Evidence check_finite() const;

  const PathPlan& plan_;
  const ClaimLimits& claim_;
  const MeasuredState& state_;
  const ActionChunk& chunk_;
  Companions companions_;
  std::size_t next_row_;
  std::size_t row_ = 0;
  std::size_t steps_ = 0;  // rows gone through since the first live one
  std::size_t branch_count_ = 1;
  JointSet commanded_ = 0;
  JointSet moving_ = 0;
  JointSet targets_told_ = 0;  // joints that the row before told a target
  std::array<double, max_joints> told_;
  std::array<Branch, 2> branches_;
};

}  // namespace fairlead
