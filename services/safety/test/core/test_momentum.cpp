// What a row starts from goes on: the speed that joints have, and where it takes them, whatever
// they are told. Rows last 0.05 s; joints brake at 5 m/s2 where a test says so.

#include <doctest/doctest.h>

#include <cmath>

#include "core/chunk/judgement.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr double eps = 1e-9;

Limits between(double lower, double upper) {
  Limits limits = free_arm::limits();
  limits.joints[slide_x].acceleration_limit = 5.0;
  limits.joints[slide_x].bounds.lower = lower;
  limits.joints[slide_x].bounds.upper = upper;
  return limits;
}

Evidence told(const Limits& limits, Mode mode, const Row& values, double speed) {
  MeasuredState state = at_rest();
  state.velocities[slide_x] = speed;
  return free_arm::judge(limits, one_joint(mode, slide_x, values).chunk, state).evidence;
}

}  // namespace

TEST_CASE(
    "G024 a target in the first row: as fast as measured, either way, wherever the target is") {
  const Limits limits = between(-0.15, 0.15);
  for (const double way : {1.0, -1.0}) {
    CHECK(told(limits, Mode::joint_position, {0.01 * way}, 1.1 * way).ok());
    CHECK(told(limits, Mode::joint_position, {0.01 * way}, 1.2 * way).code == 24);  // 0.144 m
    CHECK(told(limits, Mode::joint_position, {-0.01 * way}, 1.2 * way).ok());
    CHECK(told(limits, Mode::joint_position, {0.0}, 1.2 * way).ok());
    CHECK(told(limits, Mode::joint_position, {0.0}, 1.3 * way).code == 24);  // 0.169 m
    CHECK(told(limits, Mode::joint_position, {-0.01 * way}, 1.3 * way).code == 24);
    // Slower than it is told: 0.6 m/s takes 36 mm from 0.03.
    CHECK(told(between(-0.066 - eps, 0.066 + eps), Mode::joint_position, {0.03 * way}, 0.3 * way)
              .ok());
    CHECK(told(between(-0.066 + eps, 0.066 - eps), Mode::joint_position, {0.03 * way}, 0.3 * way)
              .code == 24);
  }
}

TEST_CASE("G024 the first row, told to stay or to go back by however little: as fast as measured") {
  const Limits limits = between(-0.15, 0.15);
  const auto pose = [&](double x, double speed) {
    MeasuredState state = at_rest();
    state.velocities[slide_x] = speed;
    const ChunkBuilder chunk = ChunkBuilder().poses(arm, {{0.7 + x, 0, 0.5, 0, 0, 0, 1}});
    return free_arm::judge(limits, chunk.chunk, state).evidence;
  };
  for (const double way : {1.0, -1.0}) {
    for (const double behind : {0.0, 1e-17, 1e-9, 0.01}) {
      CAPTURE(behind);
      CHECK(pose(-behind * way, 1.2 * way).ok());
      CHECK(pose(-behind * way, 1.3 * way).code == 24);
      CHECK(told(limits, Mode::joint_position, {-behind * way}, 1.2 * way).ok());
      CHECK(told(limits, Mode::joint_position, {-behind * way}, 1.3 * way).code == 24);
      // A tick more: 0.138 and 0.176 m.
      CHECK(told(limits, Mode::joint_velocity, {-behind * way}, 0.95 * way).ok());
      CHECK(told(limits, Mode::joint_velocity, {-behind * way}, 1.1 * way).code == 24);
    }
  }
}

TEST_CASE("G024 a target counts from the row before it, also if another row came before that") {
  const Limits limits = between(-2.0, 0.2);
  MeasuredState state = at_rest();
  state.positions[slide_x] = 0.05;
  const ChunkBuilder before = one_joint(Mode::joint_position, slide_x, {0.1});
  const ChunkBuilder next = one_joint(Mode::joint_position, slide_x, {0.125, 0.15});
  // 0.5 m/s both, 25 mm. From 0.1 the second would be 1 m/s, and 0.1 m.
  CHECK(free_arm::judge(limits, next.chunk, state, RowBefore{&before.chunk, 0}).evidence.ok());
}

TEST_CASE("G024 realtime: of what acts already, the share that leads too far first is told") {
  Limits limits = between(-2.0, 0.07);
  limits.parts[arm].modes.joint_velocity.gain = {0.5, 1.0};
  const ChunkBuilder acts = one_joint(Mode::joint_velocity, slide_x, {1.0});
  const ChunkBuilder stops = one_joint(Mode::joint_velocity, slide_x, {0.0});
  RowBefore before{&acts.chunk, 0};
  before.measured = false;
  // Half of it: 25 mm, 25 mm more at 0.5 m/s, 25 mm to brake. All of it: 0.2 m. The forecast is
  // asked first: 0.13125 m.
  const Evidence evidence = free_arm::judge(limits, stops.chunk, at_rest(), before).evidence;
  CHECK(evidence.code == 24);
  CHECK(evidence.row == 0);
  CHECK(evidence.value == doctest::Approx(0.13125));
  limits.joints[slide_x].bounds.upper = 0.15;
  CHECK(free_arm::judge(limits, stops.chunk, at_rest(), before).evidence.value ==
        doctest::Approx(0.2));
  limits.joints[slide_x].bounds.upper = 0.2 + eps;
  CHECK(free_arm::judge(limits, stops.chunk, at_rest(), before).evidence.ok());
}

TEST_CASE(
    "G024 realtime: what acts already may go on for a tick, what a later row starts from not") {
  // 1 m/s acts, 0.05 m, then goes on for a row or a tick, 0.05 m, and brakes in 0.1 m. The row
  // after that tells it to stay where it is then.
  Limits limits = between(-2.0, 0.2 + eps);
  const ChunkBuilder acts = one_joint(Mode::joint_velocity, slide_x, {1.0});
  const ChunkBuilder goes_on = one_joint(Mode::joint_velocity, slide_x, {1.0, 0.0, 0.0});
  RowBefore before{&acts.chunk, 0};
  before.measured = false;
  CHECK(free_arm::judge(limits, goes_on.chunk, at_rest(), before).evidence.ok());
  limits.joints[slide_x].bounds.upper = 0.2 - eps;
  const Evidence evidence = free_arm::judge(limits, goes_on.chunk, at_rest(), before).evidence;
  CHECK(evidence.code == 24);
  CHECK(evidence.row == 0);
}

TEST_CASE("G032 a post on the way of braking is not jumped over, in either direction") {
  Limits limits = between(-2.0, 2.0);
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.005};
  limits.collision.clearance = 0.001;
  for (const double way : {1.0, -1.0}) {
    // At 1 m/s: 0.05 m in the row, 0.1 m to brake; the post is 0.1 m from where the tool rests.
    limits.collision.capsules[0] = {0, {0.7 + 0.1 * way, 0, 0.3}, {0.7 + 0.1 * way, 0, 0.7}, 0.005};
    CHECK(told(limits, Mode::joint_position, {0.05 * way}, 0.0).code == 32);
    CHECK(told(limits, Mode::joint_position, {0.02 * way}, 0.0).ok());  // at rest at 36 mm
    CHECK(told(limits, Mode::joint_position, {-0.05 * way}, 0.0).ok());
  }
}

namespace {

// A square of 1 m that may go as far as x = `right` ahead.
Limits hall(double right) {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_velocity.gain = {1.0, 1.0};
  limits.parts[base].modes.body_twist.gain = {1.0, 1.0};
  auto& corners = limits.base.zones[0].corners;
  corners = square(3.0);
  corners[1][0] = corners[2][0] = right;
  return limits;
}

std::uint32_t path_code(const Limits& limits, const ChunkBuilder& chunk,
                        const MeasuredState& state = state_at_rest()) {
  return judge_path(RobotModel(limits), whole_robot(limits), state, chunk.chunk, 0, 1, {}, {})
      .evidence.code;
}

}  // namespace

TEST_CASE("G034 a base goes on through the first row as fast as it is measured, told to stop") {
  MeasuredState state = state_at_rest();
  state.velocities[base_x] = 1.0;
  const auto stop = ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {0.0});
  // 0.05 m in the row, 0.1 m in the reaction; the front is 0.5 m ahead.
  CHECK(path_code(hall(0.65 + eps), stop, state) == 0);
  CHECK(path_code(hall(0.65 - eps), stop, state) == 34);
}

TEST_CASE("G034 a post on the way of braking backwards is not driven through") {
  Limits limits = hall(3.0);
  limits.base.footprint = square(0.01);
  limits.joints[base_x].acceleration_limit = 2.0;
  Zone post{"post", true, square(0.003)};
  for (Corner& corner : post.corners) corner[0] -= 0.2;
  (void)limits.base.zones.push_back(post);
  const auto code = [&](double speed) {
    return path_code(limits, ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {speed}));
  };
  CHECK(code(-1.0) == 34);  // at rest at -0.4 m
  CHECK(code(-0.4) == 0);   // at rest at -0.1 m
  CHECK(code(1.0) == 0);
}

TEST_CASE("G034 a corner that is out where the row leads, and neither before nor after that") {
  // From square to the wall by 45 degrees, where a corner is 0.70711 m ahead, and to rest at 90. A
  // 64th of the row before that it is 53 um less.
  const double eighth = std::acos(0.0) / 2.0;
  const auto code = [&](double right) {
    Limits limits = hall(right);
    limits.base.reaction_s = 0.0;
    limits.joints[base_yaw].velocity_limit = 20.0;
    limits.joints[base_yaw].acceleration_limit = std::pow(eighth / 0.05, 2) / (2.0 * eighth);
    return path_code(limits, ChunkBuilder().along(base, Mode::body_twist, 5, {eighth / 0.05}));
  };
  CHECK(code(0.70711) == 0);
  CHECK(code(0.70708) == 34);
}

TEST_CASE("G031 a joint that is measured to be faster than told stops at either speed's end") {
  Limits limits = free_arm::limits();
  for (const std::uint8_t j : {slide_x, slide_y}) limits.joints[j].acceleration_limit = 5.0;
  // Told 1 m/s ahead and 0.1 m/s aside. Aside it is measured at 1 m/s: 0.105 m, and 0.006 m as
  // slow as told. Ahead it stops at 0.15 m.
  ChunkBuilder chunk;
  Row speeds(6, 0.0);
  speeds[slide_x] = 1.0;
  speeds[slide_y] = 0.1;
  chunk.add(arm, Mode::joint_velocity, {speeds}, {slide_x, slide_y});
  const auto code = [&](double aside, double measured) {
    Limits posted = limits;
    (void)posted.workspace.volumes.push_back(
        {"post", true, {0.83, aside - 0.01, 0}, {0.87, aside + 0.01, 1}});
    MeasuredState state = at_rest();
    state.velocities[slide_x] = 1.0;
    state.velocities[slide_y] = measured;
    return judge_path(RobotModel(posted), whole_robot(posted), state, chunk.chunk, 0, 1, {}, {})
        .evidence.code;
  };
  CHECK(code(0.006, 1.0) == 31);
  CHECK(code(0.105, 1.0) == 31);
  CHECK(code(0.2, 1.0) == 0);
  CHECK(code(0.006, 0.1) == 31);
  CHECK(code(0.105, 0.1) == 0);
}

TEST_CASE("G031 what a held tick led to goes on for another, from wherever that was") {
  // At 1 m/s aside when it was measured, 50 mm a tick: held or not, and then not yet told.
  MeasuredState state = at_rest();
  state.velocities[slide_y] = 1.0;
  PartMemories memories;
  const RowBefore before{nullptr, 0, false, &memories};
  const ChunkBuilder chunk = one_joint(Mode::joint_velocity, slide_y, {0.0});
  const auto code = [&](double room) {
    Limits limits = free_arm::limits();
    (void)limits.workspace.volumes.push_back({"shelf", false, {-1, -1, 0}, {2, room, 1}});
    return judge_rows(limits, whole_robot(limits), state, chunk.chunk, 0, before).evidence.code;
  };
  CHECK(code(0.1 + eps) == 0);
  CHECK(code(0.1 - eps) == 31);
}
