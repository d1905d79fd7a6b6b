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
  CHECK(two.off(slide_y) == doctest::Approx(aside).epsilon(1e-3));
  CHECK(two.off(turn_z) == doctest::Approx(0.0).epsilon(1e-3));
  // The most of both turns it and goes aside; less of the first takes it less aside, not more.
  CHECK(two.lowest(slide_y) - one.lowest(slide_y) == doctest::Approx(-aside).epsilon(1e-3));
  CHECK(two.highest(slide_y) == doctest::Approx(aside).epsilon(1e-3));
  CHECK(two.speeds(slide_y).first == doctest::Approx(-aside / 0.05).epsilon(1e-3));
  // By each row anew, as far as it goes.
  const Shared three(0.0, {turned(turn), ahead(way), ahead(0.5 * way)});
  CHECK(three.off(slide_y) == doctest::Approx(1.5 * aside).epsilon(1e-2));
  // If each row happens alike, nothing is off.
  CHECK(Shared(upper, {turned(turn), ahead(way)}).off(slide_y) == 0.0);
}

TEST_CASE("of the least of a row joints go other ways by its share of what they do of the most") {
  const double lower = 0.5 * upper;
  const Shared one(lower, {turned(turn)}), two(lower, {turned(turn), ahead(way)});
  const double differs = upper * way * (std::sin(upper * turn) - std::sin(lower * turn));
  CHECK(two.lowest(slide_y) - one.lowest(slide_y) ==
        doctest::Approx(-upper * way * std::sin(upper * turn) - 0.5 * differs).epsilon(1e-2));
  CHECK(two.highest(slide_y) - one.highest(slide_y) ==
        doctest::Approx(-lower * way * std::sin(lower * turn) + differs).epsilon(1e-2));
}

TEST_CASE("rows that turn a tool there and back may leave it turned either way") {
  for (const double side : {1.0, -1.0}) {
    CAPTURE(side);
    const Shared shared(0.0, {turned(side * turn), turned(-side * turn), ahead(way)});
    const double aside = upper * way * std::sin(upper * turn);
    CHECK(shared.off(slide_y) == doctest::Approx(aside).epsilon(1e-3));
    const auto [least, most] = shared.speeds(slide_y);
    CHECK(least == doctest::Approx(-aside / 0.05).epsilon(1e-3));
    CHECK(most == doctest::Approx(aside / 0.05).epsilon(1e-3));
  }
}

TEST_CASE("along a frame that turns with a tool's joints, a row means what it does from there") {
  const Shared shared(0.0, {turned(turn), ahead(way)}, "column");
  CHECK(shared.off(slide_y) == doctest::Approx(0.0).epsilon(1e-3));
  CHECK(shared.off(slide_x) == doctest::Approx(0.0).epsilon(1e-3));
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
