// G025: which mode may follow which, and when a composite switch may turn.

#include "acted_rows.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted hold{2, 0, 0};

std::uint16_t bit(Mode mode) {
  return static_cast<std::uint16_t>(1U << static_cast<unsigned>(mode));
}

// The base may go from velocities to twists, and not back.
struct OneWay : GateRig {
  std::uint64_t lead;  // ticks from the newest state to the first row

  explicit OneWay(bool in_lockstep) : GateRig(in_lockstep), lead(in_lockstep ? 0 : 1) {
    limits.parts[base].followers.fill(0);
    limits.parts[base].followers[static_cast<std::size_t>(Mode::joint_velocity)] =
        bit(Mode::body_twist);
    restart(BootInfo{true, false, {}});
    ready();
  }
  ChunkBuilder speed() {
    ChunkBuilder builder = chunk({0.1});
    builder.chunk.start_tick += lead;
    return builder;
  }
  ChunkBuilder twist() {
    ChunkBuilder builder = speed();
    builder.chunk.parts.clear();
    return builder.along(base, Mode::body_twist, 0, {0.1});
  }
  // The one row of the chunk just released acts; then so many ticks are held.
  void act(int held) {
    const SafeChunk safe = safe_chunk();
    if (lead == 1) next_tick(hold);
    next_tick_of({hold, hold, row_of(safe, 0), hold});
    for (int i = 0; i < held; ++i) next_tick(hold);
  }
};

}  // namespace

TEST_CASE("G025 after arming any mode may start; then only those that may follow it") {
  for (const bool lockstep : {true, false}) {
    OneWay rig(lockstep);
    REQUIRE(rig.send_chunk(rig.twist()).code == 0);
    rig.act(3);
    const Verdict verdict = rig.send_chunk(rig.speed());
    CHECK(verdict.code == 25);
    CHECK(verdict.part == "base");
    CHECK(verdict.axis == "mode");
    CHECK(verdict.value == 1.0);  // joint_velocity
    CHECK(verdict.limit == 7.0);  // after body_twist
    CHECK(rig.counter("G025") == 1);
    CHECK(rig.send_chunk(rig.twist()).code == 0);  // the same mode needs no entry
    // Arming anew forgets what acted.
    rig.send(EventKind::disarm, Disarm{"test"});
    rig.epoch = rig.arm().epoch;
    rig.take_claim();
    rig.seq = 0;
    rig.next_tick(hold);
    CHECK(rig.send_chunk(rig.speed()).code == 0);
  }
}

TEST_CASE("G025 a mode that may follow does so at standstill") {
  for (const bool lockstep : {true, false}) {
    OneWay rig(lockstep);
    REQUIRE(rig.send_chunk(rig.speed()).code == 0);
    rig.act(0);
    rig.velocities[base_x] = 0.05;
    rig.next_tick(hold);
    CHECK(rig.send_chunk(rig.twist()).code == 25);
    rig.velocities[base_x] = just_below(0.05);
    rig.next_tick(hold);
    CHECK(rig.send_chunk(rig.twist()).code == 0);
  }
}

TEST_CASE("G025 a row that is released but never acted is no mode to come from") {
  for (const bool lockstep : {true, false}) {
    OneWay rig(lockstep);
    REQUIRE(rig.send_chunk(rig.twist()).code == 0);
    for (int i = 0; i < 3; ++i) rig.next_tick(hold);
    CHECK(rig.send_chunk(rig.speed()).code == 0);
  }
}

TEST_CASE("G025 a mode lasts beyond the claim that commanded it") {
  for (const bool lockstep : {true, false}) {
    OneWay rig(lockstep);
    REQUIRE(rig.send_chunk(rig.twist()).code == 0);
    const SafeChunk safe = rig.safe_chunk();
    rig.send(EventKind::release, Release{"runner", rig.claim_id});
    rig.take_claim();
    rig.seq = 0;
    if (!lockstep) rig.next_tick(hold);
    rig.next_tick_of({hold, hold, row_of(safe, 0), hold});  // was under way when its claim ended
    rig.next_tick(hold);
    CHECK(rig.send_chunk(rig.speed()).code == 25);
    CHECK(rig.send_chunk(rig.twist()).code == 0);
  }
}

TEST_CASE("G025 after a row that nobody remembers only a mode passes that may follow every one") {
  OneWay rig(true);
  rig.next_tick_of({hold, hold, rig.forgotten_row(), hold});
  rig.next_tick(hold);
  CHECK(rig.send_chunk(rig.speed()).code == 25);  // may not follow body_twist
  CHECK(rig.send_chunk(rig.twist()).code == 0);   // may follow itself and joint_velocity
}

TEST_CASE("G025 another frame of the same mode needs standstill, and no entry") {
  Limits limits = test_limits();
  limits.parts[arm].followers.fill(0);
  CartesianLimits& mode = limits.parts[arm].modes.cartesian_twist;
  (void)mode.frames.push_back("column");
  const ClaimLimits claim = whole_robot(limits);
  const Rows rows{{0.1, 0.0, 0.0, 0.0, 0.0, 0.0}};
  const ChunkBuilder before = ChunkBuilder().add(arm, Mode::cartesian_twist, rows, {}, "base_link");
  const ChunkBuilder next = ChunkBuilder().add(arm, Mode::cartesian_twist, rows, {}, "column");
  MeasuredState state = state_at_rest();
  const auto code = [&] {
    return judge_rows(limits, claim, state, next.chunk, 0, RowBefore{&before.chunk, 0})
        .evidence.code;
  };
  CHECK(code() == 0);
  state.velocities[arm_2] = 0.05;
  CHECK(code() == 25);
  state.velocities[arm_2] = not_a_number;
  CHECK(code() == 25);
}
