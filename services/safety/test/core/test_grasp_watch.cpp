// G042: what a gripper is taken to hold, at the edges; all numbers are exact in binary.

#include "core/monitor/grasp_watch.hpp"

#include <doctest/doctest.h>

#include <initializer_list>

#include "chunk_builder.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double near = 0.015625;  // the joint's tolerance
constexpr double slip = 0.03125;   // twice that
constexpr double speed = 0.0625;   // from here on it does not stand still
constexpr double closed = 0.25, open = 0.5;

class Hand {
 public:
  Hand() : limits_(test_limits()), state_(state_at_rest()) {
    limits_.joints[gripper_joint].bounds = {0.0, 1.0, near};
    limits_.joints[gripper_joint].standstill_velocity = speed;
    limits_.parts[gripper].modes.gripper_position.slip_limit = slip;
  }
  /// In a new state at `opening`, after a row that told `target`; whether it lost something.
  bool told(double target, double opening, double velocity = 0.0) {
    ChunkBuilder builder;
    builder.scalar(gripper, Mode::gripper_position, {target});
    return loses(row_of(builder.chunk.parts[0], 0, limits_), opening, velocity);
  }
  /// After a tick without a row.
  bool held(double opening, double velocity = 0.0) { return loses({}, opening, velocity); }
  /// Three states at rest there.
  void rest(double opening) {
    for (int i = 0; i < 3; ++i) CHECK_FALSE(held(opening));
  }
  /// After any row, or none.
  bool loses(const Setpoint& setpoint, double opening, double velocity) {
    state_.positions[gripper_joint] = opening;
    state_.velocities[gripper_joint] = velocity;
    return watch.note(limits_, state_, gripper, setpoint).code == 42;
  }
  GraspWatch watch;

 private:
  Limits limits_;
  MeasuredState state_;
};

// Told to close, seen to do so, and resting there since.
Hand holding_at(double opening) {
  Hand hand;
  CHECK_FALSE(hand.told(closed, open, -speed));
  hand.rest(opening);
  return hand;
}

// Whether it holds after it went so far from `open` towards its target, at rest all the while.
bool holds_after(double target, double way) {
  Hand hand;
  CHECK_FALSE(hand.told(target, open));
  hand.rest(open + way);
  const double further = target < open ? -2.0 * slip : 2.0 * slip;
  return hand.held(open + way + further);
}

}  // namespace

TEST_CASE("G042 a way up to the tolerance is no motion, either way") {
  CHECK_FALSE(holds_after(closed, -near));
  CHECK(holds_after(closed, -near - 0x1p-40));
  CHECK_FALSE(holds_after(closed, -0.75 * near));
  CHECK_FALSE(holds_after(1.0, near));
  CHECK(holds_after(1.0, near + 0x1p-40));
  CHECK_FALSE(holds_after(1.0, 0.75 * near));
}

TEST_CASE("G042 a speed below standstill is no motion, either way") {
  const auto holds = [](double target, double velocity) {
    Hand hand;
    CHECK_FALSE(hand.told(target, open, velocity));
    hand.rest(open);
    return hand.held(open + (target < open ? -2.0 * slip : 2.0 * slip));
  };
  CHECK(holds(closed, -speed));
  CHECK_FALSE(holds(closed, -0.75 * speed));
  CHECK(holds(1.0, speed));
  CHECK_FALSE(holds(1.0, 0.75 * speed));
}

TEST_CASE("G042 told to be where it is: what then opens it is motion as good as any") {
  Hand hand;
  CHECK_FALSE(hand.told(closed, closed, speed));
  hand.rest(closed + 2.0 * near);
  CHECK(hand.held(closed + 2.0 * near - 2.0 * slip));
}

TEST_CASE("G042 within the tolerance of its target it holds nothing") {
  Hand there = holding_at(closed + near);
  CHECK_FALSE(there.held(closed + near - 2.0 * slip));
  Hand almost = holding_at(closed + near + 0x1p-40);
  CHECK(almost.held(closed + near - 2.0 * slip));
}

TEST_CASE("G042 a target within the tolerance of the last is the same grasp") {
  Hand same = holding_at(closed + 4.0 * near);
  CHECK(same.told(closed - near, closed + 4.0 * near - 2.0 * slip));
  Hand another = holding_at(closed + 4.0 * near);
  CHECK_FALSE(another.told(closed - near - 0x1p-40, closed + 4.0 * near - 2.0 * slip));
}

TEST_CASE("G042 a hand that reached its target holds nothing any more") {
  Hand hand = holding_at(closed + 1.5 * near);
  CHECK_FALSE(hand.held(closed));
  CHECK_FALSE(hand.held(closed - near));
}

TEST_CASE("G042 exactly at its target it is told to go on: nothing is held") {
  Hand hand = holding_at(closed + 1.5 * near);
  CHECK_FALSE(hand.told(closed - 8.0 * near, closed));
  for (int i = 0; i < 3; ++i) CHECK_FALSE(hand.held(closed));
  CHECK_FALSE(hand.held(closed - 2.0 * slip));
}

TEST_CASE("G042 told to stay where it is, it holds nothing") {
  Hand hand = holding_at(open);
  CHECK_FALSE(hand.told(open, open));
  hand.rest(open - 2.0 * near);
  CHECK_FALSE(hand.held(open - 2.0 * near + 2.0 * slip));
}

TEST_CASE("G042 what is forgotten cannot be lost") {
  Hand one = holding_at(open);
  one.watch.forget(gripper);
  CHECK_FALSE(one.told(closed, open - 2.0 * slip));
  Hand all = holding_at(open);
  all.watch.clear();
  CHECK_FALSE(all.told(closed, open - 2.0 * slip));
  Hand none = holding_at(open);
  CHECK(none.told(closed, open - 2.0 * slip));
}

TEST_CASE("G042 a hand told something else than an opening holds nothing that it could lose") {
  ChunkBuilder joints;
  joints.joint(gripper, Mode::joint_position, gripper_joint, {closed});
  const Setpoint other{&joints.chunk.parts[0], gripper_joint};
  Hand hand = holding_at(open);
  CHECK_FALSE(hand.loses(other, open, 0.0));
  CHECK_FALSE(hand.loses(other, open - 2.0 * slip, 0.0));
}
