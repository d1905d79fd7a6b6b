// What a part's command is to the prediction: what it moves, and which share of it happens.
#pragma once

#include "core/kinematics/robot_model.hpp"
#include "core/modes/commanded_motion.hpp"
#include "fairlead_safety/mode_blocks.hpp"

namespace fairlead {

inline constexpr auto velocity_mode = static_cast<std::uint8_t>(Mode::joint_velocity);

inline bool is_pose(const ActionPart& action) {
  return action.mode == static_cast<std::uint8_t>(Mode::cartesian_pose);
}

inline bool moves_tool(const ActionPart& action) {
  switch (static_cast<Mode>(action.mode)) {
    case Mode::cartesian_pose:
    case Mode::cartesian_delta:
    case Mode::cartesian_twist:
      return true;
    default:
      return false;
  }
}

// The tracking model of a mode, nullptr where all of a row happens.
inline const Gain* gain_block(const ModeLimits& modes, std::uint8_t mode) {
  if (mode == velocity_mode) return &modes.joint_velocity.gain;
  const CartesianLimits* norms = norm_block(modes, mode);
  return norms == nullptr ? nullptr : &norms->gain;
}

inline bool is_gripper(std::uint8_t mode) {
  return mode == static_cast<std::uint8_t>(Mode::gripper_binary) ||
         mode == static_cast<std::uint8_t>(Mode::gripper_position);
}

// Joints that a command moves, as far as it is predicted.
inline JointSet moved_by(const PathPlan& plan, const ActionPart& action) {
  if (is_gripper(action.mode)) return 0;
  if (!is_joint_mode(action.mode)) return plan.part_joints[action.part];
  JointSet joints = 0;
  for (const std::uint8_t j : action.active) joints |= only(j);
  const BaseLimits& base = plan.limits.base;
  if (!base.present || !base.against_yaw || action.mode != velocity_mode) return joints;
  const JointSet slides = only(base.joints[0]) | only(base.joints[1]);
  return (joints & slides) != 0 ? joints | slides : joints;  // what turns moves both
}

}  // namespace fairlead
