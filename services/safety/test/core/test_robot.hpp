// A small robot for the tests: two arm joints on a slide that nothing commands, a gripper, a
// three-axis base and a composite switch. Its numbers are round so that a test can say them again
// by hand.
//
// base_link -(torso: up)- column -(arm_1 about z, 0.5 up)- upper -(arm_2 about y, 0.4 ahead)- lower
// -(0.3 ahead)- tool: at rest the tool is at (0.7, 0, 0.5) with the base's axes.
#pragma once

#include "core/chunk/judge_chunk.hpp"
#include "core/chunk/judgement.hpp"
#include "fairlead_safety/limits.hpp"
#include "wide_limits.hpp"

namespace fairlead::test {

// Commanded joints in wire order, then the passive one.
inline constexpr std::size_t base_x = 0, base_y = 1, base_yaw = 2, arm_1 = 3, arm_2 = 4,
                             gripper_joint = 5, torso = 6;
inline constexpr std::size_t joint_count = 6;
inline constexpr std::size_t measured_count = 7;

// Parts in robot order.
inline constexpr std::uint8_t arm = 0, gripper = 1, base = 2, composite = 3;

inline constexpr std::uint64_t period_ns = 50'000'000;

inline Hash hash_of(std::uint8_t fill) {
  Hash hash;
  hash.fill(fill);
  return hash;
}

inline JointLimits joint(const char* name, std::size_t part, JointKind kind, bool bounded) {
  JointLimits limits;
  limits.name = name;
  limits.part = part;
  limits.kind = kind;
  limits.bounded = bounded;
  if (bounded) limits.bounds = {-2.0, 2.0, 0.1};
  limits.velocity_limit = 1.5;
  limits.effort_limit = 80.0;
  limits.jump_limit = 0.5;
  limits.standstill_velocity = 0.05;
  widen(limits);
  limits.source = "test joint";
  return limits;
}

inline JointModeLimits joint_mode(std::initializer_list<std::size_t> joints, double step) {
  JointModeLimits mode;
  mode.supported = true;
  for (const std::size_t j : joints) {
    mode.step_limit[j] = step;
    mode.tracking[j] = vast;
  }
  mode.gain = hardly_moves;
  mode.source = "test joint mode";
  return mode;
}

inline CartesianLimits cartesian_mode(double linear, double angular,
                                      std::initializer_list<std::size_t> axes) {
  CartesianLimits mode;
  mode.supported = true;
  (void)mode.frames.push_back("base_link");
  mode.linear_limit = linear;
  mode.angular_limit = angular;
  mode.linear_step_limit = 1.5 * linear;
  mode.angular_step_limit = 1.5 * angular;
  for (const std::size_t axis : axes) mode.free_axes[axis] = true;
  mode.gain = hardly_moves;
  mode.linear_tracking = vast;
  mode.angular_tracking = vast;
  mode.source = "test cartesian mode";
  return mode;
}

inline ScalarLimits scalar_mode(double lower, double upper, double step) {
  ScalarLimits mode;
  mode.supported = true;
  mode.lower = lower;
  mode.upper = upper;
  mode.step_limit = step;
  mode.slip_limit = vast;
  mode.switches_anywhere = true;
  mode.source = "test scalar mode";
  return mode;
}

inline PoseLimits pose_mode(double reach, double linear_step, double angular_step) {
  PoseLimits mode;
  mode.supported = true;
  (void)mode.frames.push_back("base_link");
  mode.lower.fill(-reach);
  mode.upper.fill(reach);
  mode.linear_step_limit = linear_step;
  mode.angular_step_limit = angular_step;
  mode.linear_tracking = vast;
  mode.angular_tracking = vast;
  mode.source = "test pose mode";
  return mode;
}

inline BinaryLimits binary_mode() { return {true, "test binary mode"}; }

inline Link link(const char* name, std::size_t parent, LinkMotion motion, std::size_t joint,
                 std::array<double, 3> axis, std::array<double, 3> translation) {
  return {name, parent, motion, joint, axis, translation, {0.0, 0.0, 0.0, 1.0}};
}

inline Kinematics tree_of(std::initializer_list<Link> links) {
  Kinematics tree;
  for (const Link& item : links) (void)tree.links.push_back(item);
  return tree;
}

inline PartLimits part(const char* name, std::initializer_list<std::size_t> joints) {
  PartLimits limits;
  limits.name = name;
  for (const std::size_t j : joints) (void)limits.joints.push_back(j);
  limits.source = "test part";
  return limits;
}

inline ProtocolLimits protocol() {
  ProtocolLimits limits;
  limits.horizon_max = 64;
  limits.age_max_ticks = 10;
  limits.chunk_rate_max_hz = 20.0;
  limits.seq_jump_max = 1000;
  limits.state_timeout_ms = 250;
  limits.heartbeat_timeout_realtime_ms = 300;
  limits.heartbeat_timeout_lockstep_ms = 2000;
  limits.lease_interval_ms = 25;
  limits.idle_disarm_s = 30;
  limits.stops_to_latch = 3;
  limits.stop_window_s = 60;
  limits.bad_frames_limit = 5;
  limits.bad_frames_window_ticks = 20;
  widen(limits);
  return limits;
}

inline void add_joints(Limits& limits) {
  const auto add = [&limits](JointLimits item) { (void)limits.joints.push_back(item); };
  add(joint("base_x", base, JointKind::prismatic, false));
  add(joint("base_y", base, JointKind::prismatic, false));
  add(joint("base_yaw", base, JointKind::continuous, false));
  add(joint("arm_1", arm, JointKind::revolute, true));
  add(joint("arm_2", arm, JointKind::revolute, true));
  JointLimits fingers = joint("gripper_joint", gripper, JointKind::prismatic, true);
  fingers.bounds = {0.0, 0.08, 0.01};
  fingers.velocity_limit = fingers.acceleration_limit = unset;
  add(fingers);
  PassiveLimits slide;
  slide.name = "torso";
  slide.bounds = {-0.1, 0.4, 0.01};
  slide.jump_limit = 0.02;
  slide.standstill_velocity = 0.01;
  slide.source = "test passive joint";
  (void)limits.passive_joints.push_back(slide);
}

inline Kinematics test_tree() {
  constexpr auto turn = LinkMotion::turn;
  Link root;
  root.name = "base_link";
  return tree_of({root, link("column", 0, LinkMotion::slide, torso, {0, 0, 1}, {0, 0, 0}),
                  link("upper", 1, turn, arm_1, {0, 0, 1}, {0, 0, 0.5}),
                  link("lower", 2, turn, arm_2, {0, 1, 0}, {0.4, 0, 0}),
                  link("tool", 3, LinkMotion::fixed, max_measured, {1, 0, 0}, {0.3, 0, 0})});
}

inline Limits test_limits() {
  Limits limits;
  limits.robot = "test_robot";
  limits.profile = "sim";
  limits.robot_hash = hash_of(7);
  limits.config_hash = hash_of(9);
  limits.period_ns = period_ns;
  limits.lockstep_allowed = true;
  add_joints(limits);
  limits.kinematics = test_tree();
  PartLimits arm_part = part("arm", {arm_1, arm_2});
  arm_part.tool = 4;
  arm_part.modes.joint_position = joint_mode({arm_1, arm_2}, 0.25);
  arm_part.modes.joint_velocity = joint_mode({arm_1, arm_2}, 0.5);
  arm_part.modes.cartesian_pose = pose_mode(1.0, 0.05, 0.25);
  arm_part.modes.cartesian_delta = cartesian_mode(0.1, 0.5, {0, 1, 2, 3, 4, 5});
  arm_part.modes.cartesian_twist = cartesian_mode(0.5, 1.0, {0, 1, 2, 3, 4, 5});
  PartLimits gripper_part = part("gripper", {gripper_joint});
  gripper_part.tool = 4;
  gripper_part.modes.gripper_position = scalar_mode(0.0, 0.08, 0.05);
  gripper_part.modes.gripper_binary = binary_mode();
  PartLimits base_part = part("base", {base_x, base_y, base_yaw});
  base_part.modes.joint_velocity = joint_mode({base_x, base_y, base_yaw}, 2.0);
  base_part.modes.body_twist = cartesian_mode(1.0, 1.5, {0, 1, 5});
  PartLimits composite_part = part("composite", {});
  composite_part.modes.composite_mode = scalar_mode(-1.0, 1.0, 1.5);
  for (PartLimits item : {arm_part, gripper_part, base_part, composite_part}) {
    widen(item);
    (void)limits.parts.push_back(item);
  }
  limits.collision = wide_shape(0, 3);
  limits.workspace = wide_workspace();
  limits.base = wide_base(base_x, base_y, base_yaw);
  limits.protocol = protocol();
  return limits;
}

/// All parts, with the robot's own limits.
inline ClaimLimits whole_robot(const Limits& limits) {
  ClaimLimits claim;
  for (std::size_t i = 0; i < limits.parts.size(); ++i) {
    (void)claim.parts.push_back(i);
    claim.modes[i] = limits.parts[i].modes;
  }
  claim.horizon_max = 64;
  claim.age_max_ticks = 5;
  return claim;
}

/// Judging in a room that all tests share; all rows are certified.
inline PathRoom& shared_room() {
  static PathRoom room;
  return room;
}

inline Judgement judge_path(const RobotModel& model, const ClaimLimits& claim,
                            const MeasuredState& state, const ActionChunk& chunk,
                            std::size_t first_row, std::size_t end_row, const RowBefore& before,
                            Companions companions) {
  return judge_path(shared_room(), model, claim, state, chunk, JudgedRows::all(first_row, end_row),
                    before, companions);
}

inline Judgement judge_rows(const RobotModel& model, const ClaimLimits& claim,
                            const MeasuredState& state, const ActionChunk& chunk,
                            std::size_t first_row, const RowBefore& before, Companions companions) {
  return judge_rows(shared_room(), model, claim, state, chunk,
                    JudgedRows::all(first_row, chunk.horizon), before, companions);
}

/// Judging with limits that a test has just changed; nobody else moves.
inline Judgement judge_rows(const Limits& limits, const ClaimLimits& claim,
                            const MeasuredState& state, const ActionChunk& chunk,
                            std::size_t first_row, const RowBefore& before) {
  return judge_rows(RobotModel(limits), claim, state, chunk, first_row, before, {});
}

/// Everything at zero except the gripper, which is half open, standing still.
inline MeasuredState state_at_rest() {
  MeasuredState state;
  state.tick = 100;
  state.count = measured_count;
  state.positions[gripper_joint] = 0.04;
  (void)state.acted.resize(4);
  return state;
}

}  // namespace fairlead::test
