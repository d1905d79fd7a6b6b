#include "core/modes/row_limit_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/modes/row_view.hpp"
#include "fairlead_safety/mode_blocks.hpp"

namespace fairlead {

UnmovedJoint unmoved_joint(const Limits& limits, std::size_t measured) {
  const std::size_t commanded = limits.joints.size();
  if (measured >= commanded) {
    const PassiveLimits& joint = limits.passive_joints[measured - commanded];
    return {"passive", joint.name, &joint.bounds};
  }
  const JointLimits& joint = limits.joints[measured];
  if (!only_grips(limits.parts[joint.part].modes)) return {};
  return {"gripper", joint.name, &joint.bounds};
}

namespace {

// Modes whose own rule decides whether a row leads a joint back. A cartesian row does not say
// through which joints it leads.
bool decides_itself(const RowView& view, std::size_t joint) {
  switch (static_cast<Mode>(view.mode())) {
    case Mode::joint_position:
    case Mode::joint_velocity:
    case Mode::dex_hand_joint:
      return view.now.commands(joint);
    // A gripper's target is its joint's own position, and lies inside the range.
    case Mode::gripper_binary:
    case Mode::gripper_position:
      return true;
    default:
      return false;
  }
}

}  // namespace

Evidence check_outside(const RowView& view) {
  for (const std::size_t j : view.part().joints) {
    const JointLimits& joint = view.limits.joints[j];
    const double measured = view.state.positions[j];
    if (!joint.bounded || !is_outside(joint.bounds, measured) || decides_itself(view, j)) continue;
    constexpr std::string_view rule =
        "measured outside bounds + tolerance: only rows that reduce it";
    const std::string_view unit = position_unit(joint.kind);
    if (std::signbit(excess(joint.bounds, measured)))
      return below(code::state, joint.name.view(), measured, joint.bounds.lower, unit, rule);
    return above(code::state, joint.name.view(), measured, joint.bounds.upper, unit, rule);
  }
  return {};
}

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
    {joint_target_absolute, joint_target_start, joint_target_step, joint_target_acting},
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
    {joint_target_absolute, joint_target_start, joint_target_step, joint_target_acting},
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
    return broken_rule(code::addressing, mode_name(view.mode()), "a mode that has a checker",
                       view.mode());
  const Evidence evidence = check_outside(view);
  return evidence.ok() ? checker.absolute(view) : evidence;
}

Evidence check_start(const RowView& view, const ClaimLimits& claim, const RowBefore& before) {
  const ActionPart& action = *view.now.action;
  const Setpoint last = told_to(action.part, before, view.limits);
  const bool goes_on = last.action != nullptr && is_alike(*last.action, action);
  const Setpoint acted = goes_on ? last : Setpoint{};
  Evidence evidence = check_change(view, before, last.action);
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

bool rows_in_order(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                   const ActionPart& action, std::size_t first_row, std::size_t end_row) {
  const JointModeLimits* mode = joint_block(modes, action.mode);
  if (mode == nullptr) return false;
  for (const std::size_t j : limits.parts[action.part].joints) {
    const JointLimits& joint = limits.joints[j];
    if (joint.bounded && is_outside(joint.bounds, state.positions[j])) return false;
  }
  const std::size_t width = limits.joints.size();
  for (const std::uint8_t j : action.active) {
    const JointRange range = joint_range(limits.joints[j], *mode, action.mode);
    const double step = mode->step_limit[j];
    double before = action.values[first_row * width + j];
    bool in_order = true;
    for (std::size_t row = first_row; row < end_row; ++row) {
      const double now = action.values[row * width + j];
      in_order &= (now >= range.lower) & (now <= range.upper) & (std::abs(now - before) <= step);
      before = now;
    }
    if (!in_order) return false;
  }
  return true;
}

RowLimitCheck::RowLimitCheck(const RobotModel& model, const ClaimLimits& claim,
                             const MeasuredState& state, const ActionChunk& chunk,
                             std::size_t first_row, const RowBefore& before)
    : model_(model),
      limits_(model.limits),
      claim_(claim),
      state_(state),
      chunk_(chunk),
      first_row_(first_row),
      before_(before),
      in_order_(std::all_of(chunk.parts.begin(), chunk.parts.end(), [&](const ActionPart& action) {
        return rows_in_order(limits_, claim.modes[action.part], state, action, first_row,
                             chunk.horizon);
      })) {}

RowView RowLimitCheck::view_of(const ActionPart& action, std::size_t row) const {
  const bool follows = row > first_row_;
  return {model_, claim_.modes[action.part], state_, row_of(action, row, limits_),
          follows ? row_of(action, row - 1, limits_) : Setpoint{}};
}

Evidence RowLimitCheck::check(std::size_t row) const {
  if (in_order_ && row > first_row_) return {};
  const auto number = static_cast<std::int64_t>(row);
  for (const ActionPart& action : chunk_.parts) {
    const Evidence evidence = check_absolute(view_of(action, row));
    if (!evidence.ok()) return at(evidence, number, limits_.parts[action.part].name);
  }
  for (const ActionPart& action : chunk_.parts) {
    const RowView view = view_of(action, row);
    const Evidence evidence =
        row == first_row_ ? check_start(view, claim_, before_) : check_step(view);
    if (!evidence.ok()) return at(evidence, number, limits_.parts[action.part].name);
  }
  return row == first_row_ ? check_left_out_parts() : Evidence{};
}

Evidence RowLimitCheck::check_left_out_parts() const {
  const RowBefore first{&chunk_, first_row_};
  for (const std::size_t part : claim_.parts) {
    if (told_to(part, first, limits_).action != nullptr) continue;
    const Evidence evidence = check_left_out(limits_, state_, claim_, before_, part);
    if (!evidence.ok())
      return at(evidence, static_cast<std::int64_t>(first_row_), limits_.parts[part].name);
  }
  return {};
}

}  // namespace fairlead
