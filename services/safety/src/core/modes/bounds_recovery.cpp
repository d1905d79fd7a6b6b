#include "core/modes/bounds_recovery.hpp"

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
    if (std::signbit(excess(joint.bounds, measured)))
      return below(code::state, joint.name.view(), measured, joint.bounds.lower, rule);
    return above(code::state, joint.name.view(), measured, joint.bounds.upper, rule);
  }
  return {};
}

}  // namespace fairlead
