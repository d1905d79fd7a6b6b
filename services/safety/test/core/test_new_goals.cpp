// Realtime, with the composite switch up: from which goal a tool goes on behind the tick that runs.

#include <doctest/doctest.h>

#include "goals.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::goals;

TEST_CASE("realtime: the row that acts already goes on from the goal as well") {
  const PartMemories memories = goal_at(0.1);
  const auto reached = [&](const ChunkBuilder& acts, Companions companions) {
    RowBefore before{&acts.chunk, 0};
    before.measured = false;
    before.memories = &memories;
    const ChunkBuilder next = turns({0.0});
    return Predicted(shared_out(), state_at_rest(), next.chunk, before, companions)
        .all.branch(upper)
        .now[arm_1];
  };
  CHECK(reached(switched(turns({turn}), -1.0), {}) == doctest::Approx(0.03).epsilon(1e-3));
  CHECK(reached(switched(turns({turn}), 1.0), {}) == doctest::Approx(0.06).epsilon(1e-3));
  const ChunkBuilder up = ChunkBuilder().scalar(composite, Mode::composite_mode, {1.0});
  Companion companion{RowBefore{&up.chunk, 0}};
  companion.before.measured = false;
  CHECK(reached(turns({turn}), Companions(&companion, 1)) == doctest::Approx(0.06).epsilon(1e-3));
}

TEST_CASE(
    "realtime: where the acting row goes on from a goal that nobody knows, nothing is known") {
  const PartMemories nobody_knows;
  const ChunkBuilder acts = switched(turns({turn}), 1.0);
  RowBefore before{&acts.chunk, 0};
  before.measured = false;
  before.memories = &nobody_knows;
  CHECK_FALSE(judge_rows(shared_out(), whole_robot(shared_out()), state_at_rest(),
                         switched(turns({turn}), -1.0).chunk, 0, before)
                  .evidence.ok());
}

TEST_CASE("realtime: a tool that holds in the tick that runs goes on from where it was measured") {
  const PartMemories memories = goal_at(0.1);
  MeasuredState state = state_at_rest();
  RowBefore before;
  before.measured = false;
  before.memories = &memories;
  const auto reached = [&](double angle) {
    const ChunkBuilder next = switched(turns({angle}), 1.0);
    Predicted predicted(shared_out(), state, next.chunk, before);
    CHECK(predicted.all.advance().ok());
    return predicted.all.branch(upper).now[arm_1];
  };
  CHECK(reached(turn) == doctest::Approx(0.03).epsilon(1e-3));
  // Half of the way that it may go on for, less 0.3 of that.
  state.velocities[arm_1] = 0.4;
  CHECK(reached(0.0) == doctest::Approx(0.7 * 0.5 * 0.4 * 0.05).epsilon(1e-3));
  // Nothing is known of its goal behind a row of another kind.
  const ChunkBuilder acts = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0});
  before.chunk = &acts.chunk;
  const ChunkBuilder next = switched(turns({turn}), 1.0);
  CHECK(Predicted(shared_out(), state, next.chunk, before).all.advance().code == 26);
}

TEST_CASE("realtime: what another claim's row tells a tool goes on in the tick that runs, too") {
  const PartMemories memories = goal_at(0.1);
  const ChunkBuilder acts = switched(turns({0.0}), 1.0);
  Companion companion{RowBefore{&acts.chunk, 0}};
  companion.before.measured = false;
  RowBefore before;
  before.measured = false;
  before.memories = &memories;
  const ChunkBuilder next = switched(turns({0.0}), 1.0);
  Predicted predicted(shared_out(), state_at_rest(), next.chunk, before, Companions(&companion, 1));
  CHECK(predicted.all.advance().ok());
  // 0.3 of 0.1 rad, and of what that left.
  CHECK(predicted.all.branch(upper).now[arm_1] == doctest::Approx(0.03 + 0.021).epsilon(1e-3));
}

TEST_CASE("realtime: a hold in the tick that runs makes no goal of one that nobody knows") {
  const PartMemories nobody_knows;
  RowBefore before;
  before.measured = false;
  before.memories = &nobody_knows;
  const ChunkBuilder next = switched(turns({turn}), 1.0);
  CHECK(Predicted(shared_out(), state_at_rest(), next.chunk, before).all.advance().code == 26);
  CHECK(Predicted(shared_out(), state_at_rest(), turns({turn}).chunk, before).all.advance().ok());
}

TEST_CASE("G026 realtime: a goal from before a hold is reached from wherever that ends") {
  const PartMemories memories = goal_at(0.0);
  MeasuredState state = state_at_rest();
  state.velocities[arm_1] = 1.0;  // 0.05 rad in a tick at most: 0.5 rad/s more or less
  RowBefore before;
  before.measured = false;
  before.memories = &memories;
  Limits limits = shared_out();
  limits.parts[arm].modes.cartesian_delta.gain.upper = 0.7;
  const auto code = [&](double angle, double value) {
    return judge_rows(limits, whole_robot(limits), state, switched(turns({angle}), value).chunk, 0,
                      before)
        .evidence.code;
  };
  // 14 rad/s of each rad; from half way 0.35 less, and 0.5 more.
  CHECK(code(0.1, -1.0) == 0);
  CHECK(code(0.09, 1.0) == 0);
  CHECK(code(0.1, 1.0) == 26);
}
