// G011: a joint measured outside its bounds, on either side, and at exactly its tolerance.

#include <doctest/doctest.h>

#include "core/modes/row_limit_check.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// The arm's first joint lies between -2 and 2 rad.
std::uint32_t code_at(double measured, const ChunkBuilder& chunk) {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = measured;
  return judge(chunk.chunk, state).evidence.code;
}

ChunkBuilder target(double value) {
  return ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {value});
}

ChunkBuilder speed(double value) {
  return ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {value});
}

}  // namespace

TEST_CASE("G011 a joint is outside beyond its tolerance, which itself is inside") {
  const Bounds bounds{-2.0, 3.0, 0.0625};
  CHECK_FALSE(is_outside(bounds, -2.0625));
  CHECK(is_outside(bounds, just_below(-2.0625)));
  CHECK_FALSE(is_outside(bounds, 3.0625));
  CHECK(is_outside(bounds, just_above(3.0625)));
  CHECK(excess(bounds, -2.03125) == -0.03125);
  CHECK(excess(bounds, 3.03125) == 0.03125);
  CHECK(excess(bounds, -2.0) == 0.0);
  CHECK(excess(bounds, 3.0) == 0.0);
}

TEST_CASE("G011 a target leads back on either side") {
  for (const double side : {-1.0, 1.0}) {
    CHECK(code_at(2.25 * side, target(2.375 * side)) == 11);
    CHECK(code_at(2.25 * side, target(2.25 * side)) == 11);
    CHECK(code_at(2.25 * side, target(2.125 * side)) == 0);
    CHECK(code_at(2.25 * side, target(2.0 * side)) == 0);
  }
}

TEST_CASE("G011 a velocity leads back on either side, and standing does not") {
  for (const double side : {-1.0, 1.0}) {
    CHECK(code_at(2.25 * side, speed(-0.03125 * side)) == 0);
    CHECK(code_at(2.25 * side, speed(0.0)) == 11);
    CHECK(code_at(2.25 * side, speed(0.03125 * side)) == 11);
  }
}

TEST_CASE("G011 the row that acts next leads back from where the joint is now") {
  const Limits limits = test_limits();
  const ClaimLimits claim = whole_robot(limits);
  for (const double side : {-1.0, 1.0}) {
    const ChunkBuilder chunk = target(2.25 * side);
    MeasuredState state = state_at_rest();
    state.positions[arm_1] = 2.375 * side;
    CHECK(check_running(RobotModel(limits), claim, state, chunk.chunk, 0).ok());
    state.positions[arm_1] = 2.125 * side;
    CHECK(check_running(RobotModel(limits), claim, state, chunk.chunk, 0).code == 11);
    state.positions[arm_1] = 0.5 * side;
    CHECK(check_running(RobotModel(limits), claim, state, chunk.chunk, 0).ok());
  }
}

TEST_CASE("G011 a tool's motion that acts next says nothing of a joint that is outside") {
  const Limits limits = test_limits();
  const ClaimLimits claim = whole_robot(limits);
  const ChunkBuilder chunk =
      ChunkBuilder().add(arm, Mode::cartesian_delta, {{0, 0, 0, 0, 0, 0}}, {}, "base_link");
  MeasuredState state = state_at_rest();
  CHECK(check_running(RobotModel(limits), claim, state, chunk.chunk, 0).ok());
  state.positions[arm_1] = 2.125;
  CHECK(check_running(RobotModel(limits), claim, state, chunk.chunk, 0).code == 11);
}

TEST_CASE("G011 a row that acts next may not leave out a joint that is outside") {
  const Limits limits = test_limits();
  const ClaimLimits claim = whole_robot(limits);
  const ChunkBuilder chunk = ChunkBuilder().joint(arm, Mode::joint_position, arm_2, {0.0});
  MeasuredState state = state_at_rest();
  CHECK(check_running(RobotModel(limits), claim, state, chunk.chunk, 0).ok());
  state.positions[arm_1] = 2.125;
  CHECK(check_running(RobotModel(limits), claim, state, chunk.chunk, 0).code == 11);
}
