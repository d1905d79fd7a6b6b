// G026: how fast the joints have to be for what a tool is told, and how fast they are already.

#include <doctest/doctest.h>

#include <cmath>

#include "free_arm.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

Evidence of(const Limits& limits, const ChunkBuilder& chunk,
            const MeasuredState& state = free_arm::at_rest()) {
  return free_arm::judge(limits, chunk.chunk, state).evidence;
}

ChunkBuilder delta(std::size_t axis, const Row& values) {
  return ChunkBuilder().along(arm, Mode::cartesian_delta, axis, values);
}

}  // namespace

TEST_CASE("G026 a joint is told no more than its velocity limit, up to and including it") {
  Limits limits = free_arm::limits();
  const ChunkBuilder pose = ChunkBuilder().poses(arm, {{0.7, 0.04, 0.5, 0, 0, 0, 1}});
  const ChunkBuilder twist = ChunkBuilder().along(arm, Mode::cartesian_twist, 1, {0.4});
  for (const ChunkBuilder& chunk : {delta(1, {0.04}), pose, twist}) {
    limits.joints[slide_y].velocity_limit = 0.1;
    const Evidence told = of(limits, chunk);
    CHECK(told.code == 26);
    CHECK(told.part == "arm");
    CHECK(told.axis == "slide_y");
    CHECK(told.limit == 0.1);
    CHECK(told.unit == "m/s");
    CHECK(told.limit_source == "test joint");
    const double speed = told.value;
    for (const double fine : {speed, just_above(speed), infinite}) {
      limits.joints[slide_y].velocity_limit = fine;
      CHECK(of(limits, chunk).ok());
    }
    for (const double low : {just_below(speed), 0.0, not_a_number}) {
      limits.joints[slide_y].velocity_limit = low;
      CHECK(of(limits, chunk).code == 26);
    }
  }
}

TEST_CASE("G026 the larger share of a row counts, and each row by itself") {
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.cartesian_delta.gain = {0.25, 0.5};
  limits.joints[slide_z].velocity_limit = 0.45;  // 0.8 m/s by half
  CHECK(of(limits, delta(2, {0.04})).ok());
  limits.joints[slide_z].velocity_limit = 0.39;
  CHECK(of(limits, delta(2, {0.04})).code == 26);
  CHECK(free_arm::judge(limits, delta(2, {0.02, 0.03, 0.04}).chunk).row_count == 2);
}

TEST_CASE("G026 a joint that is faster than its limit already only holds, in the first row") {
  const Limits limits = free_arm::limits();
  for (const double speed : {1.5, -1.5}) {
    MeasuredState state = free_arm::at_rest();
    state.velocities[turn_z] = speed;
    CHECK(of(limits, delta(1, {0.0, 0.0}), state).ok());
    state.velocities[turn_z] = speed * (1.0 + 1e-15);
    const Evidence told = of(limits, delta(1, {0.0}), state);
    CHECK(told.code == 26);
    CHECK(told.axis == "turn_z");
    CHECK(told.value == std::abs(state.velocities[turn_z]));
    CHECK(of(limits, one_joint(Mode::joint_velocity, turn_z, {0.0}), state).ok());
  }
}

TEST_CASE("G026 a joint is as fast as its positions say where its velocity is stuck at 0") {
  const Limits limits = free_arm::limits();
  MeasuredState state = free_arm::at_rest();
  state.travel_speeds[turn_z] = -1.5;
  CHECK(of(limits, delta(1, {0.0}), state).ok());
  state.travel_speeds[turn_z] = -1.6;
  const Evidence told = of(limits, delta(1, {0.0}), state);
  CHECK(told.code == 26);
  CHECK(told.value == doctest::Approx(1.6).epsilon(1e-4));
}

TEST_CASE("G026 where the straight way and the one found differ, the faster counts") {
  // Half a turn about z: a straight step of least squares overshoots what the slides then do.
  Limits limits = free_arm::limits();
  limits.joints[turn_z].velocity_limit = limits.joints[slide_y].velocity_limit = vast;
  limits.joints[slide_x].velocity_limit = 1e-3;
  CHECK(of(limits, delta(5, {0.4})).code == 26);
}
