// An arm whose six joints reach any pose: a turn about z at the base, three slides, and turns about
// y and x at the wrist. At rest the tool is at (0.7, 0, 0.5) with the base's axes; the slides move
// it by what they are told. All that is asked for happens, and each joint brakes at 1e18.
#pragma once

#include "boundary.hpp"
#include "chunk_builder.hpp"

namespace fairlead::test::free_arm {

inline constexpr std::uint8_t turn_z = 0, slide_x = 1, slide_y = 2, slide_z = 3, turn_y = 4,
                              turn_x = 5;
inline constexpr std::size_t column_link = 1, tool_link = 6;

inline Kinematics tree() {
  constexpr auto turn = LinkMotion::turn;
  constexpr auto slide = LinkMotion::slide;
  Link root;
  root.name = "base_link";
  return tree_of({root, link("column", 0, turn, turn_z, {0, 0, 1}, {0, 0, 0}),
                  link("ahead", 1, slide, slide_x, {1, 0, 0}, {0.7, 0, 0.5}),
                  link("aside", 2, slide, slide_y, {0, 1, 0}, {0, 0, 0}),
                  link("up", 3, slide, slide_z, {0, 0, 1}, {0, 0, 0}),
                  link("wrist", 4, turn, turn_y, {0, 1, 0}, {0, 0, 0}),
                  link("tool", 5, turn, turn_x, {1, 0, 0}, {0, 0, 0})});
}

inline Limits limits() {
  Limits limits;
  limits.robot = "free_arm";
  limits.profile = "sim";
  limits.robot_hash = hash_of(7);
  limits.config_hash = hash_of(9);
  limits.period_ns = period_ns;
  limits.lockstep_allowed = true;
  for (const char* name : {"turn_z", "slide_x", "slide_y", "slide_z", "turn_y", "turn_x"}) {
    const bool slides = name[0] == 's';
    (void)limits.joints.push_back(
        joint(name, arm, slides ? JointKind::prismatic : JointKind::revolute, true));
  }
  limits.kinematics = tree();
  PartLimits part = test::part("arm", {0, 1, 2, 3, 4, 5});
  part.tool = tool_link;
  part.modes.joint_position = joint_mode({0, 1, 2, 3, 4, 5}, 0.25);
  part.modes.joint_velocity = joint_mode({0, 1, 2, 3, 4, 5}, 3.0);
  part.modes.cartesian_pose = pose_mode(1.0, 0.05, 0.25);
  part.modes.cartesian_delta = cartesian_mode(0.1, 0.5, {0, 1, 2, 3, 4, 5});
  part.modes.cartesian_twist = cartesian_mode(0.5, 1.0, {0, 1, 2, 3, 4, 5});
  for (Gain* gain : {&part.modes.joint_velocity.gain, &part.modes.cartesian_delta.gain,
                     &part.modes.cartesian_twist.gain})
    *gain = {1.0, 1.0};
  widen(part);
  (void)limits.parts.push_back(part);
  limits.collision = wide_shape(0, tool_link);
  limits.workspace = wide_workspace();
  limits.protocol = protocol();
  return limits;
}

/// A flag on the column besides, a tool of its own at (2, 0, 0).
inline Limits with_flag() {
  Limits limits = free_arm::limits();
  (void)limits.kinematics.links.push_back(
      link("flag", column_link, LinkMotion::fixed, max_measured, {1, 0, 0}, {2, 0, 0}));
  PartLimits part = test::part("flag", {});
  part.tool = limits.kinematics.links.size() - 1;
  (void)limits.parts.push_back(part);
  return limits;
}

inline MeasuredState at_rest() {
  MeasuredState state;
  state.tick = 100;
  state.count = 6;
  (void)state.acted.resize(1);
  return state;
}

inline Judgement judge(const Limits& limits, const ActionChunk& chunk,
                       const MeasuredState& state = at_rest(), const RowBefore& before = {},
                       std::size_t first_row = 0) {
  return judge_rows(limits, whole_robot(limits), state, chunk, first_row, before);
}

/// One joint in a joint mode, row by row.
inline ChunkBuilder one_joint(Mode mode, std::uint8_t joint, const Row& values) {
  return ChunkBuilder().joint(arm, mode, joint, values);
}

}  // namespace fairlead::test::free_arm
