#include "core/modes/row_limit_check.hpp"

#include <array>
#include <cmath>

namespace fairlead {

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

JointSet outside_of(const Limits& limits, const MeasuredState& state) {
  JointSet outside = 0;
  for (std::size_t j = 0; j < limits.joints.size(); ++j)
    if (limits.joints[j].bounded && is_outside(limits.joints[j].bounds, state.positions[j]))
      outside |= only(j);
  return outside;
}

Evidence check_outside(const RowView& view) {
  for (const std::size_t j :
       JointsIn(view.outside & view.model.part_joints[view.now.action->part])) {
    if (decides_itself(view, j)) continue;
    const JointLimits& joint = view.limits.joints[j];
    const double measured = view.state.positions[j];
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
};

// A composite switch has no state to start from, and a binary gripper may switch at any time.
Evidence start_anywhere(const RowView&, const Setpoint*) { return {}; }
Evidence step_anywhere(std::uint32_t, const RowView&, const Setpoint&) { return {}; }

// By mode number. Nothing judges the rows of the three empty ones: they are refused by name.
constexpr std::array<ModeChecker, mode_count> checkers{{
    {joint_target_absolute, joint_target_start, joint_target_step},  // joint_position
    {joint_velocity_absolute, joint_velocity_start, joint_velocity_step},
    {},                                                              // joint_torque
    {},                                                              // joint_trajectory
    {pose_absolute, pose_start, pose_step},                          // cartesian_pose
    {norm_absolute, delta_start, norm_step},                         // cartesian_delta
    {norm_absolute, tool_twist_start, norm_step},                    // cartesian_twist
    {norm_absolute, body_twist_start, norm_step},                    // body_twist
    {},                                                              // foot_placement
    {binary_absolute, start_anywhere, step_anywhere},                // gripper_binary
    {scalar_absolute, gripper_start, scalar_step},                   // gripper_position
    {joint_target_absolute, joint_target_start, joint_target_step},  // dex_hand_joint
    {scalar_absolute, start_anywhere, scalar_step},                  // composite_mode
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
  const Setpoint last = command_of(action.part, before, view.limits);
  const bool goes_on = last.action != nullptr && is_alike(*last.action, action);
  const Setpoint acted = goes_on ? last : Setpoint{};
  Evidence evidence = check_change(view, before, last.action);
  if (evidence.ok())
    evidence = check_switch(view.limits, view.state, claim, before, action.part, view.now);
  const ModeChecker& checker = checker_of(view);
  if (evidence.ok()) evidence = checker.start(view, goes_on ? &acted : nullptr);
  if (!evidence.ok() || !goes_on) return evidence;
  // A row that acts but is not measured yet is only expected: the seam to it is another check.
  return checker.step(before.measured ? code::start : code::seam, view, acted);
}

Evidence check_acting(const RowView& view) {
  Evidence evidence = check_outside(view);
  if (evidence.ok() && is_joint_mode(view.mode())) evidence = joint_acting(view);
  return evidence;
}

Evidence check_step(const RowView& view) {
  const Evidence evidence = check_later_switch(view);
  return !evidence.ok() ? evidence : checker_of(view).step(code::step, view, view.previous);
}

Evidence RowLimitCheck::check(std::size_t row) const {
  const Limits& limits = model.limits;
  const bool is_first = row == first_row;
  const auto each_part = [&](const auto& rule) -> Evidence {
    for (const ActionPart& action : chunk.parts) {
      const Setpoint previous = is_first ? Setpoint{} : row_of(action, row - 1, limits);
      const RowView view{
          model,   claim.modes[action.part], state, row_of(action, row, limits), previous,
          outside, before.measured};
      const Evidence evidence = rule(view);
      if (!evidence.ok()) return at(evidence, static_cast<std::int64_t>(row), view.part().name);
    }
    return {};
  };
  Evidence evidence = each_part([](const RowView& view) { return check_absolute(view); });
  if (evidence.ok())
    evidence = each_part([&](const RowView& view) {
      return is_first ? check_start(view, claim, before) : check_step(view);
    });
  return evidence.ok() && is_first ? check_left_out_parts() : evidence;
}

Evidence RowLimitCheck::check_left_out_parts() const {
  const Limits& limits = model.limits;
  for (const std::size_t part : claim.parts) {
    if (command_of(part, {&chunk, first_row}, limits).action != nullptr) continue;
    const Evidence evidence = check_switch(limits, state, claim, before, part, Setpoint{});
    if (!evidence.ok())
      return at(evidence, static_cast<std::int64_t>(first_row), limits.parts[part].name);
  }
  return {};
}

}  // namespace fairlead
