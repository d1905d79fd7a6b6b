// A state tells what acted in the tick before it. Where states are lost, rows may have acted that
// no state tells of: what had been released counts as if it had.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted hold{2, 0, 0};
constexpr auto velocity = static_cast<std::uint8_t>(Mode::joint_velocity);

// Realtime. At tick 100 a row for tick 101 is released, of the base if nothing else is said; state
// 102, which would tell whether it acted, is lost. State 103 says that the parts held in tick 102.
struct Lossy : GateRig {
  Lossy() {
    limits.protocol.stop_ramp_ms = 200;
    limits.parts[composite].modes.composite_mode.switches_anywhere = false;
    limits.parts[base].followers[velocity] = PartMemory::mode_bit(velocity);
    restart(BootInfo{true, false, {}});
    ready();
  }
  ChunkBuilder to(std::uint8_t part, Mode mode, double value, std::size_t rows = 1) {
    ChunkBuilder builder = chunk(Row(rows, value));
    builder.chunk.start_tick += 1;
    if (mode == Mode::joint_velocity) return builder;
    builder.chunk.parts.clear();
    if (mode == Mode::composite_mode) return builder.scalar(part, mode, {value});
    return builder.along(part, mode, 0, {value});
  }
  std::uint32_t code_of(std::uint8_t part, Mode mode, double value) {
    return send_chunk(to(part, mode, value)).code;
  }
  std::uint32_t drive(double value, std::size_t rows = 1) {
    return send_chunk(to(base, Mode::joint_velocity, value, rows)).code;
  }
  std::uint32_t twist(double value) { return code_of(base, Mode::body_twist, value); }
  void lose_a_state() {
    next_tick(hold);
    pass(1);
  }
  void see(double speed) {
    velocities[base_x] = speed;
    next_tick(hold);
  }
};

}  // namespace

TEST_CASE("G025 a row that nobody saw act may still move its part: no other mode until it stands") {
  Lossy rig;
  rig.limits.parts[base].followers[velocity] = 0xFFFF;
  rig.restart(BootInfo{true, false, {}});
  rig.seq = 0;
  rig.ready();
  REQUIRE(rig.drive(0.5) == 0);
  rig.lose_a_state();
  rig.see(0.5);
  CHECK(rig.twist(0.5) == 25);
  CHECK(rig.drive(0.5) == 0);  // the same mode may go on
  rig.see(0.04);
  CHECK(rig.twist(0.04) == 25);  // nor beside a row that may act
  rig.see(0.04);
  CHECK(rig.twist(0.04) == 0);
}

TEST_CASE("G025 a row that nobody saw act counts for the transitions, seen to hold it does not") {
  for (const bool lost : {true, false}) {
    Lossy rig;
    REQUIRE(rig.drive(0.0, 8) == 0);
    rig.next_tick(hold);
    rig.send(EventKind::release, Release{"runner", rig.claim_id});
    rig.take_claim();
    rig.seq = 0;
    if (!lost) rig.see(0.0);
    rig.pass(1);
    rig.see(0.0);
    CHECK(rig.twist(0.0) == (lost ? 25 : 0));
  }
}

TEST_CASE("G025 so it does for the first part, whatever it held for") {
  constexpr auto delta = static_cast<std::uint8_t>(Mode::cartesian_delta);
  for (const Acted held : {Acted{1, 0, 0}, Acted{2, 0, 0}}) {
    Lossy rig;
    rig.limits.parts[arm].followers[delta] = PartMemory::mode_bit(delta);
    rig.restart(BootInfo{true, false, {}});
    rig.seq = 0;
    rig.ready();
    ChunkBuilder rows = rig.to(arm, Mode::cartesian_delta, 0.0);
    rows.chunk.parts.clear();
    rows.chunk.horizon = 8;
    REQUIRE(rig.send_chunk(rows.along(arm, Mode::cartesian_delta, 0, Row(8, 0.0))).code == 0);
    rig.next_tick(held);
    rig.send(EventKind::release, Release{"runner", rig.claim_id});
    rig.take_claim();
    rig.seq = 0;
    rig.next_tick(held);
    rig.pass(1);
    rig.next_tick(held);
    CHECK(rig.code_of(arm, Mode::cartesian_twist, 0.0) == 0);
  }
}

TEST_CASE("G025 rows that go out again after a hold may act unseen as well") {
  Lossy rig;
  REQUIRE(rig.drive(0.0, 8) == 0);
  rig.next_tick(hold);
  rig.see(0.0);  // held in tick 101: the rest goes out again, for tick 103
  rig.see(0.0);
  rig.pass(1);
  rig.see(0.0);
  CHECK(rig.twist(0.0) == 25);
}

TEST_CASE("G025 nor does it matter that the claim ended before, or that the gate was armed anew") {
  for (const bool arms : {true, false}) {
    Lossy rig;
    REQUIRE(rig.drive(0.0) == 0);
    rig.next_tick(hold);
    if (arms)
      rig.send(EventKind::disarm, Disarm{"test"});
    else
      rig.send(EventKind::release, Release{"runner", rig.claim_id});
    rig.seq = 0;
    if (arms)
      rig.ready();
    else
      rig.take_claim();
    rig.pass(1);
    rig.see(0.0);
    CHECK(rig.twist(0.0) == 25);
    CHECK(rig.drive(0.0) == 0);
  }
}

TEST_CASE("G025 a new session has none of the rows that the one before may have had") {
  Lossy rig;
  REQUIRE(rig.drive(0.0) == 0);
  rig.send(EventKind::disarm, Disarm{"test"});
  rig.session = hal_session + 1;
  rig.send_hal_status(rig.session);
  rig.now_ns += 600 * ms;
  rig.tick = 80;
  rig.send_state();
  rig.epoch = rig.arm().epoch;
  rig.take_claim();
  rig.seq = 0;
  rig.lose_a_state();
  rig.see(0.0);
  CHECK(rig.twist(0.0) == 0);
}

TEST_CASE("G025 which way a switch that nobody saw act points is not known") {
  Lossy rig;
  REQUIRE(rig.code_of(composite, Mode::composite_mode, 1.0) == 0);
  rig.lose_a_state();
  rig.see(0.5);
  CHECK(rig.code_of(composite, Mode::composite_mode, 1.0) == 25);
  rig.see(0.0);
  CHECK(rig.code_of(composite, Mode::composite_mode, 1.0) == 0);
}

TEST_CASE("G025 a row that is seen to act tells what may still act: rows of its mode") {
  Lossy rig;
  rig.limits.parts[base].followers.fill(0);
  rig.restart(BootInfo{true, false, {}});
  rig.seq = 0;
  rig.ready();
  REQUIRE(rig.twist(0.0) == 0);
  REQUIRE(rig.drive(0.0) == 0);  // replaces it, and the HAL has both
  const SafeChunk safe = rig.safe_chunk();
  rig.next_tick(hold);
  rig.next_tick_of({hold, hold, row_of(safe, 0), hold});
  REQUIRE(rig.drive(0.0) == 0);
  rig.lose_a_state();
  rig.see(0.0);
  CHECK(rig.drive(0.0) == 0);
}

TEST_CASE("G043 a part that a row may have moved, and of which no state told, has to stop") {
  Lossy rig;
  REQUIRE(rig.drive(0.5) == 0);
  rig.lose_a_state();
  for (int i = 0; i < 5; ++i) {
    rig.see(0.5);
    rig.send_heartbeat();
  }
  CHECK(rig.gate->state() == GateState::armed);
  rig.see(0.5);
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.counter("G043") == 1);
  Lossy still;
  REQUIRE(still.drive(0.5) == 0);
  still.lose_a_state();
  for (int i = 0; i < 12; ++i) {
    still.see(0.0);
    still.send_heartbeat();
  }
  CHECK(still.gate->state() == GateState::armed);
}

TEST_CASE(
    "G043 disarmed, a part that was seen to hold since its rows were released is not watched") {
  Lossy rig;
  REQUIRE(rig.drive(0.5, 8) == 0);
  rig.next_tick(hold);
  rig.send(EventKind::disarm, Disarm{"test"});
  rig.see(0.0);
  rig.pass(1);
  for (int i = 0; i < 12; ++i) rig.see(0.5);  // pushed by hand
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("what may move a part by two counts is known if both tell the same command") {
  const ChunkBuilder one = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.01});
  const ChunkBuilder mode = ChunkBuilder().along(arm, Mode::cartesian_twist, 0, {0.01});
  const ChunkBuilder frame = ChunkBuilder().add(arm, Mode::cartesian_delta, {Row(6, 0.0)}, {}, "x");
  const auto both = [&](const ChunkBuilder* first, const ChunkBuilder& second) {
    MovingMode moving, other;
    if (first != nullptr) moving.note(first->chunk.parts[0]);
    other.note(second.chunk.parts[0]);
    moving.add(other);
    return moving.kind;
  };
  CHECK(both(nullptr, one) == MovingMode::Kind::known);
  CHECK(both(&one, one) == MovingMode::Kind::known);
  CHECK(both(&one, mode) == MovingMode::Kind::unknown);
  CHECK(both(&one, frame) == MovingMode::Kind::unknown);
  MovingMode moving, unknown;
  moving.note(one.chunk.parts[0]);
  unknown.note(one.chunk.parts[0]);
  unknown.kind = MovingMode::Kind::unknown;
  moving.add(unknown);
  CHECK(moving.kind == MovingMode::Kind::unknown);
}
