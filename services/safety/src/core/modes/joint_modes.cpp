// Modes that command joints one by one, those that `active` names; the other numbers of a row are
// padding, never setpoints.

#include <cmath>

#include "core/modes/commanded_motion.hpp"
#include "core/modes/row_limit_check.hpp"
#include "core/modes/row_view.hpp"
#include "fairlead_safety/mode_blocks.hpp"

namespace fairlead {
namespace {

const JointModeLimits& block_of(const RowView& view) {
  return *joint_block(view.modes, view.mode());
}

// Of what the mode tells a joint.
std::string_view told_unit(const RowView& view, std::size_t j) {
  const JointKind kind = view.limits.joints[j].kind;
  return view.mode() == static_cast<std::uint8_t>(Mode::joint_velocity) ? velocity_unit(kind)
                                                                        : position_unit(kind);
}

// G011: the measurement is outside; the target must lie strictly nearer than what it follows.
Evidence reduces(const JointLimits& joint, double target, double previous) {
  const double now = std::abs(excess(joint.bounds, target));
  const double then = std::abs(excess(joint.bounds, previous));
  if (now < then || now == 0.0) return {};
  return above(code::state, joint.name.view(), now, then, position_unit(joint.kind),
               "a way back towards its bounds");
}

// G011: the measurement is outside by `out`, of either sign; the velocity must point the other way.
Evidence leads_back(const JointLimits& joint, double velocity, double out) {
  constexpr std::string_view rule = "a way back towards its bounds";
  const bool too_low = std::signbit(out);
  if (too_low ? velocity > 0.0 : velocity < 0.0) return {};
  const std::string_view unit = velocity_unit(joint.kind);
  return too_low ? below(code::state, joint.name.view(), velocity, 0.0, unit, rule)
                 : above(code::state, joint.name.view(), velocity, 0.0, unit, rule);
}

// G011: the target leads back, where the joint is outside its bounds.
Evidence target_leads_back(const RowView& view, std::size_t j) {
  const JointLimits& joint = view.limits.joints[j];
  const double measured = view.state.positions[j];
  if (!joint.bounded || !is_outside(joint.bounds, measured)) return {};
  const bool follows = view.previous.action != nullptr;
  return reduces(joint, view.now[j], follows ? view.previous[j] : measured);
}

// G011: the velocity points towards the bounds, where the joint is outside them.
Evidence velocity_leads_back(const RowView& view, std::size_t j) {
  const JointLimits& joint = view.limits.joints[j];
  const double measured = view.state.positions[j];
  if (!joint.bounded || !is_outside(joint.bounds, measured)) return {};
  return leads_back(joint, view.now[j], excess(joint.bounds, measured));
}

// The first fault that a rule finds among the joints that the row commands.
Evidence each_active(const RowView& view, Evidence (*rule)(const RowView&, std::size_t)) {
  for (const std::uint8_t j : view.now.action->active) {
    const Evidence evidence = rule(view, j);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

Evidence in_joint_range(const RowView& view, std::size_t j) {
  const JointLimits& joint = view.limits.joints[j];
  const JointRange range = joint_range(joint, block_of(view), view.mode());
  return in_range(joint.name.view(), view.now[j], range.lower, range.upper, told_unit(view, j),
                  joint.source);
}

}  // namespace

Evidence joint_target_absolute(const RowView& view) {
  for (const std::uint8_t j : view.now.action->active) {
    const JointLimits& joint = view.limits.joints[j];
    if (!joint.bounded) continue;  // continuous: no bound by declaration
    const Evidence evidence = is_outside(joint.bounds, view.state.positions[j])
                                  ? target_leads_back(view, j)
                                  : in_joint_range(view, j);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

Evidence joint_target_acting(const RowView& view) { return each_active(view, target_leads_back); }

// Targets start where the robot is measured to be, also while rows act. The joint's tolerance is
// added because a measurement may lie that far outside a range that the target keeps.
Evidence joint_target_start(const RowView& view, const Setpoint*) {
  const JointModeLimits& mode = block_of(view);
  for (const std::uint8_t j : view.now.action->active) {
    const JointLimits& joint = view.limits.joints[j];
    const double slack = joint.bounded ? joint.bounds.tolerance : 0.0;
    const Evidence evidence =
        at_most(code::start, joint.name.view(), view.now[j] - view.state.positions[j],
                mode.step_limit[j] + slack, told_unit(view, j), mode.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// A joint that the row before told where to be goes on to there: left out, it would be told nothing
// that a check knows of. After a held tick it may be.
Evidence joint_target_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  const bool same_joints = before.action == view.now.action;
  for (const std::uint8_t j : before.action->active)
    if (!same_joints && !view.now.commands(j))
      return broken_rule(code, view.limits.joints[j].name.view(),
                         "its target again, or a held tick");
  return joint_step(code, view, before);
}

// Towards the bounds where the joint is outside them.
Evidence joint_velocity_absolute(const RowView& view) {
  for (const std::uint8_t j : view.now.action->active) {
    Evidence evidence = in_joint_range(view, j);
    if (evidence.ok()) evidence = velocity_leads_back(view, j);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

Evidence joint_velocity_acting(const RowView& view) {
  return each_active(view, velocity_leads_back);
}

// A joint that nothing commands yet starts from what is measured of it.
Evidence joint_velocity_start(const RowView& view, const Setpoint* acted) {
  const JointModeLimits& mode = block_of(view);
  for (const std::uint8_t j : view.now.action->active) {
    if (acted != nullptr && acted->commands(j)) continue;
    const double told = told_velocity(view.limits, view.now, j, view.state.positions);
    const Evidence evidence =
        at_most(code::start, view.limits.joints[j].name.view(), told - view.state.velocities[j],
                mode.step_limit[j], told_unit(view, j), mode.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// A joint that the row before commanded and that this one leaves out is told 0.
Evidence joint_velocity_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  const JointModeLimits& mode = block_of(view);
  for (const std::uint8_t j : before.action->active) {
    if (view.now.commands(j)) continue;
    const Evidence left = at_most(code, view.limits.joints[j].name.view(), before[j],
                                  mode.step_limit[j], told_unit(view, j), mode.source);
    if (!left.ok()) return left;
  }
  return joint_step(code, view, before);
}

// Of the joints that both rows command.
Evidence joint_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  const JointModeLimits& mode = block_of(view);
  const bool same_joints = before.action == view.now.action;
  for (const std::uint8_t j : view.now.action->active) {
    if (!same_joints && !before.commands(j)) continue;
    const Evidence evidence =
        at_most(code, view.limits.joints[j].name.view(), view.now[j] - before[j],
                mode.step_limit[j], told_unit(view, j), mode.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

}  // namespace fairlead
