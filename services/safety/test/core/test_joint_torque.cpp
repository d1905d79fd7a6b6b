// joint_torque: bounded by the joints' effort limits, started from the measured effort.
// Limits of the test robot: 80 N m per joint, steps of 10 N m.

#include <doctest/doctest.h>

#include <cmath>

#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

ChunkBuilder torque(const Row& values, std::uint8_t joint = arm_1) {
  return ChunkBuilder().joint(arm, Mode::joint_torque, joint, values);
}

}  // namespace

TEST_CASE("G020 joint torque: up to the joint's effort limit in both directions") {
  const auto code = [](double value) {
    ChunkBuilder previous = torque({value > 0 ? 75.0 : -75.0});
    return code_after(previous, torque({value}));
  };
  for (const double fine : {just_below(80.0), 80.0, -80.0}) CHECK(code(fine) == 0);
  for (const double bad : {just_above(80.0), just_below(-80.0), not_a_number, infinite, -infinite})
    CHECK(code(bad) == 20);
}

TEST_CASE("G020 joint torque: a claim's own effort limit is the tighter one") {
  static const Limits limits = test_limits();
  ClaimLimits claim = whole_robot(limits);
  claim.modes[arm].joint_torque.claimed_limit = 5.0;
  const auto code = [&claim](double value) {
    return judge_rows(limits, claim, state_at_rest(), torque({value}).chunk, 0, {}).evidence.code;
  };
  CHECK(code(5.0) == 0);
  CHECK(code(just_above(5.0)) == 20);
  CHECK(code(just_below(-5.0)) == 20);
}

TEST_CASE("G021 a torque starts from what was executed, after a hold from what is measured") {
  MeasuredState state = state_at_rest();
  state.efforts[arm_1] = 40.0;
  const auto after_hold = [&state](double value) {
    return judge(torque({value}).chunk, state).evidence.code;
  };
  CHECK(after_hold(50.0) == 0);
  CHECK(after_hold(just_above(50.0)) == 21);
  CHECK(after_hold(30.0) == 0);
  CHECK(after_hold(just_below(30.0)) == 21);
  CHECK(after_hold(0.0) == 21);
  ChunkBuilder previous = torque({20.0});
  CHECK(code_after(previous, torque({30.0}), state) == 0);
  CHECK(code_after(previous, torque({just_above(30.0)}), state) == 21);
  // The row before commanded the other joint: this one starts from its own effort.
  CHECK(code_after(previous, torque({10.0}, arm_2), state) == 0);
  CHECK(code_after(previous, torque({just_above(10.0)}, arm_2), state) == 21);
  state.efforts[arm_1] = not_a_number;
  CHECK(after_hold(40.0) == 21);
}

TEST_CASE("G022 joint torque: the jump from row to row") {
  CHECK(judge(torque({0.0, 10.0, 0.0}).chunk).evidence.code == 0);
  const Judgement cut = judge(torque({0.0, 10.0, just_above(20.0)}).chunk);
  CHECK(cut.evidence.code == 22);
  CHECK(cut.row_count == 2);
  CHECK(cut.evidence.axis == "arm_1");
}

TEST_CASE("G011 joint torque: no row is seen to lead a joint back") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = 2.2;
  for (const double value : {0.0, -5.0, 5.0}) {
    CHECK(judge(torque({value}).chunk, state).evidence.code == 11);
    CHECK(judge(torque({value}, arm_2).chunk, state).evidence.code == 11);
  }
  state.positions[arm_1] = 2.0625;  // within the tolerance
  CHECK(judge(torque({1.0}).chunk, state).evidence.code == 0);
}

TEST_CASE("G021 joint torque: no row while a commanded joint is above its velocity limit") {
  MeasuredState state = state_at_rest();
  const auto code = [&state](std::uint8_t joint) {
    return judge(torque({1.0}, joint).chunk, state).evidence.code;
  };
  for (const double speed : {1.5, -1.5}) {
    state.velocities[arm_1] = speed;
    CHECK(code(arm_1) == 0);
  }
  for (const double speed : {just_above(1.5), just_below(-1.5), not_a_number}) {
    state.velocities[arm_1] = speed;
    CHECK(code(arm_1) == 21);
    CHECK(code(arm_2) == (std::isnan(speed) ? 31 : 0));  // nobody knows where it brakes
  }
}

TEST_CASE("G021 joint torque: a joint is left to its servo at standstill only") {
  MeasuredState state = state_at_rest();
  ChunkBuilder previous = torque({5.0});
  state.velocities[arm_1] = just_below(0.05);
  CHECK(code_after(previous, torque({0.0}, arm_2), state) == 0);
  state.velocities[arm_1] = -0.05;
  CHECK(code_after(previous, torque({0.0}, arm_2), state) == 21);
  CHECK(code_after(previous, torque({5.0}), state) == 0);
}
