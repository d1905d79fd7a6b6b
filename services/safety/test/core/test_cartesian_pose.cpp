// cartesian_pose: a box, a unit quaternion, and steps from the measured tool frame.
// Limits of both robots: a box of 1 m to each side, steps of 0.05 m and 0.25 rad; at rest the tool
// is at (0.7, 0, 0.5). The free arm reaches every pose, so that only these limits refuse.

#include <doctest/doctest.h>

#include <cmath>

#include "free_arm.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

const Row at_rest{0.7, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0};

Row shifted(std::size_t axis, double by, Row from = at_rest) {
  from[axis] += by;
  return from;
}

Row turned(double angle, double sign = 1.0) {
  return {0.7, 0.0, 0.5, 0.0, sign * std::sin(angle / 2), 0.0, sign * std::cos(angle / 2)};
}

ChunkBuilder poses(const Rows& rows) { return ChunkBuilder().poses(arm, rows); }

Judgement freely(const Rows& rows, const MeasuredState& state = free_arm::at_rest(),
                 const RowBefore& before = {}) {
  static const Limits limits = [] {
    Limits fast = free_arm::limits();
    for (JointLimits& joint : fast.joints) joint.velocity_limit = vast;
    return fast;
  }();
  return free_arm::judge(limits, poses(rows).chunk, state, before);
}

std::uint32_t code_of(const Rows& rows, const MeasuredState& state = free_arm::at_rest()) {
  return freely(rows, state).evidence.code;
}

std::uint32_t pose_after(ChunkBuilder& previous, const Row& row,
                         const MeasuredState& state = free_arm::at_rest()) {
  return freely({row}, state, RowBefore{&previous.chunk, 0}).evidence.code;
}

}  // namespace

TEST_CASE("G020 cartesian pose: inside the box, ends included") {
  static const Limits limits = free_arm::limits();
  ClaimLimits claim = whole_robot(limits);
  claim.modes[arm].cartesian_pose.lower = {0.69, -0.01, 0.49};
  claim.modes[arm].cartesian_pose.upper = {0.71, 0.01, 0.51};
  const auto inside = [&claim](std::size_t axis, double value) {
    Row row = at_rest;
    row[axis] = value;
    const Judgement judgement =
        judge_rows(limits, claim, free_arm::at_rest(), poses({row}).chunk, 0, {});
    if (!judgement.evidence.ok()) CHECK(judgement.evidence.axis == std::array{"x", "y", "z"}[axis]);
    return judgement.evidence.code;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double lower = claim.modes[arm].cartesian_pose.lower[axis];
    const double upper = claim.modes[arm].cartesian_pose.upper[axis];
    for (const double fine : {lower, just_above(lower), just_below(upper), upper})
      CHECK(inside(axis, fine) == 0);
    for (const double bad :
         {just_below(lower), just_above(upper), not_a_number, infinite, -infinite})
      CHECK(inside(axis, bad) == 20);
  }
}

TEST_CASE("G020 cartesian pose: a unit quaternion within 1e-6") {
  const auto of_norm = [](double norm) { return code_of({{0.7, 0.0, 0.5, 0.0, 0.0, 0.0, norm}}); };
  for (const double fine : {1.0, 1.0 - 0.999e-6, 1.0 + 0.999e-6, -1.0}) CHECK(of_norm(fine) == 0);
  for (const double bad : {1.0 - 1.001e-6, 1.0 + 1.001e-6, 0.0, 2.0, not_a_number, infinite})
    CHECK(of_norm(bad) == 20);
  const Judgement zero = freely({{0.7, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0}});
  CHECK(zero.evidence.axis == "quaternion norm");
  for (std::size_t axis = 3; axis < 7; ++axis) CHECK(code_of({shifted(axis, not_a_number)}) == 20);
}

TEST_CASE("G021 a pose starts at the measured tool frame and at what was executed") {
  CHECK(code_of({at_rest}) == 0);
  CHECK(code_of({shifted(0, 0.05 - 1e-12)}) == 0);
  CHECK(code_of({shifted(0, 0.05 + 1e-12)}) == 21);
  CHECK(code_of({shifted(2, -0.05 - 1e-12)}) == 21);
  CHECK(code_of({{0.74, 0.04, 0.5, 0.0, 0.0, 0.0, 1.0}}) == 21);  // each axis is inside
  CHECK(code_of({turned(0.25 - 1e-12)}) == 0);
  CHECK(code_of({turned(0.25 + 1e-12)}) == 21);
  CHECK(code_of({turned(-0.25 - 1e-12)}) == 21);
  // The arm stands somewhere else: so does the pose that starts it.
  MeasuredState state = free_arm::at_rest();
  state.positions[free_arm::turn_z] = std::acos(0.0);
  const double half = std::sqrt(0.5);
  CHECK(code_of({{0.0, 0.7, 0.5, 0.0, 0.0, half, half}}, state) == 0);
  CHECK(code_of({at_rest}, state) == 21);
  // What was executed last counts as well as what is measured.
  ChunkBuilder previous = poses({shifted(0, -0.03)});
  CHECK(pose_after(previous, shifted(0, 0.02 - 1e-12)) == 0);
  CHECK(pose_after(previous, shifted(0, 0.02 + 1e-12)) == 21);
  CHECK(pose_after(previous, shifted(0, 0.02), state) == 21);
}

TEST_CASE("G021 a quaternion and its negative are the same start") {
  CHECK(code_of({turned(0.2, -1.0)}) == 0);
  CHECK(code_of({turned(0.25 + 1e-12, -1.0)}) == 21);
  ChunkBuilder previous = poses({turned(0.1)});
  CHECK(pose_after(previous, turned(0.1, -1.0)) == 0);
}

TEST_CASE("G021 a measurement that is no number starts no pose") {
  for (std::size_t joint = 0; joint < 6; ++joint)
    for (const double bad : {not_a_number, infinite}) {
      MeasuredState state = free_arm::at_rest();
      state.positions[joint] = bad;
      CHECK(code_of({at_rest}, state) != 0);
    }
}

TEST_CASE("G022 cartesian pose: the jump from row to row in place and angle") {
  CHECK(code_of({at_rest, shifted(1, 0.04), shifted(1, 0.08)}) == 0);
  CHECK(code_of({at_rest, shifted(1, 0.05 + 1e-12)}) == 22);
  CHECK(code_of({at_rest, turned(0.25 - 1e-12), turned(0.5 - 2e-12, -1.0)}) == 0);
  CHECK(code_of({at_rest, turned(0.25 + 1e-12)}) == 22);
  CHECK(code_of({at_rest, turned(6.2)}) == 0);  // the other way round it is 0.083 rad
  const Judgement cut = freely({at_rest, shifted(1, 0.04), shifted(1, 0.12)});
  CHECK(cut.row_count == 2);
  CHECK(cut.evidence.axis == "linear");
  CHECK(cut.evidence.limit == 0.05);
}

TEST_CASE("G011 cartesian pose: refused while a joint of the part is outside its bounds") {
  MeasuredState state = free_arm::at_rest();
  state.positions[free_arm::turn_y] = 2.2;
  CHECK(code_of({at_rest}, state) == 11);
}

TEST_CASE("a pose in another frame than the root is judged in that frame") {
  static Limits limits = test_limits();
  limits.parts[arm].modes.cartesian_pose.frames[0] = "column";
  REQUIRE(check_limits(limits).empty());
  const ClaimLimits claim = whole_robot(limits);
  MeasuredState state = state_at_rest();
  state.positions[torso] = 0.2;  // the column carries the arm: seen from it, nothing has moved
  const auto in_column = [&](const Row& row) {
    const ChunkBuilder builder = ChunkBuilder().add(arm, Mode::cartesian_pose, {row}, {}, "column");
    CHECK(check_shape(limits, claim, builder.chunk).ok());
    return judge_rows(limits, claim, state, builder.chunk, 0, {}).evidence.code;
  };
  CHECK(in_column(at_rest) == 0);
  CHECK(in_column(shifted(2, 0.2)) == 21);
}

TEST_CASE("G025 another frame than before is another mode: from standstill only") {
  static Limits limits = test_limits();
  (void)limits.parts[arm].modes.cartesian_pose.frames.push_back("column");
  const ClaimLimits claim = whole_robot(limits);
  const ChunkBuilder before = poses({at_rest});
  const ChunkBuilder next = ChunkBuilder().add(arm, Mode::cartesian_pose, {at_rest}, {}, "column");
  MeasuredState state = state_at_rest();
  const auto code_now = [&] {
    return judge_rows(limits, claim, state, next.chunk, 0, RowBefore{&before.chunk, 0})
        .evidence.code;
  };
  CHECK(code_now() == 0);
  state.velocities[arm_2] = 0.05;
  CHECK(code_now() == 25);
}

TEST_CASE("G025 from poses to deltas and back at standstill only") {
  ChunkBuilder pose = poses({at_rest});
  ChunkBuilder delta = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.01});
  MeasuredState state = state_at_rest();
  CHECK(code_after(pose, delta, state) == 0);
  CHECK(code_after(delta, pose, state) == 0);
  state.velocities[arm_1] = -0.05;
  CHECK(code_after(pose, delta, state) == 25);
  CHECK(code_after(delta, pose, state) == 25);
}
