#include "core/modes/mode_table.hpp"

#include <array>

#include "core/modes/bounds_recovery.hpp"
#include "core/modes/mode_transition.hpp"

namespace fairlead {
namespace {

struct ModeChecker {
  Evidence (*absolute)(const RowView& view) = nullptr;
  Evidence (*start)(const RowView& view, const Setpoint* acted) = nullptr;
  Evidence (*step)(std::uint32_t code, const RowView& view, const Setpoint& before) = nullptr;
  Evidence (*acting)(const RowView& view) = nullptr;
};

// A composite switch has no state to start from, and a binary gripper may switch at any time.
Evidence start_anywhere(const RowView&, const Setpoint*) { return {}; }
Evidence step_anywhere(std::uint32_t, const RowView&, const Setpoint&) { return {}; }

// By mode number. Nothing judges the rows of the three empty ones: they are refused by name.
constexpr std::array<ModeChecker, mode_count> checkers{{
    // joint_position, joint_velocity
    {joint_target_absolute, joint_target_start, joint_step, joint_target_acting},
    {joint_velocity_absolute, joint_velocity_start, joint_velocity_step, joint_velocity_acting},
    {},                                                // joint_torque
    {},                                                // joint_trajectory
    {pose_absolute, pose_start, pose_step},            // cartesian_pose
    {norm_absolute, delta_start, norm_step},           // cartesian_delta
    {norm_absolute, tool_twist_start, norm_step},      // cartesian_twist
    {norm_absolute, body_twist_start, norm_step},      // body_twist
    {},                                                // foot_placement
    {binary_absolute, start_anywhere, step_anywhere},  // gripper_binary
    {scalar_absolute, gripper_start, scalar_step},     // gripper_position
    // dex_hand_joint
    {joint_target_absolute, joint_target_start, joint_step, joint_target_acting},
    {scalar_absolute, start_anywhere, scalar_step},  // composite_mode
}};

const ModeChecker& checker_of(const RowView& view) {
  static constexpr ModeChecker none{};
  return view.mode() < mode_count ? checkers[view.mode()] : none;
}

}  // namespace

Evidence check_absolute(const RowView& view) {
  const ModeChecker& checker = checker_of(view);
  if (checker.absolute == nullptr)
    return broken_rule(code::addressing, mode_name(view.mode()), "no checker for this mode",
                       view.mode());
  const Evidence evidence = check_outside(view);
  return evidence.ok() ? checker.absolute(view) : evidence;
}

Evidence check_start(const RowView& view, const ClaimLimits& claim, const RowBefore& before) {
  const ActionPart& action = *view.now.action;
  const ActionPart* last = command_before(before, action);
  const bool goes_on =
      last != nullptr && last->mode == action.mode && last->frame_id == action.frame_id;
  const Setpoint acted = goes_on ? row_of(*last, before.row, view.limits) : Setpoint{};
  Evidence evidence = check_change(view, before, last);
  if (evidence.ok()) evidence = check_switch(view, claim, before, acted);
  const ModeChecker& checker = checker_of(view);
  if (evidence.ok()) evidence = checker.start(view, goes_on ? &acted : nullptr);
  if (!evidence.ok() || !goes_on) return evidence;
  // A row that acts but is not measured yet is only expected: the seam to it is another check.
  return checker.step(before.measured ? code::start : code::seam, view, acted);
}

Evidence check_acting(const RowView& view) {
  const Evidence outside = check_outside(view);
  const ModeChecker& checker = checker_of(view);
  return !outside.ok() || checker.acting == nullptr ? outside : checker.acting(view);
}

Evidence check_step(const RowView& view) {
  const Evidence evidence = check_later_switch(view);
  return !evidence.ok() ? evidence : checker_of(view).step(code::step, view, view.previous);
}

}  // namespace fairlead
