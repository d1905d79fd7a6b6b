// What a prediction makes of rows besides its own, of what is measured beside what is told, and of
// where a row begins.

#include <doctest/doctest.h>

#include <cmath>

#include "free_arm.hpp"
#include "predicted.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// A base that needs 0.1 m along y to brake from 1 m/s.
Limits coasting_base() {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_velocity.gain = {1.0, 1.0};
  limits.base.reaction_s = 1e-9;
  limits.joints[base_y].acceleration_limit = 5.0;
  return limits;
}

const ChunkBuilder still = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, Row(4, 0.0));

// Where another claim's rows of 1 m/s have taken the base after each row of the arm's.
std::vector<double> carried_by(const Companion& companion, std::size_t rows) {
  Predicted predicted(coasting_base(), state_at_rest(), still.chunk, {}, Companions(&companion, 1));
  std::vector<double> places;
  for (std::size_t row = 0; row < rows; ++row)
    places.push_back(predicted.after_a_row().now[base_y]);
  return places;
}

void check_places(const std::vector<double>& places, const std::vector<double>& expected) {
  REQUIRE(places.size() == expected.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    CAPTURE(i);
    CHECK(places[i] == doctest::Approx(expected[i]));
  }
}

// What the first row makes of the first slide of the free arm, told to go on at a speed from where
// it is told to be already.
struct FirstRow {
  FirstRow(double measured, double told) {
    MeasuredState state = free_arm::at_rest();
    state.velocities[free_arm::slide_x] = measured;
    const ChunkBuilder chunk =
        free_arm::one_joint(Mode::joint_position, free_arm::slide_x, {told * 0.05});
    Predicted predicted(free_arm::limits(), state, chunk.chunk);
    const Branch& branch = predicted.after_a_row();  // a copy forgets what is slowing
    speed = branch.speed[free_arm::slide_x];
    slowing = branch.slowing;
  }
  double speed;
  JointSet slowing;
};

}  // namespace

TEST_CASE("what another claim's rows tell goes on until its last row, then brakes to rest") {
  const ChunkBuilder others = ChunkBuilder().joint(base, Mode::joint_velocity, base_y, Row(4, 1.0));
  check_places(carried_by({{}, &others.chunk, 0, 3}, 4), {0.05, 0.1, 0.15, 0.25});
  check_places(carried_by({{}, &others.chunk, 0, 2}, 3), {0.05, 0.1, 0.2});
  check_places(carried_by({{}, &others.chunk, 0, 1}, 3), {0.05, 0.15, 0.15});
  check_places(carried_by({{}, &others.chunk, 2, 4}, 3), {0.05, 0.1, 0.2});
}

TEST_CASE("another claim of which only the row before is left tells nothing any more") {
  const ChunkBuilder others = ChunkBuilder().joint(base, Mode::joint_velocity, base_y, Row(4, 1.0));
  check_places(carried_by({RowBefore{&others.chunk, 0}, nullptr, 0, 0}, 2), {0.0, 0.0});
}

TEST_CASE("a base is as fast as in any certified row; later as in the newest and the one before") {
  Limits limits = coasting_base();
  const ChunkBuilder chunk =
      ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {0.9, 0.6, 0.3, 0.0, 0.0, 0.0});
  Predicted predicted(limits, state_at_rest(), chunk.chunk);
  for (const double expected : {0.9, 0.9, 0.9, 0.9}) {
    (void)predicted.after_a_row();
    CHECK(predicted.all.base_speed() == doctest::Approx(expected / 1.5));
  }
  predicted.all.only_forecast();
  for (const double expected : {0.0, 0.0}) {
    (void)predicted.after_a_row();
    CHECK(predicted.all.base_speed() == doctest::Approx(expected / 1.5));
  }
}

TEST_CASE(
    "in its first row a joint may still be as fast as measured, in the direction it is told") {
  const auto speed = [](double measured, double told) { return FirstRow(measured, told).speed; };
  for (const double way : {1.0, -1.0}) {
    CHECK(speed(0.5 * way, 0.2 * way) == 0.5 * way);
    CHECK(speed(0.1 * way, 0.2 * way) == doctest::Approx(0.2 * way));
    CHECK(speed(-0.5 * way, 0.2 * way) == doctest::Approx(0.2 * way));
    // Told to be where it is, it is told no way.
    CHECK(speed(0.5 * way, 0.0) == 0.0);
  }
}

TEST_CASE("a joint that is measured exactly as fast as told slows down from nothing") {
  for (const double way : {1.0, -1.0}) {
    const FirstRow same(0.5 * way, 0.5 * way);
    CHECK(same.speed == 0.5 * way);
    CHECK(same.slowing == 0);
    CHECK(FirstRow(0.75 * way, 0.5 * way).slowing == only(free_arm::slide_x));
    CHECK(FirstRow(0.25 * way, 0.5 * way).slowing == 0);
    CHECK(FirstRow(0.5 * way, 0.0).slowing == 0);
  }
}

TEST_CASE("a branch as slow as told has the same ends of the row, and the speed it is told") {
  const Limits limits = free_arm::limits();
  MeasuredState state = free_arm::at_rest();
  state.velocities[free_arm::slide_x] = 1.0;
  const ChunkBuilder chunk = free_arm::one_joint(Mode::joint_position, free_arm::slide_x, {0.025});
  Predicted predicted(limits, state, chunk.chunk);
  const Branch& fast = predicted.after_a_row();
  REQUIRE(fast.slowing == only(free_arm::slide_x));
  const Branch slow = fast.slowed();
  CHECK(slow.speed[free_arm::slide_x] == doctest::Approx(0.5));
  CHECK(slow.before == fast.before);
  CHECK(slow.now == fast.now);
  const ModelPlace& tool = predicted.model.tools[arm].place;
  const auto ahead = [&](const FramePoses& poses) { return pose_at(tool, poses).position.x(); };
  CHECK(ahead(slow.poses_before()) == doctest::Approx(0.7));
  CHECK(ahead(slow.poses_now()) == doctest::Approx(0.725));
}

TEST_CASE("what slides leaves open as much as the turn that takes the arm as far, however short") {
  // 25 to 50 mm of a row; a tool 1.7 m from its column when it rests, or 0.4 m. Its slides add
  // 0.1 m each.
  for (const double scale : {2.0, 0.5}) {
    Limits limits = free_arm::limits();
    limits.parts[arm].modes.joint_velocity.gain = {0.5, 1.0};
    for (const std::size_t j : {free_arm::slide_x, free_arm::slide_y, free_arm::slide_z})
      limits.joints[j].bounds = {-0.1, 0.1, 0.0};
    for (Capsule& capsule : limits.collision.capsules) capsule.a = capsule.b = {0, 0, 0};
    for (Link& link : limits.kinematics.links)
      for (double& number : link.translation) number *= scale;
    const ChunkBuilder chunk =
        free_arm::one_joint(Mode::joint_velocity, free_arm::slide_x, {1.0, 0.0});
    Predicted predicted(limits, free_arm::at_rest(), chunk.chunk);
    (void)predicted.after_a_row();
    CHECK(predicted.all.interval_width(arm) == 0.0);
    (void)predicted.after_a_row();
    const double reach = predicted.model.tools[arm].reach;
    CHECK(reach == doctest::Approx(std::hypot(0.7, 0.5) * scale + 3 * 0.1));
    CHECK(predicted.all.interval_width(arm) == doctest::Approx(0.025 / reach));
  }
}
