// Modes that command joints one by one, those that `active` names; the other numbers of a row are
// padding, never setpoints. And modes of one number: a gripper's opening or switch, and the
// composite switch.

#include <algorithm>
#include <cmath>

#include "core/modes/commanded_motion.hpp"
#include "core/modes/row_limit_check.hpp"

namespace fairlead {
namespace {

constexpr std::string_view back_rule = "a way back towards its bounds";

const JointModeLimits& block_of(const RowView& view) {
  return *joint_block(view.modes, view.mode());
}

// Of what the mode commands of a joint.
std::string_view unit_of(const RowView& view, std::size_t j) {
  const JointKind kind = view.limits.joints[j].kind;
  return view.mode() == velocity_mode ? velocity_unit(kind) : position_unit(kind);
}

bool is_outside(const RowView& view, std::size_t j) { return (view.outside & only(j)) != 0; }

// The first fault that a rule finds among the joints that the row commands.
template <class Rule>
Evidence each_active(const RowView& view, const Rule& rule) {
  for (const std::uint8_t j : view.now.action->active)
    if (const Evidence evidence = rule(view, j); !evidence.ok()) return evidence;
  return {};
}

// A change of one joint's number, of either sign.
Evidence within_step(std::uint32_t code, const RowView& view, std::size_t j, double change,
                     double slack = 0.0) {
  const JointModeLimits& mode = block_of(view);
  return at_most(code, view.limits.joints[j].name.view(), change, mode.step_limit[j] + slack,
                 unit_of(view, j), mode.source);
}

// G011: where the joint is measured outside, its target lies strictly nearer to its bounds than
// what it follows.
Evidence target_leads_back(const RowView& view, std::size_t j) {
  if (!is_outside(view, j)) return {};
  const JointLimits& joint = view.limits.joints[j];
  const double measured = view.state.positions[j];
  const bool follows = view.previous.action != nullptr;
  const double now = std::abs(excess(joint.bounds, view.now[j]));
  const double then = std::abs(excess(joint.bounds, follows ? view.previous[j] : measured));
  if (now < then || now == 0.0) return {};
  return above(code::state, joint.name.view(), now, then, position_unit(joint.kind), back_rule);
}

// G011: where the joint is measured outside, its velocity points towards its bounds.
Evidence velocity_leads_back(const RowView& view, std::size_t j) {
  if (!is_outside(view, j)) return {};
  const JointLimits& joint = view.limits.joints[j];
  const double velocity = view.now[j];
  const bool too_low = std::signbit(excess(joint.bounds, view.state.positions[j]));
  if (too_low ? velocity > 0.0 : velocity < 0.0) return {};
  return (too_low ? below : above)(code::state, joint.name.view(), velocity, 0.0,
                                   velocity_unit(joint.kind), back_rule);
}

}  // namespace

// Inside the bounds, if it has any: a continuous joint has none by declaration. (Here and in
// joint_step evidence is made only where there is a fault: both run for each joint of each row.)
Evidence joint_target_absolute(const RowView& view) {
  for (const std::uint8_t j : view.now.action->active) {
    const JointLimits& joint = view.limits.joints[j];
    if (!joint.bounded) continue;
    const auto& [lower, upper, tolerance] = joint.bounds;
    const double target = view.now[j];
    const bool outside = is_outside(view, j);
    if (!outside && target >= lower && target <= upper) continue;
    const Evidence evidence =
        outside ? target_leads_back(view, j)
                : in_range(joint.name.view(), target, lower, upper, unit_of(view, j), joint.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// Within the joint's own limit in both directions, and within the claim's where that is tighter;
// and towards the bounds where the joint is outside them.
Evidence joint_velocity_absolute(const RowView& view) {
  return each_active(view, [](const RowView& row, std::size_t j) {
    const JointLimits& joint = row.limits.joints[j];
    // The joint's own where the claim has none, NaN.
    const double limit = std::min(joint.velocity_limit, block_of(row).claimed_limit);
    const Evidence evidence =
        in_range(joint.name.view(), row.now[j], -limit, limit, unit_of(row, j), joint.source);
    return evidence.ok() ? velocity_leads_back(row, j) : evidence;
  });
}

Evidence joint_acting(const RowView& view) {
  return each_active(view, view.mode() == velocity_mode ? velocity_leads_back : target_leads_back);
}

// Targets start where the robot is measured to be, also while rows act. The joint's tolerance is
// added because a measurement may lie that far outside a range that the target keeps.
Evidence joint_target_start(const RowView& view, const Setpoint* acted) {
  return each_active(view, [acted](const RowView& row, std::size_t j) {
    const JointLimits& joint = row.limits.joints[j];
    const bool goes_on = acted != nullptr && acted->commands(j);
    return within_step(code::start, row, j, row.now[j] - row.state.positions[j],
                       unmeasured_step(row, goes_on, block_of(row).step_limit[j]) +
                           (joint.bounded ? joint.bounds.tolerance : 0.0));
  });
}

// A joint that nothing commands yet starts from what is measured of it.
Evidence joint_velocity_start(const RowView& view, const Setpoint* acted) {
  return each_active(view, [acted](const RowView& row, std::size_t j) {
    if (acted != nullptr && acted->commands(j)) return Evidence{};
    const double commanded = commanded_velocity(row.limits, row.now, j, row.state.positions);
    return within_step(code::start, row, j, commanded - row.state.velocities[j]);
  });
}

namespace {

// Of the joints that both rows command.
Evidence joint_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  const JointModeLimits& mode = block_of(view);
  const bool same_joints = before.action == view.now.action;
  for (const std::uint8_t j : view.now.action->active) {
    if (!same_joints && !before.commands(j)) continue;
    const double change = view.now[j] - before[j];
    if (!(std::abs(change) <= mode.step_limit[j])) return within_step(code, view, j, change);
  }
  return {};
}

}  // namespace

// A joint that the row before commanded to a target goes on to there: left out, nothing that a
// check knows of would command it. After a held tick it may be.
Evidence joint_target_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  if (before.action != view.now.action)
    for (const std::uint8_t j : before.action->active)
      if (!view.now.commands(j))
        return broken_rule(code, view.limits.joints[j].name.view(),
                           "its target again, or a held tick");
  return joint_step(code, view, before);
}

// A joint that the row before commanded and that this one leaves out is commanded to 0.
Evidence joint_velocity_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  if (before.action != view.now.action)
    for (const std::uint8_t j : before.action->active) {
      if (view.now.commands(j)) continue;
      const Evidence left = within_step(code, view, j, before[j]);
      if (!left.ok()) return left;
    }
  return joint_step(code, view, before);
}

namespace {

const ScalarLimits& scalar_of(const RowView& view) {
  return *scalar_block(view.modes, view.mode());
}

bool is_opening(const RowView& view) {
  return view.mode() == static_cast<std::uint8_t>(Mode::gripper_position);
}

std::string_view axis_of(const RowView& view) { return is_opening(view) ? "opening" : "composite"; }

std::string_view unit_of(const RowView& view) {
  return is_opening(view) ? position_unit(view.limits.joints[view.part().joints[0]].kind) : "1";
}

}  // namespace

Evidence scalar_absolute(const RowView& view) {
  const ScalarLimits& mode = scalar_of(view);
  return in_range(axis_of(view), view.now[0], mode.lower, mode.upper, unit_of(view), mode.source);
}

Evidence binary_absolute(const RowView& view) {
  const double value = view.now[0];
  if (value == 0.0 || value == 1.0) return {};
  constexpr std::string_view rule = "exactly 0 (open) or 1 (closed)";
  // The nearer of the two is the limit; its margin is how far off the value is.
  Evidence evidence = above(code::absolute, "closed", value, value < 0.5 ? 0.0 : 1.0, "1", rule);
  evidence.margin = -std::abs(value - evidence.limit);
  return evidence;
}

// The opening starts where it is measured; the tolerance as for any joint target.
Evidence gripper_start(const RowView& view, const Setpoint* acted) {
  const ScalarLimits& mode = view.modes.gripper_position;
  const std::size_t j = view.part().joints[0];
  const double room = mode.step_limit + view.limits.joints[j].bounds.tolerance;
  return at_most(code::start, "opening", view.now[0] - view.state.positions[j],
                 room + unmeasured_step(view, acted != nullptr, mode.step_limit), unit_of(view),
                 mode.source);
}

Evidence scalar_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  const ScalarLimits& mode = scalar_of(view);
  return at_most(code, axis_of(view), view.now[0] - before[0], mode.step_limit, unit_of(view),
                 mode.source);
}

}  // namespace fairlead
