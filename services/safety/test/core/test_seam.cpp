// G023: the step from a row that is released but not yet executed, which only realtime knows.

#include <cmath>

#include "acted_rows.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// `previous` acts in the tick before, but the newest state was measured before it did.
std::uint32_t seam_code(const ChunkBuilder& previous, const ChunkBuilder& next,
                        const MeasuredState& state = state_at_rest()) {
  return judge(next.chunk, state, RowBefore{&previous.chunk, 0, false}).evidence.code;
}

ChunkBuilder speed(double value, std::uint8_t which = arm_1) {
  return ChunkBuilder().joint(arm, Mode::joint_velocity, which, {value});
}

ChunkBuilder pose_at(double x) {
  return ChunkBuilder().poses(arm, {{x, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0}});
}

}  // namespace

TEST_CASE("G023 the step from a row that is released and not yet executed, for every mode") {
  const auto target = [](double value) {
    return ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {value});
  };
  const auto delta = [](double x) {
    return ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {x});
  };
  const auto twist = [](double x) { return ChunkBuilder().along(base, Mode::body_twist, 0, {x}); };
  const auto opening = [](double value) {
    return ChunkBuilder().scalar(gripper, Mode::gripper_position, {value});
  };
  const auto composite_row = [](double value) {
    return ChunkBuilder().scalar(composite, Mode::composite_mode, {value});
  };
  // Step limits: 0.25 rad, 0.5 rad/s, 0.05 m, 0.15 m, 1.5 m/s, 0.05 m, 1.5.
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = 0.125;
  CHECK(seam_code(target(0.0), target(0.25), state) == 0);
  CHECK(seam_code(target(0.0), target(just_above(0.25)), state) == 23);
  CHECK(seam_code(speed(0.25), speed(0.75)) == 0);
  CHECK(seam_code(speed(0.25), speed(just_below(0.75))) == 0);
  CHECK(seam_code(speed(0.25), speed(-0.25)) == 0);
  CHECK(seam_code(speed(0.25), speed(just_above(0.75))) == 23);
  CHECK(seam_code(speed(0.25), speed(-0.25 - 1e-9)) == 23);
  CHECK(seam_code(delta(-0.1), delta(0.05)) == 0);
  CHECK(seam_code(delta(-0.1), delta(0.05 + 1e-12)) == 23);
  CHECK(seam_code(twist(-1.0), twist(0.5)) == 0);
  CHECK(seam_code(twist(-1.0), twist(0.5 + 1e-9)) == 23);
  // Not the seam, which comes before it: two joints do not reach this pose.
  CHECK(seam_code(pose_at(0.7), pose_at(0.74)) == 30);
  CHECK(seam_code(pose_at(0.66), pose_at(0.66 + 0.05 + 1e-12)) == 23);
  CHECK(seam_code(opening(0.0), opening(0.05)) == 0);
  CHECK(seam_code(opening(0.0), opening(just_above(0.05))) == 23);
  CHECK(seam_code(composite_row(-1.0), composite_row(0.5)) == 0);
  CHECK(seam_code(composite_row(-1.0), composite_row(0.5 + 1e-9)) == 23);
  CHECK(seam_code(composite_row(0.25), composite_row(not_a_number)) == 20);
  CHECK(seam_code(speed(0.25), speed(infinite)) == 20);
}

TEST_CASE("G023 a step limit that is none lets no step pass") {
  const ChunkBuilder previous = speed(0.25);
  const ChunkBuilder next = speed(0.25);
  const Limits limits = test_limits();
  ClaimLimits claim = whole_robot(limits);
  const auto code = [&](double limit) {
    claim.modes[arm].joint_velocity.step_limit[arm_1] = limit;
    return judge_rows(limits, claim, state_at_rest(), next.chunk, 0,
                      RowBefore{&previous.chunk, 0, false})
        .evidence.code;
  };
  CHECK(code(0.0) == 0);
  CHECK(code(not_a_number) == 23);
  CHECK(code(-infinite) == 23);
}

TEST_CASE("G023 a joint that the new chunk leaves out is told 0 after a row not yet executed") {
  Row row(joint_count, 0.0);
  row[arm_1] = 0.5;
  ChunkBuilder both = ChunkBuilder().add(arm, Mode::joint_velocity, {row}, {arm_1, arm_2});
  CHECK(seam_code(both, speed(0.0, arm_2)) == 0);
  row[arm_1] = just_above(0.5);
  both = ChunkBuilder().add(arm, Mode::joint_velocity, {row}, {arm_1, arm_2});
  CHECK(seam_code(both, speed(0.0, arm_2)) == 23);
}

TEST_CASE("G021 behind a target that no state has shown yet: two steps from what is measured") {
  MeasuredState state = state_at_rest();
  ChunkBuilder target = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0});
  for (const double way : {-1.0, 1.0}) {
    state.positions[arm_1] = 0.6 * way;
    CHECK(seam_code(target, target, state) == 0);
    CHECK(code_after(target, target, state) == 21);
    state.positions[arm_1] = just_above(0.6) * way;
    CHECK(seam_code(target, target, state) == 21);
  }
  // One that the row before did not command, or was told a speed by it, one.
  state = state_at_rest();
  state.positions[arm_1] = 0.35;
  CHECK(seam_code(speed(0.0), target, state) == 25);
  for (const std::uint8_t before : {std::uint8_t{arm_1}, std::uint8_t{arm_2}}) {
    const ChunkBuilder other = ChunkBuilder().joint(arm, Mode::joint_position, before, {0.0});
    ChunkBuilder both = ChunkBuilder();
    both.add(arm, Mode::joint_position, {Row(joint_count, 0.0)}, {arm_1, arm_2});
    state.positions[arm_1] = 0.35;
    CHECK(seam_code(other, both, state) == 0);
    state.positions[arm_1] = just_above(0.35);
    CHECK(seam_code(other, both, state) == (before == arm_1 ? 0 : 21));
  }
  state = state_at_rest();
  state.positions[gripper_joint] = -0.03;
  const auto opening = [](double value) {
    return ChunkBuilder().scalar(gripper, Mode::gripper_position, {value});
  };
  CHECK(seam_code(opening(0.05), opening(0.08), state) == 0);
  ChunkBuilder open = opening(0.05);
  CHECK(code_after(open, opening(0.08), state) == 21);
  state.positions[gripper_joint] = -0.03 - 1e-9;
  CHECK(seam_code(opening(0.05), opening(0.08), state) == 21);
  // The tool is measured at 0.7; two joints do not reach these poses.
  CHECK(seam_code(pose_at(0.64), pose_at(0.6 + 1e-9)) == 30);
  ChunkBuilder pose = pose_at(0.64);
  CHECK(code_after(pose, pose_at(0.6 + 1e-9)) == 21);
  CHECK(seam_code(pose_at(0.64), pose_at(0.6 - 1e-9)) == 21);
  const auto turned = [](double angle) {
    return ChunkBuilder().poses(
        arm, {{0.7, 0.0, 0.5, 0.0, 0.0, std::sin(angle / 2.0), std::cos(angle / 2.0)}});
  };
  CHECK(seam_code(turned(0.3), turned(0.5 - 1e-9)) == 30);
  CHECK(seam_code(turned(0.3), turned(0.5 + 1e-9)) == 21);
}

TEST_CASE("G021 stays for what is measured, and for a row that has acted") {
  // A joint that the row before did not command starts from its measured speed.
  CHECK(seam_code(speed(0.25), speed(just_above(0.5), arm_2)) == 21);
  ChunkBuilder previous = speed(0.25);
  CHECK(code_after(previous, speed(just_above(0.75))) == 21);
}

TEST_CASE("G023 in realtime, G021 in lockstep: the same chunk after the same row") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();
    const auto after = [&rig, lockstep](const Row& speeds) {
      ChunkBuilder chunk = rig.chunk(speeds);
      chunk.chunk.start_tick += lockstep ? 0 : 1;
      return rig.send_chunk(chunk);
    };
    const auto tell = [&rig, lockstep](double value) {
      if (lockstep) rig.velocities[base_x] = value;
      const Acted did = lockstep ? row_of(rig.safe_chunk(), 0) : Acted{2, 0, 0};
      rig.next_tick_of({Acted{2, 0, 0}, Acted{2, 0, 0}, did, Acted{2, 0, 0}});
    };
    REQUIRE(after({1.0, 1.0}).code == 0);
    tell(1.0);
    const Verdict verdict = after({-1.0 - 1e-9});  // the base's step limit is 2 m/s
    CHECK(verdict.code == (lockstep ? 21 : 23));
    CHECK(verdict.part == "base");
    CHECK(verdict.axis == "base_x");
    CHECK(verdict.limit == 2.0);
    CHECK(verdict.unit == "m/s");
    CHECK(verdict.limit_source == "test joint mode");
    CHECK(rig.counter("G023") == (lockstep ? 0 : 1));
    CHECK(rig.counter("G021") == (lockstep ? 1 : 0));
    CHECK(after({-1.0}).code == 0);
  }
}
