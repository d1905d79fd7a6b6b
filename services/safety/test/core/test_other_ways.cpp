// The ways of a tool's joints depend on where they start, which nobody knows of an arm that moved
// when it was measured and held in the tick that runs.

#include <doctest/doctest.h>

#include <cmath>

#include "free_arm.hpp"
#include "predicted.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr double way = 0.05;  // ahead, in a row

// The column turned at 1 rad/s: it is anywhere up to 50 mrad on, half way there by the branches.
struct Turning {
  explicit Turning(double speed) : state(at_rest()) { state.velocities[turn_z] = speed; }

  static ChunkBuilder ahead(std::size_t rows) {
    return ChunkBuilder().add(arm, Mode::cartesian_delta, Rows(rows, {way, 0, 0, 0, 0, 0}), {},
                              "base_link");
  }

  MeasuredState state;
  PartMemories memories;
  RowBefore held{nullptr, 0, false, &memories};
};

}  // namespace

TEST_CASE(
    "a tool's joints are off by as much as their ways differ by where they start, row by row") {
  for (const double side : {1.0, -1.0}) {
    const Turning arm_turns(side);
    const ChunkBuilder chunk = Turning::ahead(2);
    Predicted predicted(free_arm::limits(), arm_turns.state, chunk.chunk, arm_turns.held);
    const Branch& branch = predicted.after_a_row();
    // Of the slides, which turn with the column; not of the column, which turns no more.
    const double aside = way * std::sin(0.025), at_end = way * std::sin(0.05);
    const double off = std::max(at_end - aside, aside);
    CHECK(predicted.all.start_off()[slide_y] == doctest::Approx(off).epsilon(1e-3));
    CHECK(predicted.all.start_off()[turn_z] == doctest::Approx(0.025).epsilon(1e-3));
    CHECK(-side * branch.speed[slide_y] == doctest::Approx((aside + off) / 0.05).epsilon(1e-3));
    CHECK(branch.slowing != 0);
    const Interval& interval = predicted.all.interval();
    CHECK(interval.highest[slide_y] - interval.lowest[slide_y] ==
          doctest::Approx(2.0 * off).epsilon(1e-3));
    (void)predicted.after_a_row();
    CHECK(predicted.all.start_off()[slide_y] >= 1.9 * off);
  }
}

TEST_CASE("an arm that stands, or of which every row is known, is where its branches are") {
  const Turning arm_stands(0.0);
  const ChunkBuilder chunk = Turning::ahead(1);
  Predicted still(free_arm::limits(), arm_stands.state, chunk.chunk, arm_stands.held);
  (void)still.after_a_row();
  CHECK_FALSE(still.all.is_start_off());
  CHECK(still.all.start_off()[slide_y] == 0.0);
  const Turning arm_turns(1.0);
  Predicted known(free_arm::limits(), arm_turns.state, chunk.chunk);
  const Branch& branch = known.after_a_row();
  CHECK(known.all.start_off()[slide_y] == 0.0);
  CHECK(branch.speed[slide_y] == doctest::Approx(0.0));
}

TEST_CASE("G026 a joint is as fast as from wherever the tool may start") {
  const auto code = [](double fastest) {
    Limits limits = free_arm::limits();
    limits.joints[slide_y].velocity_limit = fastest;
    const Turning arm_turns(1.0);
    const ChunkBuilder chunk = Turning::ahead(1);
    return judge_rows(limits, whole_robot(limits), arm_turns.state, chunk.chunk, 0, arm_turns.held)
        .evidence.code;
  };
  CHECK(code(1.01 * std::sin(0.05)) == 0);
  CHECK(code(0.99 * std::sin(0.05)) == 26);
}

TEST_CASE("a joint that counts as standing may go on: its target is reached from there") {
  for (const double side : {1.0, -1.0}) {
    MeasuredState state = at_rest();
    const Limits limits = free_arm::limits();
    const double creeping = 0.9 * limits.joints[slide_x].standstill_velocity;
    for (const bool velocity_stuck : {true, false}) {
      (velocity_stuck ? state.travel_speeds : state.velocities)[slide_x] = side * creeping;
      const PartMemories memories;
      const RowBefore held{nullptr, 0, false, &memories};
      ChunkBuilder rows;
      rows.add(arm, Mode::joint_position, {{0, 0.05, 0, 0, 0, 0}, {0, 0.05, 0, 0, 0, 0}},
               {0, 1, 2, 3, 4, 5});
      Predicted predicted(limits, state, rows.chunk, held);
      CHECK(predicted.all.start_off()[slide_x] == doctest::Approx(creeping * 0.05));
      const Branch& branch = predicted.after_a_row();
      CHECK(branch.now[slide_x] == 0.05);
      CHECK(branch.speed[slide_x] == doctest::Approx(0.05 / 0.05 + creeping));
      CHECK(branch.slower[slide_x] == doctest::Approx(0.05 / 0.05 - creeping));
      (void)predicted.after_a_row();
      CHECK(predicted.all.start_off()[slide_x] == 0.0);
      // In lockstep it is where it is measured.
      Predicted known(limits, state, rows.chunk);
      CHECK(known.after_a_row().slowing == 0);
      state = at_rest();
    }
  }
}

TEST_CASE("fingers that declare no deceleration stay where they are measured") {
  Limits limits = free_arm::limits();
  limits.joints[slide_x].acceleration_limit = std::nan("");
  MeasuredState state = at_rest();
  state.velocities[slide_x] = 1.0;
  const PartMemories memories;
  const RowBefore held{nullptr, 0, false, &memories};
  const ChunkBuilder chunk = Turning::ahead(1);
  const Predicted predicted(limits, state, chunk.chunk, held);
  CHECK_FALSE(predicted.all.is_start_off());
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
  const PartMemories memories;
  const RowBefore held{nullptr, 0, false, &memories};
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
