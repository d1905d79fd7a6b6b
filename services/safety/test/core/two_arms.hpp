// Two arms of one joint each, side by side, and a hand of two fingers on the right one.
//
// base_link -(left_1 about z, at y = 0.3)- left_upper -(0.5 ahead)- left_tool, and the same at
// y = -0.3 for the right; the fingers turn about the right tool's x.
#pragma once

#include "chunk_builder.hpp"

namespace fairlead::test::two_arms {

inline constexpr std::size_t left_1 = 0, right_1 = 1, finger_1 = 2, finger_2 = 3;
inline constexpr std::size_t joint_count = 4;
inline constexpr std::uint8_t left = 0, right = 1, hand = 2;

inline Kinematics tree() {
  constexpr auto turn = LinkMotion::turn;
  constexpr auto fixed = LinkMotion::fixed;
  Link root;
  root.name = "base_link";
  return tree_of({root, link("left_upper", 0, turn, left_1, {0, 0, 1}, {0, 0.3, 0}),
                  link("left_tool", 1, fixed, max_measured, {1, 0, 0}, {0.5, 0, 0}),
                  link("right_upper", 0, turn, right_1, {0, 0, 1}, {0, -0.3, 0}),
                  link("right_tool", 3, fixed, max_measured, {1, 0, 0}, {0.5, 0, 0}),
                  link("finger_one", 4, turn, finger_1, {1, 0, 0}, {0, 0.02, 0}),
                  link("finger_two", 4, turn, finger_2, {1, 0, 0}, {0, -0.02, 0})});
}

inline PartLimits arm_part(const char* name, std::size_t joint, std::size_t tool) {
  PartLimits limits = part(name, {joint});
  limits.tool = tool;
  limits.modes.joint_position = joint_mode({joint}, 0.25);
  limits.modes.cartesian_pose = pose_mode(1.0, 0.05, 0.25);
  limits.modes.cartesian_twist = cartesian_mode(0.5, 1.0, {0, 1, 2, 3, 4, 5});
  return limits;
}

inline Limits limits() {
  Limits limits;
  limits.robot = "two_arms";
  limits.profile = "sim";
  limits.robot_hash = hash_of(7);
  limits.config_hash = hash_of(9);
  limits.period_ns = period_ns;
  limits.lockstep_allowed = true;
  const auto add = [&limits](const char* name, std::size_t part) {
    (void)limits.joints.push_back(joint(name, part, JointKind::revolute, true));
  };
  add("left_1", left);
  add("right_1", right);
  add("finger_1", hand);
  add("finger_2", hand);
  limits.kinematics = tree();
  PartLimits hand_part = part("right_hand", {finger_1, finger_2});
  hand_part.tool = 4;
  hand_part.modes.dex_hand_joint = joint_mode({finger_1, finger_2}, 0.125);
  for (PartLimits item :
       {arm_part("left_arm", left_1, 2), arm_part("right_arm", right_1, 4), hand_part}) {
    widen(item);
    (void)limits.parts.push_back(item);
  }
  limits.collision = wide_shape(1, 3);
  limits.workspace = wide_workspace();
  limits.protocol = protocol();
  return limits;
}

inline MeasuredState at_rest() {
  MeasuredState state;
  state.tick = 100;
  state.count = joint_count;
  (void)state.acted.resize(3);
  return state;
}

/// Joint mode, one joint of four.
inline ChunkBuilder& command(ChunkBuilder& chunk, std::uint8_t part, Mode mode, std::uint8_t joint,
                             const Row& values) {
  Rows rows;
  for (const double value : values) {
    Row row(joint_count, 0.0);
    row[joint] = value;
    rows.push_back(row);
  }
  return chunk.add(part, mode, rows, {joint});
}

}  // namespace fairlead::test::two_arms
