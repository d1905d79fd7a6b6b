// G034: the base of the test robot, a square of 1 m about its origin. Rows last 0.05 s, all that is
// asked for happens, and after a reaction of 0.1 s it brakes at 1e18, but where a test says.

#include <doctest/doctest.h>

#include <cmath>

#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double eps = 1e-9;

FixedVec<Corner, max_corners> corners(std::initializer_list<Corner> points) {
  FixedVec<Corner, max_corners> shape;
  for (const Corner& point : points) (void)shape.push_back(point);
  return shape;
}

// A hall from (-2, -2) to (right, 2).
Limits hall(double right) {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_velocity.gain = {1.0, 1.0};
  limits.parts[base].modes.body_twist.gain = {1.0, 1.0};
  limits.base.zones[0] = {"hall", false, corners({{-2, -2}, {right, -2}, {right, 2}, {-2, 2}})};
  return limits;
}

Judgement drive(const Limits& limits, const ChunkBuilder& chunk,
                const MeasuredState& state = state_at_rest()) {
  return judge_rows(limits, whole_robot(limits), state, chunk.chunk, 0, {});
}

ChunkBuilder twist(std::size_t axis, const Row& values) {
  return ChunkBuilder().along(base, Mode::body_twist, axis, values);
}

ChunkBuilder slide(std::uint8_t joint, const Row& values) {
  return ChunkBuilder().joint(base, Mode::joint_velocity, joint, values);
}

MeasuredState at(double x, double y, double yaw) {
  MeasuredState state = state_at_rest();
  state.positions[base_x] = x;
  state.positions[base_y] = y;
  state.positions[base_yaw] = yaw;
  return state;
}

}  // namespace

TEST_CASE("G034 every corner stays inside: the row, the reaction, and braking") {
  // At 1 m/s: 0.05 m in the row, 0.1 m in the reaction; the front is 0.5 m ahead.
  CHECK(drive(hall(0.65 + eps), twist(0, {1.0})).evidence.ok());
  CHECK(drive(hall(0.65 + eps), slide(base_x, {1.0})).evidence.ok());
  CHECK(drive(hall(0.65 - eps), slide(base_x, {1.0})).evidence.code == 34);
  const Limits narrow = hall(0.6);  // evidence points into it
  const Judgement refused = drive(narrow, twist(0, {1.0}));
  CHECK(refused.outcome == Outcome::refused);
  CHECK(refused.evidence.code == 34);
  CHECK(refused.evidence.part == "base");
  CHECK(refused.evidence.axis == "hall");
  CHECK(refused.evidence.value == doctest::Approx(-0.05));
  CHECK(refused.evidence.limit == 0.0);
  CHECK(refused.evidence.unit == "m");
  CHECK(refused.evidence.limit_source == "test base");
  Limits limits = hall(0.9 + eps);
  limits.joints[base_x].acceleration_limit = 2.0;  // and 0.25 m to brake
  CHECK(drive(limits, twist(0, {1.0})).evidence.ok());
  limits.base.zones[0].corners[1][0] = limits.base.zones[0].corners[2][0] = 0.9 - eps;
  CHECK(drive(limits, twist(0, {1.0})).evidence.code == 34);
  const Judgement cut = drive(hall(0.71), twist(0, {1.0, 1.0, 1.0}));
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.row_count == 2);
}

TEST_CASE("G034 a twist is told in the base, a slide in odom: the measured yaw turns it") {
  const double half_pi = std::acos(0.0);
  CHECK(drive(hall(0.6), twist(0, {1.0}), at(0, 0, half_pi)).evidence.ok());  // along y
  CHECK(drive(hall(0.6), twist(1, {-1.0}), at(0, 0, half_pi)).evidence.code == 34);
  CHECK(drive(hall(0.6), slide(base_x, {1.0}), at(0, 0, half_pi)).evidence.code == 34);
}

TEST_CASE("G034 slides told against the yaw: x at a quarter turn drives towards minus y") {
  const double half_pi = std::acos(0.0);
  Limits limits = hall(9.0);
  limits.base.against_yaw = true;
  limits.base.zones[0].corners = corners({{-0.6, -0.6}, {0.6, -0.6}, {0.6, 5}, {-0.6, 5}});
  CHECK(drive(limits, slide(base_x, {1.0}), at(0, 0, half_pi)).evidence.code == 34);
  CHECK(drive(limits, slide(base_x, {-1.0}), at(0, 0, half_pi)).evidence.ok());
  CHECK(drive(limits, slide(base_y, {1.0}), at(0, 0, half_pi)).evidence.code == 34);  // +x
  CHECK(drive(limits, slide(base_y, {1.0}), at(0, 0, 0)).evidence.ok());
  limits.base.against_yaw = false;
  CHECK(drive(limits, slide(base_x, {-1.0}), at(0, 0, half_pi)).evidence.code == 34);
  CHECK(drive(limits, slide(base_y, {1.0}), at(0, 0, half_pi)).evidence.ok());
}

TEST_CASE(
    "G034 slides told against the yaw: one may get what was told to both, and brakes from it") {
  // At 45 degrees a corner is 0.7071 m ahead; 1.4142 m/s for a row and the reaction: 0.2121 m.
  const ChunkBuilder both =
      ChunkBuilder().add(base, Mode::joint_velocity, {{1.0, 1.0, 0, 0, 0, 0}}, {base_x, base_y});
  for (const double right : {0.90, 0.93}) {
    Limits limits = hall(right);
    limits.base.against_yaw = true;
    for (const std::size_t j : {base_x, base_y}) limits.joints[j].velocity_limit = 1.0;
    CHECK(drive(limits, both, at(0, 0, 0.7854)).evidence.code == (right < 0.919 ? 34 : 0));
  }
}

TEST_CASE("G021 a base told against its yaw goes on at what its slides are measured to do") {
  const double half_pi = std::acos(0.0);
  Limits limits = hall(9.0);
  limits.parts[base].modes.joint_velocity.step_limit[base_x] = 0.25;
  limits.parts[base].modes.joint_velocity.step_limit[base_y] = 0.25;
  MeasuredState state = at(0, 0, half_pi);
  state.velocities[base_y] = -1.0;
  const ChunkBuilder both =
      ChunkBuilder().add(base, Mode::joint_velocity, {{1.0, 0, 0, 0, 0, 0}}, {base_x, base_y});
  CHECK(drive(limits, both, state).evidence.code == 21);
  limits.base.against_yaw = true;
  CHECK(drive(limits, both, state).evidence.ok());
  state.velocities[base_y] = 1.0;
  CHECK(drive(limits, both, state).evidence.code == 21);
}

TEST_CASE("G034 a turn swings the corners out, about the yaw axis") {
  // At 45 degrees a corner is 0.7071 m ahead.
  CHECK(drive(hall(0.72), twist(5, {1.5}), at(0, 0, 0.7)).evidence.ok());
  CHECK(drive(hall(0.70), twist(5, {1.5}), at(0, 0, 0.5)).evidence.code == 34);
  // Between two rows as well: from 42 to 49 degrees.
  Limits narrow = hall(0.7071);
  narrow.base.reaction_s = 0.0;
  narrow.joints[base_yaw].velocity_limit = 3.0;
  narrow.parts[base].modes.body_twist.angular_limit = 3.0;
  narrow.parts[base].modes.body_twist.angular_step_limit = 3.0;
  CHECK(drive(narrow, twist(5, {2.4}), at(0, 0, 0.725)).evidence.code == 34);
  // An axis 1 m behind the origin: a turn on the spot is asked for, the slides make up for it.
  Limits behind = hall(0.75);
  behind.base.yaw_axis = {-1.0, 0.0};
  CHECK(drive(behind, twist(5, {1.5}), at(0, 0, 0.0)).evidence.ok());
  CHECK(drive(behind, slide(base_yaw, {1.5}), at(0, 0, -1.5)).evidence.ok());
  Limits ahead = hall(0.6);
  ahead.base.yaw_axis = {-1.0, 0.0};
  ahead.base.zones[0].corners = corners({{-3, -3}, {2, -3}, {2, 0.6}, {-3, 0.6}});
  // A pure yaw swings the front left corner about the axis: by 1.5 m times 0.225 rad.
  CHECK(drive(ahead, slide(base_yaw, {1.5})).evidence.code == 34);
}

TEST_CASE("G034 a keep-out zone is not touched, not even by an edge") {
  Limits limits = hall(5.0);
  (void)limits.base.zones.push_back(
      {"stairs", true, corners({{0.65, 0.0}, {2.0, -0.2}, {2.0, 0.2}})});
  CHECK(drive(limits, slide(base_x, {1.0 - eps})).evidence.ok());
  CHECK(drive(limits, slide(base_x, {1.0 + eps})).evidence.code == 34);
  limits.base.zones[1].corners[0][0] = 0.65 - eps;
  CHECK(drive(limits, slide(base_x, {1.0})).evidence.code == 34);
  CHECK(drive(limits, slide(base_x, {1.0})).evidence.axis == "stairs");
  CHECK(drive(limits, slide(base_y, {1.0})).evidence.ok());
  CHECK(drive(limits, slide(base_x, {-1.0})).evidence.ok());
}

TEST_CASE("G034 a post between two rows is not driven through") {
  Limits limits = hall(9.0);
  limits.base.footprint = corners({{-0.01, -0.01}, {0.01, -0.01}, {0.01, 0.01}, {-0.01, 0.01}});
  limits.base.reaction_s = 0.0;
  (void)limits.base.zones.push_back(
      {"post", true, corners({{0.035, -0.1}, {0.04, -0.1}, {0.04, 0.1}, {0.035, 0.1}})});
  limits.joints[base_x].velocity_limit = 3.0;
  const auto code = [&](double velocity) {
    return drive(limits, slide(base_x, {velocity})).evidence.code;
  };
  CHECK(code(0.4) == 0);
  CHECK(code(1.4) == 34);  // 7 cm on, behind the post
}

TEST_CASE("G034 outside already: back or nowhere") {
  const Limits limits = hall(0.4);
  CHECK(drive(limits, slide(base_x, {0.0})).evidence.ok());
  CHECK(drive(limits, slide(base_x, {-1.0, -1.0, -1.0})).evidence.ok());
  CHECK(drive(limits, slide(base_x, {0.01})).evidence.code == 34);
  CHECK(drive(limits, slide(base_y, {1.0})).evidence.ok());
}

TEST_CASE("G034 numbers that are none refuse, and a base that nobody declared") {
  for (const double bad : {not_a_number, infinite}) {
    Limits limits = hall(3.0);
    limits.base.zones[0].corners[1][0] = bad;
    CHECK(drive(limits, slide(base_x, {0.1})).evidence.code == 34);
    limits = hall(3.0);
    limits.base.reaction_s = bad;
    CHECK(drive(limits, slide(base_x, {0.1})).evidence.code == 34);
  }
  Limits limits = hall(3.0);
  limits.base = BaseLimits{};
  CHECK(drive(limits, twist(0, {0.1})).evidence.code == 30);
}

TEST_CASE("G034 what does not command the base is not asked") {
  const Limits limits = hall(0.1);
  CHECK(drive(limits, ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.1})).evidence.ok());
}

TEST_CASE("G034 a yaw and a body twist mean the same whether slides are told against the yaw") {
  for (const bool against_yaw : {false, true}) {
    Limits limits = hall(0.70);
    limits.base.against_yaw = against_yaw;
    CHECK(drive(limits, slide(base_yaw, {1.5}), at(0, 0, 0.5)).evidence.code == 34);
    CHECK(drive(limits, twist(5, {1.5}), at(0, 0, 0.5)).evidence.code == 34);
    CHECK(drive(limits, slide(base_yaw, {-1.5}), at(0, 0, 0.5)).evidence.ok());
  }
}

TEST_CASE("G034 a post on the way of braking is not driven through") {
  Limits limits = hall(9.0);
  limits.base.footprint = corners({{-0.01, -0.01}, {0.01, -0.01}, {0.01, 0.01}, {-0.01, 0.01}});
  limits.joints[base_x].acceleration_limit = 2.0;
  // 0.05 m in the row, 0.1 m in the reaction, 0.25 m to brake: it rests at 0.4 m.
  (void)limits.base.zones.push_back(
      {"post", true, corners({{0.2, -0.1}, {0.205, -0.1}, {0.205, 0.1}, {0.2, 0.1}})});
  CHECK(drive(limits, slide(base_x, {1.0})).evidence.code == 34);
  CHECK(drive(limits, slide(base_x, {0.4})).evidence.ok());  // at rest at 0.1 m
  Zone& post = limits.base.zones[1];
  for (Corner& corner : post.corners) corner[0] += 0.25;  // behind where it rests
  CHECK(drive(limits, slide(base_x, {1.0})).evidence.ok());
}

TEST_CASE("G034 a post is not driven through where one slide brakes sooner than the other") {
  Limits limits = hall(9.0);
  limits.base.footprint =
      corners({{-0.005, -0.005}, {0.005, -0.005}, {0.005, 0.005}, {-0.005, 0.005}});
  limits.base.reaction_s = 0.0;
  limits.joints[base_x].acceleration_limit = 3.75;  // 1.5 m/s: 0.3 m in 0.4 s
  limits.joints[base_y].acceleration_limit = 0.15;  // 0.3 m/s: 0.3 m in 2 s
  const ChunkBuilder both =
      ChunkBuilder().add(base, Mode::joint_velocity, {{1.5, 0.3, 0, 0, 0, 0}}, {base_x, base_y});
  CHECK(drive(limits, both).evidence.ok());
  // The row ends at (0.075, 0.015), braking at (0.375, 0.315). When x has stopped, y has gone
  // 0.3 * 0.4 - 0.15 * 0.4 * 0.4 / 2 = 0.108 m further: around a corner, far from the straight way.
  (void)limits.base.zones.push_back(
      {"post", true, corners({{0.37, 0.118}, {0.38, 0.118}, {0.38, 0.128}, {0.37, 0.128}})});
  CHECK(drive(limits, both).evidence.code == 34);
  for (Corner& corner : limits.base.zones[1].corners) corner[0] += 0.02;
  CHECK(drive(limits, both).evidence.ok());
}

TEST_CASE("G034 a base that slows down as told stops short of where it would as fast as measured") {
  // Ahead at 1 m/s when measured, told half of that and as much aside: from (25, 25) mm it stops
  // another (25, 25) on, or (100, 25), past a post.
  const auto code = [](double post) {
    Limits limits = test_limits();
    limits.parts[base].modes.joint_velocity.gain = {1.0, 1.0};
    for (const std::size_t j : {base_x, base_y}) limits.joints[j].acceleration_limit = 5.0;
    limits.base.reaction_s = 1e-9;
    limits.base.footprint = square(1e-9);
    Zone zone{"post", true, square(0.01)};
    for (auto& corner : zone.corners) corner = {corner[0] + 0.05, corner[1] + post + 0.01};
    (void)limits.base.zones.push_back(zone);
    MeasuredState state = state_at_rest();
    state.velocities[base_x] = 1.0;
    Row row(joint_count, 0.0);
    row[base_x] = row[base_y] = 0.5;
    ChunkBuilder chunk;
    chunk.add(base, Mode::joint_velocity, {row}, {base_x, base_y});
    return judge_rows(limits, whole_robot(limits), state, chunk.chunk, 0, {}).evidence.code;
  };
  CHECK(code(0.05 + 1e-6) == 0);
  CHECK(code(0.05 - 1e-6) == 34);
}
