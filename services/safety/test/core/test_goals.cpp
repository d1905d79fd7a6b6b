// G026 where the composite switch is up: a controller brings the tool on from its last goal, so
// what it has not made of a motion comes on top of the next.

#include <doctest/doctest.h>

#include "goals.hpp"
#include "tracked_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::goals;

TEST_CASE(
    "G026 switch up: what is left of the rows before comes on top, until the goal is far off") {
  // 0.6, 1.14, 1.63 rad/s where of the rows before a tenth happened.
  for (const double value : {-1.0, -0.5}) CHECK(of(switched(turns(four), value), goal_at(0)).ok());
  for (const double value : {0.0, 0.5, 1.0}) {
    const Evidence found = of(switched(turns(four), value), goal_at(0));
    CHECK(found.code == 26);
    CHECK(found.row == 2);
    CHECK(found.part == "arm");
    CHECK(found.axis == "arm_1");
    CHECK(found.value == doctest::Approx(6.0 * (0.1 + 0.9 * (0.1 + 0.09))).epsilon(5e-3));
  }
  CHECK(of(switched(turns({turn, -turn, turn, -turn, turn, -turn}), 1.0), goal_at(0)).ok());
  const ChunkBuilder twists = turns(Row(4, turn / 0.05), Mode::cartesian_twist);
  CHECK(of(switched(twists, 1.0), goal_at(0)).row == 2);
  CHECK(of(switched(twists, -1.0), goal_at(0)).ok());
}

TEST_CASE("G026 switch up: the goal of the rows that acted counts, either way; switched down not") {
  const auto code = [](double goal, double angle, double value) {
    return of(switched(turns({angle}), value), goal_at(goal)).code;
  };
  CHECK(code(0.14, 0.1, 1.0) == 0);
  CHECK(code(0.16, 0.1, 1.0) == 26);
  CHECK(code(0.16, 0.1, -1.0) == 0);
  CHECK(code(0.26, 0.0, 1.0) == 26);
  CHECK(code(0.26, -0.1, 1.0) == 0);
  CHECK(code(-0.16, -0.1, 1.0) == 26);
}

TEST_CASE("G026 switch up: from a goal that nobody knows no motion goes on") {
  const PartMemories nobody_knows;
  const Evidence found = of(switched(turns({0.0, 0.0}), 1.0), nobody_knows);
  CHECK(found.code == 26);
  CHECK(found.row == 0);
  CHECK(found.part == "arm");
  CHECK(found.axis == "tool motion");
  CHECK(found.limit_source.find("a held tick") != std::string_view::npos);
  CHECK(of(switched(turns(four), -1.0), nobody_knows).ok());
  ChunkBuilder base_up;
  base_up.joint(base, Mode::joint_velocity, base_x, {0.5});
  base_up.scalar(composite, Mode::composite_mode, {1.0});
  CHECK(of(base_up, nobody_knows).ok());  // no tool's motion
}

TEST_CASE("G026 the switch of another claim's rows, as long as they last") {
  const auto row = [](const Companion& companion) {
    return judge_rows(RobotModel(shared_out()), whole_robot(shared_out()), state_at_rest(),
                      turns(four).chunk, 0, {}, Companions(&companion, 1))
        .evidence.row;
  };
  const ChunkBuilder up = ChunkBuilder().scalar(composite, Mode::composite_mode, {1, 1, 1, 1});
  const ChunkBuilder down =
      ChunkBuilder().scalar(composite, Mode::composite_mode, {-1, -1, -1, -1});
  CHECK(row({}) == -1);
  CHECK(row({{}, &down.chunk, 0, 4}) == -1);
  (void)of(switched(turns({0.0}), 1.0),
           goal_at(0.16));  // another judgement's goal is not this one's
  CHECK(row({{}, &up.chunk, 0, 3}) == 2);
  CHECK(row({{}, &up.chunk, 0, 2}) == -1);  // its rows are over
  CHECK(row({RowBefore{&up.chunk, 0}, nullptr, 0, 0}) == -1);
}

TEST_CASE("a row that takes back what was left leads nowhere, and the next one like it does not") {
  Limits limits = test_limits();
  limits.parts[arm].modes.cartesian_delta.gain = {0.5, 0.5};
  const ChunkBuilder chunk = switched(turns({0.1, -0.05, -0.05}), 1.0);
  Predicted predicted(limits, state_at_rest(), chunk.chunk);
  const double there = predicted.after_a_row().now[arm_1];
  CHECK(predicted.after_a_row().now[arm_1] == there);
  CHECK(predicted.after_a_row().now[arm_1] < there - 0.02);
}

namespace {

// The arm is told to turn and does not: its goal gets away from it.
struct Waiting : TrackedRig {
  explicit Waiting(Mode told = Mode::cartesian_delta, bool in_lockstep = true)
      : TrackedRig(in_lockstep, [](Limits& all) { all = shared_out(); }), mode(told) {}
  ChunkBuilder rows(std::size_t count, double value, double angle = turn) const {
    const double scale = mode == Mode::cartesian_twist ? 20.0 : 1.0;
    return switched(turns(Row(count, scale * angle), mode), value);
  }
  std::uint32_t code(double value = 1.0) {
    ChunkBuilder builder = chunk();
    const ChunkBuilder told = rows(1, value);
    builder.chunk.parts = told.chunk.parts;
    builder.chunk.horizon = 1;
    builder.chunk.start_tick += lockstep ? 0 : 1;
    return send_chunk(builder).code;
  }
  void act_on(std::size_t count, double value) {
    begin(rows(count, value));
    for (std::size_t i = 0; i < count; ++i) act();
  }
  Mode mode;
};

}  // namespace

TEST_CASE("G026 the goal of a row that acted stays, for deltas and twists, until a tick is held") {
  for (const Mode mode : {Mode::cartesian_delta, Mode::cartesian_twist}) {
    Waiting rig(mode);
    rig.act_on(2, 1.0);  // 0.2 rad ahead: with another 0.1 it is 1.8 rad/s
    CHECK(rig.code(-1.0) == 0);
    CHECK(rig.code() == 26);
    rig.hold();
    CHECK(rig.code() == 0);
  }
}

TEST_CASE("G026 a row with the switch down begins anew where the tool is") {
  Waiting rig;
  rig.act_on(2, -1.0);
  CHECK(rig.code() == 0);  // 0.1 rad ahead, and another 0.1: 1.2 rad/s
  rig.act_on(1, 1.0);
  CHECK(rig.code() == 26);
}

TEST_CASE("G026 rows still to act are revoked where the tool lags behind its goal") {
  Waiting rig;
  rig.begin(rig.rows(3, 1.0));
  rig.act();
  CHECK(rig.count(OutputKind::verdict) == 0);
  rig.act();
  CHECK(rig.verdict().code == 26);
  CHECK(rig.verdict().part == "arm");
}

TEST_CASE(
    "G026 the goal is unknown where a state was lost, until a tick is seen held or switched down") {
  for (const bool stands : {true, false}) {
    Waiting rig(Mode::cartesian_delta, false);
    rig.begin(rig.rows(4, 1.0, 0.5 * turn));
    rig.act();
    rig.pass(1);
    for (const std::uint32_t row : {2U, 3U}) {
      rig.send_heartbeat();
      rig.next_tick_of({row_of(rig.safe, row), no_row, no_row, row_of(rig.safe, row)});
    }
    CHECK(rig.code() == 26);
    CHECK(rig.code(-1.0) == 0);
    rig.velocities[arm_1] = stands ? 0.0 : 0.2;
    rig.pass(1);
    rig.hold();  // how the tick began is lost
    CHECK(rig.code() == (stands ? 0 : 26));
    rig.hold();
    CHECK(rig.code() == 0);
  }
}

TEST_CASE("G026 a row of a claim that has ended, and one of another mode, leave no goal") {
  Waiting rig;
  rig.begin(rig.rows(3, 1.0));
  rig.send(EventKind::release, Release{"runner", rig.claim_id});
  rig.take_claim();
  rig.seq = 0;
  rig.act();
  rig.hold();
  CHECK(rig.code() == 0);
  rig.hold();
  rig.begin(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.1}));
  rig.act();
  CHECK(rig.code() == 26);
  rig.hold();
  CHECK(rig.code() == 0);
}

TEST_CASE("G026 nobody knows the goal beside a switch whose row nobody remembers") {
  for (const std::uint64_t other : {0U, 1U}) {
    Waiting rig(Mode::cartesian_delta, false);
    rig.begin(rig.rows(2, 1.0, 0.5 * turn));
    rig.act();
    rig.send_heartbeat();
    const auto switches = [&rig] {
      ChunkBuilder builder = rig.chunk();
      builder.chunk.parts.clear();
      return switched(builder, 1.0);
    };
    const Acted told = other == 0 ? row_of(rig.safe, 1) : rig.forgotten_row(switches);
    rig.next_tick_of({row_of(rig.safe, 1), no_row, no_row, told});
    CHECK(rig.code() == (other == 0 ? 0 : 26));
    for (int i = 0; i < 6; ++i) {  // until G010 admits another
      rig.send_heartbeat();
      rig.hold();
    }
    CHECK(rig.code() == 0);
  }
}
