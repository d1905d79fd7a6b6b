// Of rows of which any share may happen: a tool's joints start elsewhere where less of the rows
// before happened, and go other ways from there.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "free_arm.hpp"
#include "predicted.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr double turn = 0.06, way = 0.05, upper = 1.5;

Row turned(double angle) { return {0, 0, 0, 0, 0, angle}; }
Row ahead(double distance) { return {distance, 0, 0, 0, 0, 0}; }

Limits gain_from(double lower) {
  Limits limits = free_arm::limits();
  for (JointLimits& joint : limits.joints) joint.velocity_limit = 100.0;
  limits.parts[arm].modes.cartesian_delta.gain = {lower, upper};
  return limits;
}

// Rows of the free arm's tool, in a frame.
struct Shared {
  Shared(double lower, const Rows& rows, const char* frame = "base_link")
      : chunk(ChunkBuilder().add(arm, Mode::cartesian_delta, rows, {}, frame)),
        predicted(gain_from(lower), at_rest(), chunk.chunk) {
    for (std::size_t row = 0; row < rows.size(); ++row) CHECK(predicted.all.advance().ok());
  }

  [[nodiscard]] double off(std::size_t j) const { return predicted.all.start_off()[j]; }
  [[nodiscard]] double lowest(std::size_t j) const { return predicted.all.interval().lowest[j]; }
  [[nodiscard]] double highest(std::size_t j) const { return predicted.all.interval().highest[j]; }
  // In the newest row, by any branch.
  [[nodiscard]] std::pair<double, double> speeds(std::size_t j) const {
    double least = 0.0, most = 0.0;
    for (std::size_t i = 0; i < predicted.all.branch_count(); ++i)
      for (const Branch& branch : {predicted.all.branch(i), predicted.all.branch(i).slowed()}) {
        least = std::min(least, branch.speed[j]);
        most = std::max(most, branch.speed[j]);
      }
    return {least, most};
  }

  ChunkBuilder chunk;
  Predicted predicted;
};

}  // namespace

TEST_CASE("where little of the rows before may have happened, a tool's joints go another way") {
  // Ahead is along the slide if the column has not turned, and also aside if it has.
  const double aside = upper * way * std::sin(upper * turn);
  const Shared one(0.0, {turned(turn)});
  CHECK(one.off(slide_y) == 0.0);
  const Shared two(0.0, {turned(turn), ahead(way)});
  CHECK(two.off(slide_y) == about(aside));
  CHECK(two.off(turn_z) == about(0.0));
  // The most of both turns it and goes aside; less of the first takes it less aside, not more.
  CHECK(two.lowest(slide_y) - one.lowest(slide_y) == about(-aside));
  CHECK(two.highest(slide_y) == about(aside));
  CHECK(two.speeds(slide_y).first == about(-aside / 0.05));
  // By each row anew, as far as it goes.
  const Shared three(0.0, {turned(turn), ahead(way), ahead(0.5 * way)});
  CHECK(three.off(slide_y) == about(1.5 * aside));
  // If each row happens alike, nothing is off.
  CHECK(Shared(upper, {turned(turn), ahead(way)}).off(slide_y) == 0.0);
}

TEST_CASE("of the least of a row joints go other ways by its share of what they do of the most") {
  const double lower = 0.5 * upper;
  const double differs = upper * way * (std::sin(upper * turn) - std::sin(lower * turn));
  const double most = upper * way * std::sin(upper * turn) + 0.5 * differs;
  const double least = lower * way * std::sin(lower * turn) - differs;
  for (const double side : {1.0, -1.0}) {
    CAPTURE(side);
    const Shared one(lower, {turned(side * turn)}), two(lower, {turned(side * turn), ahead(way)});
    const double less = two.lowest(slide_y) - one.lowest(slide_y);
    const double more = two.highest(slide_y) - one.highest(slide_y);
    CHECK((side > 0.0 ? less : -more) == about(-most));
    CHECK((side > 0.0 ? more : -less) == about(-least));
  }
}

TEST_CASE("a branch is as fast, or as slow, as its share of the other way makes it") {
  for (const double side : {1.0, -1.0}) {
    CAPTURE(side);
    const Shared two(0.0, {turned(side * turn), ahead(way)});
    const auto ends = [&](std::size_t branch) {
      const Branch& at = two.predicted.all.branch(branch);
      return std::pair(-side * at.speed[slide_y], -side * at.slowed().speed[slide_y]);
    };
    const double of_most = upper * way * std::sin(upper * turn) / 0.05;
    const double of_middle = 0.5 * upper * way * std::sin(0.5 * upper * turn) / 0.05;
    CHECK(ends(2).first == about(of_most));
    CHECK(ends(2).second == about(0.0));
    CHECK(ends(0).first == about(of_middle + 0.5 * of_most));
    CHECK(ends(0).second == about(of_middle - 0.5 * of_most));
  }
}

TEST_CASE("G026 a joint that goes another way may not be too fast there, either way") {
  // The tool is above the column, which turns without the slides. Back by more than it turned: the
  // most goes aside by `aside`, and by twice that if it was not turned there before.
  const double aside = upper * way * std::sin(upper * turn);
  for (const double side : {1.0, -1.0})
    for (const double fastest : {1.5 * aside / 0.05, 2.5 * aside / 0.05}) {
      CAPTURE(side);
      CAPTURE(fastest);
      Limits limits = gain_from(0.0);
      limits.joints[slide_y].velocity_limit = fastest;
      MeasuredState state = at_rest();
      state.positions[slide_x] = -0.7;
      const ChunkBuilder chunk = ChunkBuilder().add(
          arm, Mode::cartesian_delta, {turned(side * turn), turned(-2.0 * side * turn), ahead(way)},
          {}, "base_link");
      Predicted predicted(limits, state, chunk.chunk);
      (void)predicted.after_a_row();
      (void)predicted.after_a_row();
      CHECK(predicted.all.advance().code == (fastest < 2.0 * aside / 0.05 ? 26 : 0));
    }
}

namespace {

constexpr std::uint8_t column = 1;

// The column is a part of its own, that turns by any share of its velocity and carries the arm.
struct Carried {
  explicit Carried(std::size_t end_row)
      : turns(ChunkBuilder().joint(column, Mode::joint_velocity, turn_z, Row(3, speed))),
        tool(ChunkBuilder().add(arm, Mode::cartesian_delta, Rows(3, ahead(way)), {}, "base_link")),
        companion{{}, &tool.chunk, 0, end_row},
        predicted(limits(), at_rest(), turns.chunk, {}, Companions(&companion, 1)) {}

  static Limits limits() {
    Limits limits = gain_from(0.0);
    PartLimits other = test::part("column", {turn_z});
    other.modes.joint_velocity = joint_mode({turn_z}, 3.0);
    other.modes.joint_velocity.gain = {0.0, upper};
    PartLimits& own = limits.parts[arm];
    own.joints.clear();
    for (const std::size_t joint : {slide_x, slide_y, slide_z, turn_y, turn_x})
      (void)own.joints.push_back(joint);
    limits.joints[turn_z].part = column;
    (void)limits.parts.push_back(other);
    return limits;
  }

  // After another row.
  double off() {
    CHECK(predicted.all.advance().ok());
    return predicted.all.start_off()[slide_y];
  }

  static constexpr double speed = 1.0;
  ChunkBuilder turns, tool;
  Companion companion;
  Predicted predicted;
};

}  // namespace

TEST_CASE("what carries a tool turns its way by the shares of its own rows, while the tool moves") {
  const double aside = upper * way * std::sin(upper * 0.05 * Carried::speed);
  Carried on(3);
  CHECK(on.off() == 0.0);
  const double second = on.off();
  CHECK(second == about(aside));
  CHECK(on.off() > 2.0 * second);
  Carried ends(2);
  (void)ends.off();
  CHECK(ends.off() == second);
  CHECK(ends.off() == second);
}

TEST_CASE("rows that turn a tool there and back may leave it turned either way") {
  for (const double side : {1.0, -1.0}) {
    CAPTURE(side);
    const Shared shared(0.0, {turned(side * turn), turned(-side * turn), ahead(way)});
    const double aside = upper * way * std::sin(upper * turn);
    CHECK(shared.off(slide_y) == about(aside));
    const auto [least, most] = shared.speeds(slide_y);
    CHECK(least == about(-aside / 0.05));
    CHECK(most == about(aside / 0.05));
  }
}

TEST_CASE("along a frame that turns with a tool's joints, a row means what it does from there") {
  const Shared shared(0.0, {turned(turn), ahead(way)}, "column");
  CHECK(shared.off(slide_y) == about(0.0));
  CHECK(shared.off(slide_x) == about(0.0));
}

TEST_CASE(
    "G030 joints get where a tool is to be from wherever little of the rows before leaves it") {
  Limits limits = free_arm::limits();
  limits.parts[arm].joints.clear();
  for (const std::size_t joint : {slide_x, slide_y, turn_z}) {
    (void)limits.parts[arm].joints.push_back(joint);
    limits.joints[joint].velocity_limit = 100.0;
  }
  // As in test_other_ways.cpp: it cannot turn so far where it is from 0.75 m, but nearer to the
  // axis.
  const auto code = [&](double lower) {
    limits.parts[arm].modes.cartesian_delta.gain = {lower, 1.0};
    ChunkBuilder chunk;
    chunk.add(arm, Mode::cartesian_delta, {{-0.05, 0, 0, 0, 0, 0}, {0, 0, 0, 0, 0, 0.4191}}, {},
              "base_link");
    MeasuredState state = at_rest();
    state.positions[slide_x] = 0.05;
    Predicted predicted(limits, state, chunk.chunk);
    (void)predicted.after_a_row();
    return predicted.all.advance().code;
  };
  CHECK(code(1.0) == 0);
  CHECK(code(0.0) == 30);
}
