// The rows of a chunk against their limits, one after the other: G011, G020 to G023, G025. Which
// functions judge the rows of which mode:
//
//   absolute  G020: limits of a row by itself; and G011 for joints that the row moves
//   start     G021: the first live row against the measured state. `acted`: the row of the same
//             part, mode and frame that acts right before, nullptr if there is none
//   step      G022, and G021 or G023 against `acted`: the change from one row to the next
#pragma once

#include <algorithm>
#include <cmath>

#include "core/modes/commanded_motion.hpp"

namespace fairlead {

/// One row of one part's command, and all that it is judged by.
struct RowView {
  const RobotModel& model;
  const ModeLimits& modes;  // the claim's own
  const MeasuredState& state;
  Setpoint now;
  Setpoint previous;  // the row before it in its chunk; of no action for the first live row
  JointSet outside;   // measured joints outside their bounds
  bool is_acted_measured = true;  // where the row before the first live one has led
  const Limits& limits = model.limits;

  [[nodiscard]] const PartLimits& part() const { return limits.parts[now.action->part]; }
  [[nodiscard]] std::uint8_t mode() const { return now.action->mode; }
};

/// One number against a range that includes its ends.
inline Evidence in_range(std::string_view axis, double value, double lower, double upper,
                         std::string_view unit, const Text& source) {
  if (!(value <= upper)) return above(code::absolute, axis, value, upper, unit, source.view());
  if (!(value >= lower)) return below(code::absolute, axis, value, lower, unit, source.view());
  return {};
}

/// A change, of either sign, up to and including its limit.
inline Evidence at_most(std::uint32_t code, std::string_view axis, double value, double limit,
                        std::string_view unit, const Text& source) {
  if (std::abs(value) <= limit) return {};
  return above(code, axis, std::abs(value), limit, unit, source.view());
}

/// How much further than a step the first live target may be from what is measured: the step of the
/// target before it that acts already, if no state has shown that yet.
inline double unmeasured_step(const RowView& view, bool goes_on, double step_limit) {
  return goes_on && !view.is_acted_measured ? step_limit : 0.0;
}

/// How far `position` lies outside the bounds, signed by the side; 0 inside.
inline double excess(const Bounds& bounds, double position) {
  return std::max(0.0, position - bounds.upper) - std::max(0.0, bounds.lower - position);
}

/// Whether a measurement lies outside its bounds by more than their tolerance.
inline bool is_outside(const Bounds& bounds, double measured) {
  return !(std::abs(excess(bounds, measured)) <= bounds.tolerance);
}
/// The commanded joints that are measured so.
JointSet outside_of(const Limits& limits, const MeasuredState& state);

/// A joint of the part is outside and this row cannot be seen to bring it back.
/// Targets and velocities of the joint itself are judged by their mode instead.
Evidence check_outside(const RowView& view);

/// G011 and G020 of one row.
Evidence check_absolute(const RowView& view);

/// G021, G023, G025: the chunk's first live row against what acts before it and what is measured.
Evidence check_start(const RowView& view, const ClaimLimits& claim, const RowBefore& before);

/// G022, G025: a row against `view.previous`.
Evidence check_step(const RowView& view);

/// What a released row has to keep to when a newer state has been measured: G011.
Evidence check_acting(const RowView& view);

// joint_modes.cpp: joint_position and dex_hand_joint (targets), joint_velocity; `acting` is what
// must hold on when a newer state is measured
Evidence joint_acting(const RowView& view);
Evidence joint_target_absolute(const RowView& view);
Evidence joint_target_start(const RowView& view, const Setpoint* acted);
Evidence joint_velocity_absolute(const RowView& view);
Evidence joint_velocity_start(const RowView& view, const Setpoint* acted);
Evidence joint_velocity_step(std::uint32_t code, const RowView& view, const Setpoint& before);
Evidence joint_target_step(std::uint32_t code, const RowView& view, const Setpoint& before);

// cartesian_modes.cpp: cartesian_delta, cartesian_twist, body_twist
Evidence norm_absolute(const RowView& view);
Evidence delta_start(const RowView& view, const Setpoint* acted);
Evidence tool_twist_start(const RowView& view, const Setpoint* acted);
Evidence body_twist_start(const RowView& view, const Setpoint* acted);
Evidence norm_step(std::uint32_t code, const RowView& view, const Setpoint& before);

// cartesian_modes.cpp: cartesian_pose
Evidence pose_absolute(const RowView& view);
Evidence pose_start(const RowView& view, const Setpoint* acted);
Evidence pose_step(std::uint32_t code, const RowView& view, const Setpoint& before);

// joint_modes.cpp: gripper_position, gripper_binary, composite_mode
Evidence scalar_absolute(const RowView& view);
Evidence binary_absolute(const RowView& view);
Evidence gripper_start(const RowView& view, const Setpoint* acted);
Evidence scalar_step(std::uint32_t code, const RowView& view, const Setpoint& before);

/// Everything must outlive it.
struct RowLimitCheck {
  const RobotModel& model;
  const ClaimLimits& claim;
  const MeasuredState& state;
  const ActionChunk& chunk;
  std::size_t first_row;
  const RowBefore& before;
  const JointSet outside = outside_of(model.limits, state);

  /// What is wrong with the row, over all parts of the chunk: it runs for all of them or for none.
  [[nodiscard]] Evidence check(std::size_t row) const;

 private:
  [[nodiscard]] Evidence check_left_out_parts() const;
};

/// A part changes its mode as its transitions allow, and its mode or frame at standstill only.
/// `last`: its command in the row that acts before, nullptr if there is none.
Evidence check_change(const RowView& view, const RowBefore& before, const ActionPart* last);

/// Whether both are of the same mode and frame.
inline bool is_alike(const ActionPart& one, const ActionPart& other) {
  return one.mode == other.mode && one.frame_id == other.frame_id;
}

/// The first live row of a composite switch turns where every part of the claim stands still.
/// `now`: of no action where that row leaves the part out: then its switch is down.
Evidence check_switch(const Limits& limits, const MeasuredState& state, const ClaimLimits& claim,
                      const RowBefore& before, std::size_t part, const Setpoint& now);

/// A later row does not turn: nobody has measured yet that the robot stands still there.
Evidence check_later_switch(const RowView& view);

}  // namespace fairlead
