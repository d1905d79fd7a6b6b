// cartesian_twist: norms, and a start from the measured velocity of the tool frame.
// Limits of the test robot: 0.5 m/s and 1 rad/s, steps of 0.75 m/s and 1.5 rad/s.

#include <doctest/doctest.h>

#include <cmath>

#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

ChunkBuilder twist(const Rows& rows, const char* frame = "base_link") {
  return ChunkBuilder().add(arm, Mode::cartesian_twist, rows, {}, frame);
}

std::uint32_t code_of(const Rows& rows, const MeasuredState& state = state_at_rest()) {
  return judge(twist(rows).chunk, state).evidence.code;
}

}  // namespace

TEST_CASE("G020 cartesian twist: the norm of each half") {
  CHECK(code_of({{0.5, 0, 0, 0, 0, 0}}) == 0);
  CHECK(code_of({{just_above(0.5), 0, 0, 0, 0, 0}}) == 20);
  CHECK(code_of({{0, 0, just_below(-0.5), 0, 0, 0}}) == 20);
  CHECK(code_of({{0, 0, 0, 0, 1.0, 0}}) == 0);
  CHECK(code_of({{0, 0, 0, 0, just_above(1.0), 0}}) == 20);
  CHECK(code_of({{0.3, 0.4, 0, 0.6, 0.8, 0}}) == 0);
  CHECK(code_of({{0.4, 0.4, 0, 0, 0, 0}}) == 20);  // each axis is inside
  CHECK(code_of({{0, 0, 0, 0.8, 0, 0.8}}) == 20);
  for (std::size_t axis = 0; axis < 6; ++axis)
    for (const double bad : {not_a_number, infinite, -infinite}) {
      Row row(6, 0.0);
      row[axis] = bad;
      CHECK(code_of({row}) == 20);
    }
}

TEST_CASE("G021 a tool twist starts from what was executed, after a hold from what is measured") {
  static Limits limits = test_limits();
  ClaimLimits claim = whole_robot(limits);
  claim.modes[arm].cartesian_twist.linear_step_limit = 0.2;
  claim.modes[arm].cartesian_twist.angular_step_limit = 0.4;
  MeasuredState state = state_at_rest();
  const auto start = [&](const Row& row, const RowBefore& before = {}) {
    return judge_rows(limits, claim, state, twist({row}).chunk, 0, before).evidence.code;
  };
  CHECK(start({0.2, 0, 0, 0, 0, 0}) == 0);
  CHECK(start({just_above(0.2), 0, 0, 0, 0, 0}) == 21);
  CHECK(start({0, 0, 0, 0.4, 0, 0}) == 0);
  CHECK(start({0, 0, 0, just_above(0.4), 0, 0}) == 21);
  // arm_1 turns the outstretched arm, 0.7 m long, about z: the tool moves along y and turns.
  state.velocities[arm_1] = 0.5;
  CHECK(start({0, 0.35, 0, 0, 0, 0.5}) == 0);
  CHECK(start({0, 0.15 - 1e-9, 0, 0, 0, 0.5}) == 21);
  CHECK(start({0, 0.35, 0, 0, 0, 0.9 + 1e-9}) == 21);
  CHECK(start({0, 0, 0, 0, 0, 0.5}) == 21);
  // A quarter turn on, the same motion is along -x.
  state.positions[arm_1] = std::acos(0.0);
  CHECK(start({-0.35, 0, 0, 0, 0, 0.5}) == 0);
  CHECK(start({0, 0.35, 0, 0, 0, 0.5}) == 21);
  // What was executed last counts instead of what is measured.
  const ChunkBuilder previous = twist({{0.2, 0, 0, 0, 0, 0}});
  CHECK(start({0.4, 0, 0, 0, 0, 0}, RowBefore{&previous.chunk, 0}) == 0);
  CHECK(start({just_above(0.4), 0, 0, 0, 0, 0}, RowBefore{&previous.chunk, 0}) == 21);
  state.velocities[arm_1] = not_a_number;
  CHECK(start({0, 0, 0, 0, 0, 0}) == 21);
}

TEST_CASE("G021 a tool twist is compared along the axes of its own frame") {
  static Limits limits = test_limits();
  limits.parts[arm].modes.cartesian_twist.frames[0] = "tool";
  REQUIRE(check_limits(limits).empty());
  ClaimLimits claim = whole_robot(limits);
  claim.modes[arm].cartesian_twist.linear_step_limit = 0.2;
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = std::acos(0.0);
  state.velocities[arm_1] = 0.5;  // along the tool's own y, wherever that points
  const auto start = [&](const Row& row) {
    return judge_rows(limits, claim, state, twist({row}, "tool").chunk, 0, {}).evidence.code;
  };
  CHECK(start({0, 0.35, 0, 0, 0, 0.5}) == 0);
  CHECK(start({-0.35, 0, 0, 0, 0, 0.5}) == 21);
}

TEST_CASE("G022 cartesian twist: the jump from row to row") {
  CHECK(code_of({{0.25, 0, 0, 0, 0, 0}, {-0.5, 0, 0, 0, 0, 0}}) == 0);
  CHECK(
      code_of({{0.25, 0, 0, 0, 0, 0}, {-0.25, 0, 0, 0, 0, 0}, {just_above(0.5), 0, 0, 0, 0, 0}}) ==
      20);
  CHECK(code_of({{0.3, 0, 0, 0, 0, 0}, {-0.46, 0, 0, 0, 0, 0}}) == 22);
  CHECK(code_of({{0, 0, 0, 0, 0.5, 0}, {0, 0, 0, 0, -1.0, 0}}) == 0);
  CHECK(code_of({{0, 0, 0, 0, 0.51, 0}, {0, 0, 0, 0, -1.0, 0}}) == 22);
}

TEST_CASE("G011 cartesian twist: refused while a joint of the part is outside its bounds") {
  MeasuredState state = state_at_rest();
  state.positions[arm_2] = -2.2;
  CHECK(code_of({{0, 0, 0, 0, 0, 0}}, state) == 11);
}

TEST_CASE("G021 a tool twist: what another part adds to the tool's motion is not this part's") {
  static Limits limits = test_limits();
  limits.parts[arm].joints.erase_at(0);  // arm_1 is another part's, and turns the whole arm
  (void)limits.parts[base].joints.push_back(arm_1);
  limits.joints[arm_1].part = base;
  ClaimLimits claim = whole_robot(limits);
  claim.modes[arm].cartesian_twist.linear_step_limit = 0.2;
  MeasuredState state = state_at_rest();
  state.velocities[arm_1] = 1.0;  // the tool moves at 0.7 m/s along y
  const auto start = [&](const Row& row) {
    return judge_rows(limits, claim, state, twist({row}).chunk, 0, {}).evidence.code;
  };
  CHECK(start({0, 0, 0, 0, 0, 0}) == 0);
  CHECK(start({0, 0.45, 0, 0, 0, 1.0}) == 21);
}
