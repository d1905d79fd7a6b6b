// G043: however a part's permission ends, it has to be seen at standstill within the ramp.

#include <string>

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted hold{2, 0, 0};
constexpr int ramp_ticks = 4;

// Armed; the base executes the first row of a chunk of 16. The ramp is four periods of 50 ms.
struct Driving : GateRig {
  SafeChunk safe;
  std::uint32_t row = 0;

  explicit Driving(bool in_lockstep = false) : GateRig(in_lockstep) {
    limits.protocol.stop_ramp_ms = 200;
    limits.protocol.heartbeat_timeout_lockstep_ms = 300;
    restart(BootInfo{true, false, {}});
    ready();
    drive();
  }
  void drive() {
    ChunkBuilder chunk = this->chunk(Row(16, 0.5));
    chunk.chunk.start_tick += lockstep ? 0 : 1;
    REQUIRE(send_chunk(chunk).code == 0);
    safe = safe_chunk();
    row = 0;
    if (!lockstep) next_tick(hold);
    act();
  }
  // The base executes its next row; the other parts hold.
  void act() {
    velocities[base_x] = 0.5;
    next_tick_of({hold, hold, row_of(safe, row++), hold});
    send_heartbeat();
  }
  void rest(double speed) {
    velocities[base_x] = speed;
    next_tick(hold);
    send_heartbeat();
  }
  void rests(int states, double speed) {
    for (int i = 0; i < states; ++i) rest(speed);
  }
  void release() { send(EventKind::release, Release{"runner", claim_id}); }
  void disarm() { send(EventKind::disarm, Disarm{"test"}); }
  [[nodiscard]] bool is_latched() const { return gate->state() == GateState::latched; }
  std::string cause() { return std::string(status().cause.view()); }
};

}  // namespace

TEST_CASE("G043 rows that end: standing still at the end of the ramp, or latched") {
  for (const bool lockstep : {false, true}) {
    Driving good(lockstep);
    good.rests(2, 0.5);
    good.rests(3, just_below(0.05));  // the ramp counts from the first state without a row
    good.rests(20, 0.5);              // pushed: nobody told it to
    CHECK(good.gate->state() == GateState::armed);
    Driving rig(lockstep);
    rig.rests(1 + ramp_ticks, 0.05);
    CHECK(rig.gate->state() == GateState::armed);
    rig.rest(0.05);
    REQUIRE(rig.is_latched());
    CHECK(rig.counter("G043") == 1);
    CHECK(rig.cause() ==
          "latched: no standstill 200 ms after the end of its rows: G043 base base_x: 0.05 m/s, "
          "limit 0.05 m/s (standstill_per_s)");
    rig.rests(8, 0.5);
    CHECK(rig.counter("G043") == 1);  // said once
  }
}

TEST_CASE("G043 rows again in between: the ramp starts anew") {
  for (const bool lockstep : {false, true}) {
    Driving rig(lockstep);
    for (int gap = 0; gap < 5; ++gap) {
      rig.rests(2, 0.5);
      rig.rest(0.0);
      rig.drive();
    }
    CHECK(rig.gate->state() == GateState::armed);
    CHECK(rig.counter("G043") == 0);
  }
}

TEST_CASE("G043 a claim that is released, or whose runner falls silent, leaves parts to stop") {
  for (const bool silent : {false, true})
    for (const double speed : {0.0, 0.5}) {
      Driving rig;
      if (silent) {
        for (int i = 0; i < 7; ++i) {  // 350 ms without a heartbeat, rows acting
          rig.velocities[base_x] = 0.5;
          rig.next_tick_of({hold, hold, row_of(rig.safe, rig.row++), hold});
        }
      } else {
        rig.release();
      }
      REQUIRE(rig.status().claims.empty());
      rig.rests(ramp_ticks + 2, speed);
      CHECK(rig.is_latched() == (speed > 0.0));
      CHECK(rig.counter("G043") == (speed > 0.0 ? 1 : 0));
    }
}

TEST_CASE("G043 a row that acts on after its claim ended is no reason to wait longer") {
  for (const bool lockstep : {false, true}) {
    Driving rig(lockstep);
    rig.release();
    for (int i = 0; i < ramp_ticks; ++i) rig.act();
    CHECK(rig.gate->state() == GateState::armed);
    rig.act();
    REQUIRE(rig.is_latched());
    CHECK(rig.cause().find("G043 base base_x: 0.5") != std::string::npos);
  }
}

TEST_CASE("G043 a row of a claim that has ended is not permitted by the next claim of its parts") {
  for (const bool lockstep : {false, true}) {
    Driving rig(lockstep);
    rig.release();
    for (int i = 0; i < ramp_ticks; ++i) {
      rig.act();
      if (i == 0) rig.take_claim();
    }
    CHECK(rig.gate->state() == GateState::armed);
    rig.act();
    REQUIRE(rig.is_latched());
    CHECK(rig.cause().find("G043 base base_x: 0.5") != std::string::npos);
  }
}

TEST_CASE("G043 disarmed while moving: latched, with its mark of a clean exit taken back") {
  for (const bool lockstep : {false, true}) {
    Driving rig(lockstep);
    rig.disarm();
    rig.rests(ramp_ticks, 0.5);
    CHECK(rig.gate->state() == GateState::disarmed);
    rig.velocities[base_x] = 0.5;
    rig.next_tick(hold);
    REQUIRE(rig.is_latched());
    CHECK(rig.count(OutputKind::clear_clean_mark) == 1);
    CHECK(rig.count(OutputKind::persist_latch) == 1);
  }
}

TEST_CASE("G043 disarmed and standing still, or disarmed at rest: disarmed it stays") {
  Driving rig;
  rig.disarm();
  rig.rests(3, 0.0);
  rig.rests(9, 0.5);
  CHECK(rig.gate->state() == GateState::disarmed);
  Driving rested;
  rested.rests(3, 0.0);
  rested.disarm();
  rested.timer(3'600'000 * ms);
  CHECK(rested.gate->state() == GateState::disarmed);
}

TEST_CASE("G043 disarmed, and the HAL falls silent: unknown is no standstill") {
  Driving rig;
  rig.disarm();
  rig.timer(200 * ms);
  CHECK(rig.gate->state() == GateState::disarmed);
  rig.timer(1);
  REQUIRE(rig.is_latched());
  CHECK(rig.cause().ends_with("(no state since then)"));
}

TEST_CASE("G043 arming does not end the watch of what has not been seen still") {
  for (const bool lockstep : {false, true}) {
    Driving rig(lockstep);
    rig.disarm();
    rig.rest(0.5);
    rig.arm();
    rig.rests(ramp_ticks - 1, 0.5);
    CHECK(rig.gate->state() == GateState::armed);
    rig.rest(0.5);
    CHECK(rig.is_latched());
  }
}

TEST_CASE("G043 a stop after rows ended does not give the part more time") {
  Driving rig;
  rig.rests(2, 0.5);
  rig.send(EventKind::stop_level, StopLevel{77, "operator", "now"});
  rig.rests(3, 0.5);
  CHECK(rig.gate->state() == GateState::stopped);
  rig.rest(0.5);
  CHECK(rig.is_latched());
}
