// G021 and G022: how far a setpoint may be from what came before it.

#include <doctest/doctest.h>

#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("G021 a joint target starts within a step of the measured position") {
  const auto code = [](double target) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {target}).chunk)
        .evidence.code;
  };
  CHECK(code(0.35) == 0);  // step 0.25 + tolerance 0.1
  CHECK(code(just_above(0.35)) == 21);
  CHECK(code(just_below(-0.35)) == 21);
}

TEST_CASE("G021 a joint target starts within a step of what was executed last") {
  ChunkBuilder previous;
  previous.joint(arm, Mode::joint_position, arm_1, {-0.1});
  const auto code = [&previous](double target) {
    return code_after(previous, ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {target}));
  };
  CHECK(code(0.15) == 0);
  CHECK(code(0.15 + 1e-9) == 21);
}

TEST_CASE("G021 padding of the row before is no setpoint") {
  ChunkBuilder previous;
  previous.joint(arm, Mode::joint_position, arm_2, {0.1});
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = 1.0;
  Row row(joint_count, 0.0);
  row[arm_1] = 1.0;
  row[arm_2] = 0.1;
  ChunkBuilder both = ChunkBuilder().add(arm, Mode::joint_position, {row}, {arm_1, arm_2});
  CHECK(code_after(previous, both, state) == 0);
}

TEST_CASE("G021 a velocity starts from what was executed, after a hold from what is measured") {
  MeasuredState state = state_at_rest();
  state.velocities[arm_1] = 0.2;
  const auto after_hold = [&state](double value) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {value}).chunk, state)
        .evidence.code;
  };
  CHECK(after_hold(0.7) == 0);
  CHECK(after_hold(0.7 + 1e-9) == 21);
  CHECK(after_hold(-0.3 - 1e-9) == 21);
  ChunkBuilder previous;
  previous.joint(arm, Mode::joint_velocity, arm_1, {0.5});
  CHECK(code_after(previous, ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {1.0}),
                   state) == 0);
  CHECK(code_after(previous,
                   ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {just_above(1.0)}),
                   state) == 21);
}

TEST_CASE("G021 a delta or twist after a hold starts from zero") {
  static Limits limits = test_limits();
  ClaimLimits claim = whole_robot(limits);
  claim.modes[arm].cartesian_delta.linear_step_limit = 0.05;
  claim.modes[base].body_twist.angular_step_limit = 0.5;
  const auto code = [&claim](const ChunkBuilder& builder) {
    return judge_rows(limits, claim, state_at_rest(), builder.chunk, 0, {}).evidence.code;
  };
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 1, {0.05})) == 0);
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 1, {just_above(0.05)})) == 21);
  CHECK(code(ChunkBuilder().along(base, Mode::body_twist, 5, {0.5})) == 0);
  CHECK(code(ChunkBuilder().along(base, Mode::body_twist, 5, {just_above(0.5)})) == 21);
}

TEST_CASE("G021 gripper and composite start from what is known of them") {
  MeasuredState state = state_at_rest();
  state.positions[gripper_joint] = 0.0;
  const auto opening = [&state](double value) {
    return judge(ChunkBuilder().scalar(gripper, Mode::gripper_position, {value}).chunk, state)
        .evidence.code;
  };
  CHECK(opening(0.06) == 0);  // step 0.05 + tolerance 0.01
  CHECK(opening(0.06 + 1e-9) == 21);
  ChunkBuilder previous;
  previous.scalar(composite, Mode::composite_mode, {-1.0});
  CHECK(code_after(previous, ChunkBuilder().scalar(composite, Mode::composite_mode, {0.5})) == 0);
  CHECK(code_after(previous,
                   ChunkBuilder().scalar(composite, Mode::composite_mode, {0.5 + 1e-9})) == 21);
  ChunkBuilder closed;
  closed.scalar(gripper, Mode::gripper_position, {0.0});
  state.positions[gripper_joint] = 0.04;
  CHECK(code_after(closed, ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.05}), state) ==
        0);
  CHECK(code_after(closed,
                   ChunkBuilder().scalar(gripper, Mode::gripper_position, {just_above(0.05)}),
                   state) == 21);
}

TEST_CASE("G022 the jump from row to row, for every mode") {
  const auto code = [](const ChunkBuilder& builder) { return judge(builder.chunk).evidence.code; };
  CHECK(code(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, 0.25})) == 0);
  CHECK(code(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, just_above(0.25)})) ==
        22);
  CHECK(code(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.0, -0.5})) == 0);
  CHECK(code(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.0, just_below(-0.5)})) ==
        22);
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.1, 0.1, -0.05})) == 0);
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.1, 0.1, -0.06})) == 22);
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 4, {0.5, -0.25})) == 0);
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 4, {0.5, -0.26})) == 22);
  CHECK(code(ChunkBuilder().along(base, Mode::body_twist, 0, {1.0, -0.5})) == 0);
  CHECK(code(ChunkBuilder().along(base, Mode::body_twist, 0, {1.0, -0.51})) == 22);
  CHECK(code(ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.0, 0.05})) == 0);
  CHECK(code(ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.0, just_above(0.05)})) ==
        22);
  CHECK(code(ChunkBuilder().scalar(composite, Mode::composite_mode, {-1.0, 0.5})) == 0);
  CHECK(code(ChunkBuilder().scalar(composite, Mode::composite_mode, {-1.0, 1.0})) == 22);
}

TEST_CASE("a tighter limit never releases more") {
  static Limits limits = test_limits();
  const ClaimLimits wide = whole_robot(limits);
  ClaimLimits tight = wide;
  tight.modes[arm].cartesian_delta.linear_limit = 0.04;
  for (int i = 0; i < 200; ++i) {
    Row rows;
    for (int k = 0; k < 8; ++k) rows.push_back(0.1 * std::sin(0.37 * i + 0.9 * k));
    const ChunkBuilder builder = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, rows);
    const auto released = [&](const ClaimLimits& claim) {
      return judge_rows(limits, claim, state_at_rest(), builder.chunk, 0, {}).row_count;
    };
    CHECK(released(tight) <= released(wide));
  }
}

TEST_CASE("G021 a twist after none starts from the measured one, turned into base_link") {
  static Limits limits = test_limits();
  ClaimLimits claim = whole_robot(limits);
  claim.modes[base].body_twist.linear_step_limit = 0.3;
  MeasuredState state = state_at_rest();
  state.positions[base_yaw] = std::acos(-1.0) / 2.0;
  state.velocities[base_y] = 1.0;  // along odom's y: forwards, as the base is turned
  const auto code = [&](std::size_t axis, double speed) {
    const ChunkBuilder twist = ChunkBuilder().along(base, Mode::body_twist, axis, {speed});
    return judge_rows(limits, claim, state, twist.chunk, 0, {}).evidence.code;
  };
  CHECK(code(0, 0.71) == 0);
  CHECK(code(0, 0.69) == 21);
  CHECK(code(0, -0.3) == 21);
  CHECK(code(1, 0.9) == 21);
  limits.joints[base_y].kind = JointKind::revolute;  // not a base of two slides and a yaw
  CHECK(code(0, 0.8) == 21);
  state.velocities[base_y] = 0.0;
  CHECK(code(0, 0.8) == 0);
  limits = test_limits();
}

TEST_CASE(
    "G021 the measured twist of a base is that of its origin, which swings about the yaw axis") {
  static Limits limits = test_limits();
  limits.base.yaw_axis = {-0.4, 0.2};
  ClaimLimits claim = whole_robot(limits);
  claim.modes[base].body_twist.linear_step_limit = 0.1;
  MeasuredState state = state_at_rest();
  state.velocities[base_yaw] = 1.0;
  const auto swinging = [&](double x, double y) {
    const ChunkBuilder twist =
        ChunkBuilder().add(base, Mode::body_twist, {{x, y, 0, 0, 0, 1.0}}, {}, "base_link");
    return judge_rows(limits, claim, state, twist.chunk, 0, {}).evidence.code;
  };
  // The axis stays: the origin, 0.4 m ahead of it and 0.2 m to its right, swings.
  CHECK(swinging(0.0, 0.0) == 21);
  CHECK(swinging(0.2, 0.4) == 0);
  CHECK(swinging(0.2, 0.29) == 21);
  CHECK(swinging(0.31, 0.4) == 21);
  // The origin stays: turning in place goes on.
  state.velocities[base_x] = -0.2;
  state.velocities[base_y] = -0.4;
  CHECK(swinging(0.0, 0.0) == 0);
  // Without a declared axis it is the axis that is measured; where that leads nobody can tell.
  limits.base.present = false;
  CHECK(swinging(0.0, 0.0) == 21);
  CHECK(swinging(-0.2, -0.4) == 30);
  limits = test_limits();
}

TEST_CASE("G025 a part changes its mode at standstill only") {
  ChunkBuilder before;
  before.joint(base, Mode::joint_velocity, base_x, {0.5});
  const ChunkBuilder twist = ChunkBuilder().along(base, Mode::body_twist, 0, {0.5});
  MeasuredState state = state_at_rest();
  CHECK(code_after(before, twist, state) == 0);
  state.velocities[base_x] = 0.05;
  CHECK(code_after(before, twist, state) == 25);
}

TEST_CASE("G021 a joint that is left out of velocities counts as told 0") {
  const auto velocities = [](double first, double second) {
    Row row(joint_count, 0.0);
    row[arm_1] = first;
    row[arm_2] = second;
    return ChunkBuilder().add(arm, Mode::joint_velocity, {row}, {arm_1, arm_2});
  };
  const ChunkBuilder second = ChunkBuilder().joint(arm, Mode::joint_velocity, arm_2, {0.1});
  for (const double sign : {1.0, -1.0}) {
    ChunkBuilder slow = velocities(sign * 0.5, 0.1);  // step limit 0.5
    CHECK(code_after(slow, second) == 0);
    ChunkBuilder fast = velocities(sign * just_above(0.5), 0.1);
    CHECK(code_after(fast, second) == 21);
  }
}

TEST_CASE("G021 a joint that has a target is not left out before a held tick") {
  ChunkBuilder both =
      ChunkBuilder().add(arm, Mode::joint_position, {Row(joint_count, 0.0)}, {arm_1, arm_2});
  ChunkBuilder one = ChunkBuilder().joint(arm, Mode::joint_position, arm_2, {0.1});
  CHECK(code_after(both, one) == 21);
  CHECK(code_after(one, both) == 0);
  CHECK(code_after(one, one) == 0);
}
