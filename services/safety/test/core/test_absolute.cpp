// G020, and the part of G011 that judges rows: limits of a row by itself.

#include <doctest/doctest.h>

#include "gate_rig.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("G020 joint position: inside the joint's bounds, ends included") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = 1.9;
  const auto code = [&state](double target) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {target}).chunk, state)
        .evidence.code;
  };
  CHECK(code(just_below(2.0)) == 0);
  CHECK(code(2.0) == 0);
  CHECK(code(just_above(2.0)) == 20);
  state.positions[arm_1] = -1.9;
  CHECK(code(-2.0) == 0);
  CHECK(code(just_below(-2.0)) == 20);
  for (const double bad : {not_a_number, infinite, -infinite}) CHECK(code(bad) == 20);
}

TEST_CASE("G020 joint velocity: up to the joint's limit in both directions") {
  ChunkBuilder previous;
  previous.joint(base, Mode::joint_velocity, base_x, {0.0});
  const auto code = [&previous](double velocity) {
    return code_after(previous,
                      ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {velocity}));
  };
  for (const double fine : {1.5, -1.5, just_below(1.5), 0.0}) CHECK(code(fine) == 0);
  for (const double bad : {just_above(1.5), just_below(-1.5), not_a_number, infinite, -infinite})
    CHECK(code(bad) == 20);
}

TEST_CASE("G020 cartesian delta: the norm counts, not the axes") {
  const auto code = [](const Row& row) {
    return judge(ChunkBuilder().add(arm, Mode::cartesian_delta, {row}, {}, "base_link").chunk)
        .evidence.code;
  };
  CHECK(code({0.1, 0, 0, 0, 0, 0}) == 0);
  CHECK(code({just_above(0.1), 0, 0, 0, 0, 0}) == 20);
  CHECK(code({0, 0, 0, 0.5, 0, 0}) == 0);
  CHECK(code({0, 0, 0, 0, 0, just_above(0.5)}) == 20);
  CHECK(code({0.06, 0.08, 0, 0, 0, 0}) == 0);   // norm 0.1
  CHECK(code({0.08, 0.08, 0, 0, 0, 0}) == 20);  // each axis is inside
  CHECK(code({0, 0, 0, 0.4, 0.4, 0}) == 20);
  for (const double bad : {not_a_number, infinite, -infinite}) {
    CHECK(code({0, bad, 0, 0, 0, 0}) == 20);
    CHECK(code({0, 0, 0, 0, bad, 0}) == 20);
  }
}

TEST_CASE("G020 body twist: the norm of each half") {
  const auto code = [](const Row& row) {
    return judge(ChunkBuilder().add(base, Mode::body_twist, {row}, {}, "base_link").chunk)
        .evidence.code;
  };
  CHECK(code({1.0, 0, 0, 0, 0, 0}) == 0);
  CHECK(code({just_above(1.0), 0, 0, 0, 0, 0}) == 20);
  CHECK(code({0.8, 0.8, 0, 0, 0, 0}) == 20);
  CHECK(code({0, 0, 0, 0, 0, 1.5}) == 0);
  CHECK(code({0, 0, 0, 0, 0, just_below(-1.5)}) == 20);
  for (const double bad : {not_a_number, infinite, -infinite})
    CHECK(code({bad, 0, 0, 0, 0, 0}) == 20);
}

TEST_CASE("G020 gripper and composite: inside their ranges, ends included") {
  MeasuredState state = state_at_rest();
  const auto opening = [&state](double value) {
    return judge(ChunkBuilder().scalar(gripper, Mode::gripper_position, {value}).chunk, state)
        .evidence.code;
  };
  for (const double fine : {0.0, 0.08, 0.04}) CHECK(opening(fine) == 0);
  for (const double bad : {just_above(0.08), just_below(0.0), not_a_number, infinite, -infinite})
    CHECK(opening(bad) == 20);
  const auto mode = [](double value) {
    return judge(ChunkBuilder().scalar(composite, Mode::composite_mode, {value}).chunk)
        .evidence.code;
  };
  for (const double fine : {-1.0, 1.0, 0.0}) CHECK(mode(fine) == 0);
  for (const double bad : {just_above(1.0), just_below(-1.0), not_a_number, infinite, -infinite})
    CHECK(mode(bad) == 20);
}

TEST_CASE("the evidence says row, part, axis, value, limit, margin and source") {
  const Judgement judgement =
      judge(ChunkBuilder().along(arm, Mode::cartesian_delta, 2, {0.05, 0.05, 0.11}).chunk);
  CHECK(judgement.outcome == Outcome::truncated);
  CHECK(judgement.row_count == 2);
  CHECK(judgement.evidence.code == 20);
  CHECK(judgement.evidence.row == 2);
  CHECK(judgement.evidence.part == "arm");
  CHECK(judgement.evidence.axis == "linear");
  CHECK(judgement.evidence.value == doctest::Approx(0.11));
  CHECK(judgement.evidence.limit == 0.1);
  CHECK(judgement.evidence.margin == doctest::Approx(-0.01));
  CHECK(judgement.evidence.limit_source == "test cartesian mode");
}

TEST_CASE("a breach in the first row refuses, a later one cuts before it, none releases all") {
  const auto outcome = [](const Row& rows) {
    return judge(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, rows).chunk).outcome;
  };
  CHECK(outcome({0.2, 0.0, 0.0}) == Outcome::refused);
  CHECK(outcome({0.0, 0.0, 0.2}) == Outcome::truncated);
  CHECK(outcome({0.0, 0.0, 0.0}) == Outcome::released);
}

TEST_CASE("rows that are past are not judged, and the first live row is the one that refuses") {
  const ChunkBuilder builder =
      ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {5.0, 0.05, 0.05});
  CHECK(judge(builder.chunk).outcome == Outcome::refused);
  const Judgement later = judge(builder.chunk, state_at_rest(), {}, 1);
  CHECK(later.outcome == Outcome::released);
  CHECK(later.first_row == 1);
  CHECK(later.row_count == 2);
}

TEST_CASE("G011 an arm joint outside bounds and tolerance: only targets nearer to them") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = 2.2;
  const auto code = [&state](const Row& targets) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, targets).chunk, state)
        .evidence.code;
  };
  CHECK(code({2.15}) == 0);  // still outside, nearer
  CHECK(code({2.15, 2.1, 2.0}) == 0);
  CHECK(code({2.2}) == 11);  // as far out
  CHECK(code({2.25}) == 11);
  CHECK(code({2.1, 2.15}) == 11);   // and out again
  state.positions[arm_1] = 2.0625;  // within the tolerance: the bounds apply as they are
  CHECK(code({2.05}) == 20);
  CHECK(code({1.95}) == 0);
}

TEST_CASE("G011 an arm joint outside: velocities lead back, other commands do not") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = -2.2;
  const auto velocity = [&state](double value) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {value}).chunk, state)
        .evidence.code;
  };
  CHECK(velocity(0.1) == 0);
  CHECK(velocity(0.0) == 11);
  CHECK(velocity(-0.1) == 11);
  CHECK(judge(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_2, {0.1}).chunk, state)
            .evidence.code == 11);
  CHECK(judge(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.01}).chunk, state)
            .evidence.code == 11);
  // Parts that are inside their bounds are not concerned.
  CHECK(judge(ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {0.1}).chunk, state)
            .evidence.code == 0);
}

TEST_CASE("G011 below its bounds: the smallest velocity upwards is one, and margins are negative") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = -2.2;
  const auto velocity = [&state](double value) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {value}).chunk, state)
        .evidence;
  };
  CHECK(velocity(5e-324).ok());
  CHECK(velocity(-5e-324).code == 11);
  CHECK(velocity(-0.0).code == 11);
  CHECK(velocity(-0.1).margin == -0.1);
  const Evidence delta =
      judge(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.0}).chunk, state).evidence;
  CHECK(delta.limit == -2.0);
  CHECK(delta.margin == doctest::Approx(-0.2));
  state.positions[arm_1] = 2.2;
  CHECK(velocity(-5e-324).ok());
  CHECK(velocity(5e-324).code == 11);
  CHECK(velocity(0.1).margin == -0.1);
}

TEST_CASE("G011 a gripper outside its bounds may go anywhere inside them") {
  MeasuredState state = state_at_rest();
  state.positions[gripper_joint] = 0.095;
  CHECK(judge(ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.06}).chunk, state)
            .evidence.code == 0);
}

TEST_CASE("G011 a passive joint outside its bounds refuses no row; it is counted and said once") {
  GateRig rig;
  rig.ready();
  rig.positions[torso] = 0.412;
  rig.limits.passive_joints[0].jump_limit = 1.0;
  rig.restart(BootInfo{false, true, {}});
  rig.ready();
  CHECK(rig.counter("G011") == 1);
  rig.next_tick();
  CHECK(rig.counter("G011") == 1);
  CHECK(rig.send_chunk(rig.chunk()).code == 0);
}

TEST_CASE("G011 a gripper beyond its bounds and tolerance is counted and said once") {
  GateRig rig;
  rig.limits.joints[gripper_joint].jump_limit = 1.0;
  rig.restart(BootInfo{false, true, {}});
  rig.positions[gripper_joint] = 0.09;  // at bound and tolerance
  rig.ready();
  CHECK(rig.counter("G011") == 0);
  rig.positions[gripper_joint] = 0.0901;
  rig.next_tick();
  CHECK(rig.count(OutputKind::log) == 1);
  CHECK(rig.counter("G011") == 1);
  rig.next_tick();
  CHECK(rig.counter("G011") == 1);
}

TEST_CASE("G011 a joint outside its bounds blocks the chunks for its own part and no other") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = 2.2;
  CHECK(judge(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.0}).chunk, state)
            .evidence.code == 11);
  CHECK(judge(ChunkBuilder().along(base, Mode::body_twist, 0, {0.1}).chunk, state).evidence.code ==
        0);
}

TEST_CASE("a joint that turns without bounds may be told any position") {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_position = joint_mode({base_yaw}, 0.25);
  MeasuredState state = state_at_rest();
  state.positions[base_yaw] = 99.9;
  // The other number of the row makes a quick look at it say nothing.
  Row row(joint_count, 0.0);
  row[base_yaw] = 100.0;
  row[base_x] = 1e-9;
  ChunkBuilder chunk = ChunkBuilder().add(base, Mode::joint_position, {row}, {base_yaw});
  CHECK(judge_rows(limits, whole_robot(limits), state, chunk.chunk, 0, {}).evidence.ok());
  const ChunkBuilder far = ChunkBuilder().joint(base, Mode::joint_position, base_yaw, {100.2});
  CHECK(judge_rows(limits, whole_robot(limits), state, far.chunk, 0, {}).evidence.code == 21);
}

TEST_CASE("G011 rows that act on a joint without bounds are never at fault for where it is") {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_position = joint_mode({base_yaw}, 0.25);
  MeasuredState state = state_at_rest();
  state.positions[base_yaw] = 1e6;
  const ChunkBuilder acts = ChunkBuilder().joint(base, Mode::joint_position, base_yaw, {1e6});
  CHECK(check_running(RobotModel(limits), whole_robot(limits), state, acts.chunk, 0).ok());
}
