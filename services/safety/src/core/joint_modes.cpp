// Modes that command joints one by one, those that `active` names; the other numbers of a row are
// padding, never setpoints.

#include <algorithm>
#include <cmath>

#include "fairlead_safety/mode_blocks.hpp"
#include "mode_checkers.hpp"
#include "outside_bounds.hpp"

namespace fairlead {
namespace {

const JointModeLimits& block_of(const RowView& view) {
  return *joint_block(view.modes, view.mode());
}

// G011: the measurement is outside; the target must lie strictly nearer than what it follows.
Evidence reduces(const JointLimits& joint, double target, double previous) {
  const double now = std::abs(excess(joint.bounds, target));
  const double then = std::abs(excess(joint.bounds, previous));
  if (now < then || now == 0.0) return {};
  return above(code::state, joint.name.view(), now, then, "outside its bounds: only towards them");
}

// G011: the measurement is outside by `out`, of either sign; the velocity must point the other way.
Evidence leads_back(const JointLimits& joint, double velocity, double out) {
  constexpr std::string_view rule = "outside its bounds: only towards them";
  if (out < 0.0 && !(velocity > 0.0))
    return below(code::state, joint.name.view(), velocity, 0.0, rule);
  if (out > 0.0 && !(velocity < 0.0))
    return above(code::state, joint.name.view(), velocity, 0.0, rule);
  return {};
}

// Within the joint's own limit in both directions, and the claim's where it has a tighter one.
Evidence within_own_limit(const RowView& view, std::size_t j, double own) {
  const double claimed = block_of(view).claimed_limit;
  const double limit = claimed > 0.0 ? std::min(claimed, own) : own;
  const JointLimits& joint = view.limits.joints[j];
  return in_range(joint.name.view(), view.now[j], -limit, limit, joint.source);
}

// G021: a joint that nothing commands yet starts from what is measured of it.
Evidence start_from(const RowView& view, const Setpoint* acted,
                    const std::array<double, max_measured>& measured) {
  const JointModeLimits& mode = block_of(view);
  for (const std::uint8_t j : view.now.action->active) {
    if (acted != nullptr && acted->commands(j)) continue;
    const Evidence evidence = at_most(code::start, view.limits.joints[j].name.view(),
                                      view.now[j] - measured[j], mode.step_limit[j], mode.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

}  // namespace

Evidence joint_target_absolute(const RowView& view) {
  for (const std::uint8_t j : view.now.action->active) {
    const JointLimits& joint = view.limits.joints[j];
    if (!joint.bounded) continue;  // continuous: no bound by declaration
    const double target = view.now[j];
    const double measured = view.state.positions[j];
    const double previous = view.previous.action != nullptr ? view.previous[j] : measured;
    const Evidence evidence = is_outside(joint.bounds, measured)
                                  ? reduces(joint, target, previous)
                                  : in_range(joint.name.view(), target, joint.bounds.lower,
                                             joint.bounds.upper, joint.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// Targets start where the robot is measured to be, also while rows act. The joint's tolerance is
// added because a measurement may lie that far outside a range that the target keeps.
Evidence joint_target_start(const RowView& view, const Setpoint*) {
  const JointModeLimits& mode = block_of(view);
  for (const std::uint8_t j : view.now.action->active) {
    const JointLimits& joint = view.limits.joints[j];
    const double slack = joint.bounded ? joint.bounds.tolerance : 0.0;
    const Evidence evidence =
        at_most(code::start, joint.name.view(), view.now[j] - view.state.positions[j],
                mode.step_limit[j] + slack, mode.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// Towards the bounds where the joint is outside them.
Evidence joint_velocity_absolute(const RowView& view) {
  for (const std::uint8_t j : view.now.action->active) {
    const JointLimits& joint = view.limits.joints[j];
    Evidence evidence = within_own_limit(view, j, joint.velocity_limit);
    const double measured = view.state.positions[j];
    if (evidence.ok() && joint.bounded && is_outside(joint.bounds, measured))
      evidence = leads_back(joint, view.now[j], excess(joint.bounds, measured));
    if (!evidence.ok()) return evidence;
  }
  return {};
}

Evidence joint_velocity_start(const RowView& view, const Setpoint* acted) {
  return start_from(view, acted, view.state.velocities);
}

Evidence joint_torque_absolute(const RowView& view) {
  for (const std::uint8_t j : view.now.action->active) {
    const Evidence evidence = within_own_limit(view, j, view.limits.joints[j].effort_limit);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// A part that holds is held by the torque that is measured, not by none.
Evidence joint_torque_start(const RowView& view, const Setpoint* acted) {
  return start_from(view, acted, view.state.efforts);
}

// Of the joints that both rows command.
Evidence joint_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  const JointModeLimits& mode = block_of(view);
  for (const std::uint8_t j : view.now.action->active) {
    if (!before.commands(j)) continue;
    const Evidence evidence = at_most(code, view.limits.joints[j].name.view(),
                                      view.now[j] - before[j], mode.step_limit[j], mode.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

}  // namespace fairlead
