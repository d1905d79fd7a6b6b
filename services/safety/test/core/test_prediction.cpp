// The prediction by itself: which joints and branches it carries, where rows take them and how
// fast, and what goes on before the first of them.

#include <doctest/doctest.h>

#include <cmath>

#include "core/kinematics/forward_kinematics.hpp"
#include "free_arm.hpp"
#include "predicted.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr std::uint8_t column = 1;

// The free arm with its first turn in a part of its own.
Limits on_a_column() {
  Limits limits = free_arm::limits();
  limits.parts[arm].joints.erase_at(0);
  PartLimits part = test::part("column", {turn_z});
  part.modes.joint_position = joint_mode({turn_z}, 0.25);
  widen(part);
  (void)limits.parts.push_back(part);
  limits.joints[turn_z].part = column;
  return limits;
}

ChunkBuilder& turn_column(ChunkBuilder& chunk, double target) {
  return chunk.add(column, Mode::joint_position, {{target, 0, 0, 0, 0, 0}}, {turn_z});
}

RowBefore not_measured(const ChunkBuilder& acts) {
  RowBefore before{&acts.chunk, 0};
  before.measured = false;
  return before;
}

}  // namespace

TEST_CASE("what moves: what the chunk commands, what acts still, and what is measured to move") {
  const ChunkBuilder own = one_joint(Mode::joint_position, slide_y, {0.1});
  const ChunkBuilder acts = one_joint(Mode::joint_velocity, slide_x, {1.0});
  const Predicted alone(free_arm::limits(), at_rest(), own.chunk);
  CHECK(alone.all.commanded() == only(slide_y));
  CHECK(alone.all.moving() == only(slide_y));
  CHECK(alone.all.lagging() == 0);
  CHECK(alone.all.branch_count() == 1);
  for (const bool measured : {true, false}) {
    RowBefore before{&acts.chunk, 0};
    before.measured = measured;
    const Predicted after(free_arm::limits(), at_rest(), own.chunk, before);
    CHECK(after.all.commanded() == only(slide_y));
    CHECK(after.all.moving() == (only(slide_x) | only(slide_y)));
    CHECK(after.all.lagging() == only(slide_x));
  }
  MeasuredState state = at_rest();
  state.velocities[turn_x] = just_below(0.05);  // at 0.05 rad/s it no longer stands
  CHECK(Predicted(free_arm::limits(), state, own.chunk).all.moving() == only(slide_y));
  for (const double speed : {0.05, -0.05}) {
    state.velocities[turn_x] = speed;
    const Predicted moving(free_arm::limits(), state, own.chunk);
    CHECK(moving.all.moving() == (only(slide_y) | only(turn_x)));
    CHECK(moving.all.branch(0).speed[turn_x] == speed);
  }
}

TEST_CASE("what moves: other claims' parts, which may hold instead") {
  ChunkBuilder own, other;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1, {0.1});
  two_arms::command(other, two_arms::right, Mode::joint_position, two_arms::right_1, {0.1});
  const auto predicted = [&](const Companion& companion) {
    const Predicted found(two_arms::limits(), two_arms::at_rest(), own.chunk, {},
                          Companions(&companion, 1));
    return std::pair(found.all.moving(), found.all.branch_count());
  };
  const JointSet both = only(two_arms::left_1) | only(two_arms::right_1);
  CHECK(predicted({}) == std::pair(only(two_arms::left_1), std::size_t{1}));
  CHECK(predicted({RowBefore{&other.chunk, 0}, nullptr, 0, 0}) == std::pair(both, std::size_t{2}));
  CHECK(predicted({{}, &other.chunk, 0, 1}) == std::pair(both, std::size_t{2}));
}

TEST_CASE(
    "the middle and both ends of the gain of each part that moves links; one that moves none goes "
    "along") {
  Limits limits = test_limits();
  limits.parts[arm].modes.joint_velocity.gain = {0.5, 1.0};
  limits.parts[base].modes.joint_velocity.gain = {0.25, 1.0};
  const auto speed = [](ChunkBuilder& chunk, std::uint8_t part, std::uint8_t joint) -> auto& {
    return chunk.joint(part, Mode::joint_velocity, joint, {1.0});
  };
  ChunkBuilder arm_only, base_only, both;
  speed(arm_only, arm, arm_1);
  speed(base_only, base, base_x);
  speed(speed(both, base, base_x), arm, arm_1);
  CHECK(Predicted(limits, state_at_rest(), arm_only.chunk).all.branch_count() == 3);
  CHECK(Predicted(limits, state_at_rest(), base_only.chunk).all.branch_count() == 3);
  Predicted predicted(limits, state_at_rest(), both.chunk, RowBefore{&both.chunk, 0});
  REQUIRE(predicted.all.branch_count() == 3);
  CHECK(predicted.all.start_count() == 0);
  CHECK(predicted.all.advance().ok());
  const Branch& forecast = predicted.all.branch(0);
  const Branch &lower = predicted.all.branch(1), &upper = predicted.all.branch(2);
  CHECK(forecast.now[arm_1] == doctest::Approx(0.0375));
  CHECK(forecast.now[base_x] == doctest::Approx(0.03125));
  CHECK(lower.now[arm_1] == doctest::Approx(0.025));
  CHECK(lower.now[base_x] == doctest::Approx(0.0125));
  CHECK(upper.now[arm_1] == doctest::Approx(0.05));
  CHECK(upper.now[base_x] == doctest::Approx(0.05));
  const Predicted acting(limits, state_at_rest(), both.chunk, not_measured(both));
  CHECK(acting.all.start_count() == 3);
  limits.parts[arm].modes.joint_velocity.gain = {1.0, 1.0};
  CHECK(Predicted(limits, state_at_rest(), arm_only.chunk).all.branch_count() == 1);
}

TEST_CASE("the gain is the claim's own") {
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.joint_velocity.gain = {0.5, 0.5};
  const RobotModel model(limits);
  ClaimLimits claim = whole_robot(limits);
  claim.modes[arm].joint_velocity.gain = {1.0, 1.0};
  const MeasuredState state = at_rest();
  const ChunkBuilder chunk = one_joint(Mode::joint_velocity, slide_x, {1.0});
  Prediction prediction(model, claim, state, chunk.chunk, 0, {}, {});
  CHECK(prediction.advance().ok());
  CHECK(prediction.branch(0).now[slide_x] == doctest::Approx(0.05));
}

TEST_CASE(
    "a tick before the first row: what was told a motion goes on, a target brakes from where it "
    "is") {
  const Limits limits = on_a_column();
  MeasuredState state = at_rest();
  state.velocities[slide_x] = 1.0;
  state.velocities[slide_y] = 0.25;  // nobody commands it
  state.velocities[turn_z] = 0.5;
  ChunkBuilder chunk = one_joint(Mode::joint_velocity, slide_x, {0.0});
  turn_column(chunk, 0.0);
  Predicted predicted(limits, state, chunk.chunk);
  Branch branch = predicted.all.measured();
  CHECK(predicted.all.is_coasting(branch));
  predicted.all.coast_one_tick(branch);
  CHECK(branch.now[slide_x] == doctest::Approx(0.05));
  CHECK(branch.now[slide_y] == 0.0);
  CHECK(branch.now[turn_z] == 0.0);
  CHECK(branch.speed[slide_x] == 1.0);
  CHECK(branch.speed[slide_y] == 0.25);
  CHECK(branch.speed[turn_z] == 0.5);
  const auto tool_x = [&](const FramePoses& poses) {
    return pose_at(predicted.model.tools[arm].place, poses).position.x();
  };
  CHECK(tool_x(branch.poses_before()) == doctest::Approx(0.7));
  CHECK(tool_x(branch.poses_now()) == doctest::Approx(0.75));
  state.velocities[slide_x] = state.velocities[turn_z] = 0.0;
  Predicted still(limits, state, chunk.chunk);
  CHECK_FALSE(still.all.is_coasting(still.all.measured()));
}

TEST_CASE("a tick before the first row begins where the row that acts leads") {
  const ChunkBuilder acts = one_joint(Mode::joint_velocity, slide_x, {1.0});
  const ChunkBuilder next = one_joint(Mode::joint_velocity, slide_x, {0.0});
  Predicted predicted(free_arm::limits(), at_rest(), next.chunk, not_measured(acts));
  Branch branch = predicted.all.branch(0);
  CHECK(predicted.all.is_coasting(branch));
  predicted.all.coast_one_tick(branch);
  CHECK(branch.before[slide_x] == doctest::Approx(0.05));
  CHECK(branch.now[slide_x] == doctest::Approx(0.1));
  const auto tool_x = [&](const FramePoses& poses) {
    return pose_at(predicted.model.tools[arm].place, poses).position.x();
  };
  CHECK(tool_x(branch.poses_before()) == doctest::Approx(0.75));
  CHECK(tool_x(branch.poses_now()) == doctest::Approx(0.8));
}

TEST_CASE("a delta that acts already begins where the robot is measured") {
  MeasuredState state = at_rest();
  state.positions[turn_z] = std::acos(0.0);
  const auto acts = ChunkBuilder().along(arm, Mode::cartesian_delta, 1, {0.04});
  const ChunkBuilder next = one_joint(Mode::joint_velocity, slide_x, {0.0});
  const Predicted predicted(free_arm::limits(), state, next.chunk, not_measured(acts));
  CHECK(predicted.all.branch(0).before[slide_x] == 0.0);
  CHECK(predicted.all.branch(0).now[slide_x] == doctest::Approx(0.04).epsilon(1e-2));
}

TEST_CASE("a pose is reached from where the same row carries the arm, whoever is told first") {
  const double turned = 0.1;
  ChunkBuilder chunk;
  chunk.poses(arm, {{0.7, 0, 0.5, 0, 0, std::sin(0.05), std::cos(0.05)}});
  turn_column(chunk, turned);
  Predicted predicted(on_a_column(), at_rest(), chunk.chunk);
  const Branch& branch = predicted.after_a_row();
  CHECK(branch.now[turn_z] == turned);
  // Ahead of a column that looks 0.1 rad to the left, the pose is to its right.
  CHECK(branch.now[slide_x] == doctest::Approx(0.7 * std::cos(0.1) - 0.7).epsilon(1e-4));
  CHECK(branch.now[slide_y] == doctest::Approx(-0.7 * std::sin(0.1)).epsilon(1e-4));
}

TEST_CASE("a pose told in a frame that moves in the same row is told where that frame gets to") {
  ChunkBuilder chunk;
  chunk.add(arm, Mode::cartesian_pose, {{0.72, 0, 0.5, 0, 0, 0, 1}}, {}, "column");
  turn_column(chunk, 0.1);
  Predicted predicted(on_a_column(), at_rest(), chunk.chunk);
  const Branch& branch = predicted.after_a_row();
  CHECK(branch.now[slide_x] == doctest::Approx(0.02).epsilon(1e-4));
  CHECK(std::abs(branch.now[slide_y]) < 1e-6);
}

TEST_CASE("a delta told in a frame that is turned goes along that frame's axes") {
  MeasuredState state = at_rest();
  state.positions[turn_z] = std::acos(0.0);
  const auto after = [&](const Row& row) {
    const auto chunk = ChunkBuilder().add(arm, Mode::cartesian_delta, {row}, {}, "column");
    return Predicted(free_arm::limits(), state, chunk.chunk).after_a_row().now;
  };
  CHECK(after({0.04, 0, 0, 0, 0, 0})[slide_x] == doctest::Approx(0.04).epsilon(1e-2));
  CHECK(after({0, 0, 0, 0.04, 0, 0})[turn_x] == doctest::Approx(0.04).epsilon(1e-2));
  CHECK(after({0, 0, 0, 0, 0.04, 0})[turn_y] == doctest::Approx(0.04).epsilon(1e-2));
}

TEST_CASE("a turn about an origin that is not on the yaw axis: the slides make up for it") {
  Limits limits = test_limits();
  limits.base.yaw_axis = {0.0, 0.5};
  limits.parts[base].modes.body_twist.gain = {1.0, 1.0};
  const auto chunk = ChunkBuilder().along(base, Mode::body_twist, 5, {1.2});  // 0.06 rad
  Predicted predicted(limits, state_at_rest(), chunk.chunk);
  const Branch& branch = predicted.after_a_row();
  CHECK(branch.now[base_yaw] == doctest::Approx(0.06));
  // The axis, 0.5 m to the left, turns about the origin: 30 mm back, 0.9 mm to the right.
  CHECK(branch.now[base_x] == doctest::Approx(-0.03).epsilon(1e-3));
  CHECK(branch.now[base_y] == doctest::Approx(-0.0009).epsilon(1e-2));
}

TEST_CASE("G030 says the first of several parts that get nowhere") {
  ChunkBuilder chunk;
  chunk.poses(two_arms::left, {{3.0, 0.3, 0.0, 0.0, 0.0, 0.0, 1.0}});
  chunk.poses(two_arms::right, {{3.0, -0.3, 0.0, 0.0, 0.0, 0.0, 1.0}});
  Predicted predicted(two_arms::limits(), two_arms::at_rest(), chunk.chunk);
  const Evidence fault = predicted.all.advance();
  CHECK(fault.code == 30);
  CHECK(fault.part == "left_arm");
}

namespace {

// A delta told to the free arm when only one of its joints is left to make it.
Evidence told_to(std::uint8_t joint, const Row& delta) {
  Limits limits = free_arm::limits();
  limits.parts[arm].joints.clear();
  (void)limits.parts[arm].joints.push_back(joint);
  const auto chunk = ChunkBuilder().add(arm, Mode::cartesian_delta, {delta}, {}, "base_link");
  return Predicted(limits, at_rest(), chunk.chunk).all.advance();
}

}  // namespace

TEST_CASE("a motion that the joints cannot make at all is missed by its size, however large") {
  CHECK(told_to(slide_x, {0, 0, 0.1, 0, 0, 0}).ok());
  CHECK(told_to(slide_x, {0, 0, 1e8, 0, 0, 0}).ok());
}

TEST_CASE("G030 a step that takes the tool further from where it has to be, by however little") {
  // The tool turns on a circle of 0.7 m and is told to be 9 m outside. There straight ahead is
  // best; a little to the left the step goes 4.5 times too far, and ends micrometres further away.
  CHECK(told_to(turn_z, {9, 0, 0, 0, 0, 0}).ok());
  const Evidence fault = told_to(turn_z, {9, 0.002, 0, 0, 0, 0});
  CHECK(fault.code == 30);
  CHECK(fault.margin < 0.0);
  CHECK(fault.margin > -1e-4);
}
