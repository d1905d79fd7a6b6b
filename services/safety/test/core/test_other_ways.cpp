// The ways of a tool's joints depend on where they start, which nobody knows of an arm that moved
// when it was measured and held in the tick that runs. Of rows of which any share may happen tells
// test_other_shares.cpp.

#include <doctest/doctest.h>

#include <cmath>
#include <utility>

#include "free_arm.hpp"
#include "predicted.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr double way = 0.05;  // ahead, in a row

// Nothing has a row in the tick that runs.
const PartMemories nothing_moved;
const RowBefore held{nullptr, 0, false, &nothing_moved};

// The column turned at 1 rad/s: it is anywhere up to 50 mrad on, half way there by the branches.
struct Turning {
  explicit Turning(double speed) : state(at_rest()) { state.velocities[turn_z] = speed; }

  static ChunkBuilder ahead(std::size_t rows) {
    return ChunkBuilder().add(arm, Mode::cartesian_delta, Rows(rows, {way, 0, 0, 0, 0, 0}), {},
                              "base_link");
  }

  MeasuredState state;
};

}  // namespace

TEST_CASE(
    "a tool's joints are off by as much as their ways differ by where they start, row by row") {
  for (const double side : {1.0, -1.0}) {
    const Turning arm_turns(side);
    const ChunkBuilder chunk = Turning::ahead(2);
    Predicted predicted(free_arm::limits(), arm_turns.state, chunk.chunk, held);
    const Branch& branch = predicted.after_a_row();
    // Of the slides, which turn with the column; not of the column, which turns no more.
    const double aside = way * std::sin(0.025), at_end = way * std::sin(0.05);
    const double off = std::max(at_end - aside, aside);
    CHECK(predicted.all.start_off()[slide_y] == about(off));
    CHECK(predicted.all.start_off()[turn_z] == about(0.025));
    CHECK(-side * branch.speed[slide_y] == about((aside + off) / 0.05));
    CHECK(branch.slowing != 0);
    const Interval& interval = predicted.all.interval();
    CHECK(interval.highest[slide_y] - interval.lowest[slide_y] == about(2.0 * off));
    (void)predicted.after_a_row();
    CHECK(predicted.all.start_off()[slide_y] >= 1.9 * off);
  }
}

TEST_CASE("of the least of a row joints are off by its share of what they are of the most") {
  const auto width = [](double lower) {
    Limits limits = free_arm::limits();
    limits.parts[arm].modes.cartesian_delta.gain = {lower, 1.0};
    const ChunkBuilder chunk = Turning::ahead(1);
    Predicted predicted(limits, Turning(1.0).state, chunk.chunk, held);
    (void)predicted.after_a_row();
    const Interval& interval = predicted.all.interval();
    return std::pair(-interval.lowest[slide_y], interval.highest[slide_y]);
  };
  // All of it, either way; and of nothing, nothing.
  const double aside = way * std::sin(0.025), off = aside;
  CHECK(width(1.0).first == about(aside + off));
  CHECK(width(0.0).first == about(aside + off));
  CHECK(width(1.0).second == about(off - aside));
  CHECK(width(0.0).second == about(off));
}

TEST_CASE("an arm that stands, or of which every row is known, is where its branches are") {
  const Turning arm_stands(0.0);
  const ChunkBuilder chunk = Turning::ahead(1);
  Predicted still(free_arm::limits(), arm_stands.state, chunk.chunk, held);
  (void)still.after_a_row();
  CHECK_FALSE(still.all.is_start_off());
  CHECK(still.all.start_off()[slide_y] == 0.0);
  const Turning arm_turns(1.0);
  Predicted known(free_arm::limits(), arm_turns.state, chunk.chunk);
  const Branch& branch = known.after_a_row();
  CHECK(known.all.start_off()[slide_y] == 0.0);
  CHECK(branch.speed[slide_y] == about(0.0));
}

TEST_CASE("G026 a joint is as fast as from wherever the tool may start") {
  const auto code = [](double fastest) {
    Limits limits = free_arm::limits();
    limits.joints[slide_y].velocity_limit = fastest;
    const Turning arm_turns(1.0);
    const ChunkBuilder chunk = Turning::ahead(1);
    return judge_rows(limits, whole_robot(limits), arm_turns.state, chunk.chunk, 0, held)
        .evidence.code;
  };
  CHECK(code(1.01 * std::sin(0.05)) == 0);
  CHECK(code(0.99 * std::sin(0.05)) == 26);
}

namespace {

constexpr std::uint8_t slide_on = 6;  // a second slide ahead, of an arm of seven joints

Limits of_seven() {
  Limits limits = free_arm::limits();
  (void)limits.joints.push_back(joint("slide_on", arm, JointKind::prismatic, true));
  Kinematics& tree = limits.kinematics;
  tree.links[tree.links.size() - 1].name = "wrist_2";
  (void)tree.links.push_back(
      link("tool", tree.links.size() - 1, LinkMotion::slide, slide_on, {1, 0, 0}, {0, 0, 0}));
  PartLimits& part = limits.parts[arm];
  (void)part.joints.push_back(slide_on);
  part.tool = tree.links.size() - 1;
  limits.collision = wide_shape(0, part.tool);
  return limits;
}

}  // namespace

TEST_CASE("what of its start seven joints keep that reach a pose is no longer than all of it") {
  for (const bool redundant : {true, false}) {
    CAPTURE(redundant);
    MeasuredState state = at_rest();
    state.count = redundant ? 7 : 6;
    state.velocities[slide_x] = 0.8;
    state.velocities[slide_y] = -0.6;
    ChunkBuilder chunk;
    chunk.poses(arm, {{0.75, 0, 0.5, 0, 0, 0, 1}, {0.75, 0, 0.5, 0, 0, 0, 1}});
    Predicted predicted(redundant ? of_seven() : free_arm::limits(), state, chunk.chunk, held);
    const auto room = [&](std::size_t j) {
      const Interval& interval = predicted.all.interval();
      return interval.highest[j] - interval.lowest[j];
    };
    CHECK(predicted.all.start_off()[slide_x] == about(redundant ? 0.025 : 0.02));
    CHECK(predicted.all.start_off()[slide_z] == about(redundant ? 0.025 : 0.0));
    for (int row = 0; row < 2; ++row) {
      (void)predicted.after_a_row();
      CHECK(room(slide_x) == about(redundant ? 0.05 : 0.0));
      CHECK(room(slide_z) == about(redundant ? 0.05 : 0.0));
    }
    CHECK(predicted.all.start_off()[slide_x] == about(redundant ? 0.025 : 0.0));
  }
}

TEST_CASE("a joint that counts as standing may go on: it may get to a target faster from there") {
  const Limits limits = free_arm::limits();
  const double creeping = 0.9 * limits.joints[slide_x].standstill_velocity;
  const auto speed = [&](bool velocity_stuck, double measured, double target,
                         const RowBefore& before) {
    MeasuredState state = at_rest();
    (velocity_stuck ? state.travel_speeds : state.velocities)[slide_x] = measured;
    const ChunkBuilder rows = one_joint(Mode::joint_position, slide_x, {target, 2.0 * target});
    Predicted predicted(limits, state, rows.chunk, before);
    CHECK_FALSE(predicted.all.is_start_off());
    const double first = predicted.after_a_row().speed[slide_x];
    CHECK(predicted.all.branch(0).now[slide_x] == target);
    CHECK(predicted.after_a_row().speed[slide_x] == about(target / 0.05));
    return first;
  };
  for (const bool velocity_stuck : {true, false})
    for (const double side : {1.0, -1.0}) {
      // Either way, as it may be measured wrongly; but by no more than the row moves it.
      CHECK(speed(velocity_stuck, creeping, side * 0.05, held) == about(side * (1.0 + creeping)));
      CHECK(speed(velocity_stuck, creeping, side * 0.0015, held) == about(side * 0.06));
      CHECK(speed(velocity_stuck, side * creeping, 0.0, held) == 0.0);
      // In lockstep it is where it is measured.
      CHECK(speed(velocity_stuck, creeping, side * 0.05, {}) == about(side));
    }
}

TEST_CASE("G024 a target where a joint stands is not refused for noise, at a bound neither") {
  Limits limits = free_arm::limits();
  limits.joints[slide_x].bounds = {0.0, 1.0, 0.01};
  limits.joints[slide_x].acceleration_limit = 0.1;
  MeasuredState state = at_rest();
  for (const double noise : {1e-6, -1e-6, 0.9, -0.9}) {
    state.velocities[slide_x] = noise * limits.joints[slide_x].standstill_velocity;
    const ChunkBuilder stays = one_joint(Mode::joint_position, slide_x, {0.0, 0.0});
    CHECK(judge(limits, stays.chunk, state, held).evidence.ok());
    const ChunkBuilder zero = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.0});
    CHECK(judge(limits, zero.chunk, state, held).evidence.ok());
  }
}

TEST_CASE("G030 joints get where a tool is to be from wherever it may start") {
  Limits limits = free_arm::limits();
  limits.parts[arm].joints.clear();
  for (const std::size_t joint : {slide_x, slide_y, turn_z}) {
    (void)limits.parts[arm].joints.push_back(joint);
    limits.joints[joint].velocity_limit = 100.0;
  }
  // It turns where it is: slide_x makes (0.7 + where it starts) (1 - cos) m, which 0.2 of what
  // slide_y makes and 2 mm allow up to 0.734 m from the axis.
  ChunkBuilder turn;
  turn.add(arm, Mode::cartesian_delta, {{0, 0, 0, 0, 0, 0.4191}}, {}, "base_link");
  const auto code = [&](double from, double speed) {
    MeasuredState state = at_rest();
    state.positions[slide_x] = from;
    state.velocities[slide_x] = speed;
    Predicted predicted(limits, state, turn.chunk, held);
    return predicted.all.advance().code;
  };
  CHECK(code(0.025, 0.0) == 0);
  CHECK(code(0.05, 0.0) == 30);
  CHECK(code(0.0, 1.0) == 30);  // 0.025 further by the branch, 0.05 at the end
}
