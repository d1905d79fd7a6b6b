// G043: a stop, and what is not seen at standstill within the ramp after it. How permission ends
// otherwise: test_ends_of_motion.cpp.

#include <string>

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted hold{2, 0, 0};

// Armed; the base moves, and the ramp is four periods of 50 ms.
struct Moving : GateRig {
  explicit Moving(bool in_lockstep = false) : GateRig(in_lockstep) {
    limits.protocol.stop_ramp_ms = 200;
    restart(BootInfo{true, false, {}});
    ready();
    velocities[base_x] = 0.5;
    next_tick(hold);
  }
  void stop(std::uint64_t id = 77) {
    send(EventKind::stop_level, StopLevel{id, "operator", "now"});
  }
  void speed(double value) {
    velocities[base_x] = value;
    next_tick(hold);
  }
  void meet_second_gate() {
    Lease lease;
    lease.epoch = 4711;
    send(EventKind::lease, lease);
  }
  [[nodiscard]] bool is_latched() const { return gate->state() == GateState::latched; }
};

constexpr std::size_t ramp_ticks = 4;

}  // namespace

TEST_CASE("G043 at standstill within the ramp: still stopped, however long it lasts") {
  for (const bool lockstep : {false, true}) {
    Moving rig(lockstep);
    rig.stop();
    rig.speed(0.5);
    for (int i = 0; i < 3; ++i) rig.speed(just_below(0.05));  // exactly at the end of the ramp
    for (int i = 0; i < 20; ++i) rig.speed(0.5);              // pushed: nobody told it to
    CHECK(rig.gate->state() == GateState::stopped);
    CHECK(rig.counter("G043") == 0);
  }
}

TEST_CASE("G043 not at standstill at the end of the ramp: latched, naming the joint") {
  for (const double speed : {0.05, -0.05, 0.5, 1e6}) {
    for (const bool lockstep : {false, true}) {
      Moving rig(lockstep);
      rig.stop();
      for (std::size_t i = 0; i < ramp_ticks; ++i) rig.speed(speed);
      CHECK(rig.gate->state() == GateState::stopped);
      rig.speed(speed);
      REQUIRE(rig.is_latched());
      CHECK(rig.count(OutputKind::persist_latch) == 1);
      CHECK(rig.counter("G043") == 1);
      const std::string cause(rig.status().cause.view());
      CHECK(cause.starts_with("latched: no standstill 200 ms after the stop: G043 base base_x: "));
      CHECK(cause.ends_with(" m/s, limit 0.05 m/s (standstill_per_s)"));
      CHECK(rig.status().stop_ids.contains(77));
      rig.speed(speed);
      CHECK(rig.counter("G043") == 1);  // once a stop
    }
  }
}

TEST_CASE("G043 standstill is believed after three states in a row, not after one or two") {
  for (const bool lockstep : {false, true}) {
    Moving rig(lockstep);
    rig.stop();
    rig.speed(0.0);
    rig.speed(0.0);
    rig.speed(0.5);  // it swings, or the sensor was wrong
    rig.speed(0.0);
    CHECK(rig.gate->state() == GateState::stopped);
    rig.speed(0.0);
    REQUIRE(rig.is_latched());
    // In realtime the clock decides before the last of them is looked at.
    CHECK(std::string(rig.status().cause.view()) ==
          std::string("latched: no standstill 200 ms after the stop: G043 base still states: ") +
              (lockstep ? "2" : "1") + ", limit 3");
  }
}

TEST_CASE("G043 a state that is repeated is one state") {
  Moving rig;
  rig.stop();
  for (int i = 0; i < 2; ++i) rig.speed(0.0);
  for (int i = 0; i < 5; ++i) rig.send_state();
  rig.timer(100 * ms + 1);
  CHECK(rig.is_latched());
}

TEST_CASE("G043 realtime: the gate's clock decides, to the nanosecond") {
  Moving rig;
  rig.stop();
  rig.timer(200 * ms);
  CHECK(rig.gate->state() == GateState::stopped);
  rig.timer(1);
  CHECK(rig.is_latched());
}

TEST_CASE("G043 realtime: no state since the stop is no standstill") {
  Moving rig;
  rig.velocities[base_x] = 0.0;
  rig.next_tick(hold);  // stood still before the stop: says nothing about after it
  rig.stop();
  rig.timer(200 * ms + 1);
  REQUIRE(rig.is_latched());
  CHECK(std::string(rig.status().cause.view()) ==
        "latched: no standstill 200 ms after the stop: G043 state age: 200 ms, limit 200 ms "
        "(no state since then)");
}

TEST_CASE("G043 realtime: a HAL that dies while it moves stops, then latches") {
  Moving rig;
  rig.timer(251 * ms);
  REQUIRE(rig.gate->state() == GateState::stopped);
  rig.timer(200 * ms);
  CHECK(rig.gate->state() == GateState::stopped);
  rig.timer(1 * ms);
  CHECK(rig.is_latched());
  CHECK(rig.counter("G011") == 1);
  CHECK(rig.counter("G043") == 1);
}

TEST_CASE("G043 lockstep: without states the world stands, and no time passes") {
  Moving rig(true);
  rig.stop();
  rig.timer(3600 * 1000 * ms);
  CHECK(rig.gate->state() == GateState::stopped);
  rig.speed(0.5);
  CHECK(rig.gate->state() == GateState::stopped);  // one tick, whatever the clock says
  rig.pass(ramp_ticks - 1);
  rig.speed(0.5);
  CHECK(rig.is_latched());
}

TEST_CASE("G043 a part that still executes a row has not stopped, though it stands still") {
  for (const bool lockstep : {false, true}) {
    Moving rig(lockstep);
    rig.velocities[base_x] = 0.0;
    rig.next_tick(hold);
    ChunkBuilder chunk = rig.chunk(Row(8, 0.0));
    chunk.chunk.start_tick += lockstep ? 0 : 1;
    REQUIRE(rig.send_chunk(chunk).code == 0);
    const SafeChunk safe = rig.safe_chunk();
    if (!lockstep) rig.next_tick(hold);
    rig.stop();
    for (std::uint32_t row = 0; row <= ramp_ticks; ++row)
      rig.next_tick_of({hold, hold, row_of(safe, row), hold});
    REQUIRE(rig.is_latched());
    CHECK(std::string(rig.status().cause.view()) ==
          "latched: no standstill 200 ms after the stop: G043 base acted: needs no row that "
          "acts");
  }
}

TEST_CASE("G043 a row that acts after standstill takes the standstill back") {
  Moving rig;
  rig.stop();
  for (int i = 0; i < 3; ++i) rig.speed(0.0);
  rig.velocities[base_x] = 0.5;
  rig.next_tick_of({hold, hold, Acted{0, 4711, 0}, hold});
  for (std::size_t i = 0; i < ramp_ticks; ++i) rig.speed(0.5);
  CHECK(rig.gate->state() == GateState::stopped);
  rig.speed(0.5);
  CHECK(rig.is_latched());
}

TEST_CASE("G043 each part has to be seen at standstill; a passive joint need not") {
  for (const bool arm_stops : {false, true}) {
    Moving rig;
    rig.stop();
    rig.velocities[torso] = 0.2;
    rig.velocities[arm_1] = 0.5;
    rig.speed(0.0);
    if (arm_stops) rig.velocities[arm_1] = 0.0;
    for (int i = 0; i < 5; ++i) rig.speed(0.0);
    CHECK(rig.is_latched() == !arm_stops);
  }
}

TEST_CASE("G043 latched already: the cause grows, is counted and persisted again") {
  Moving rig;
  rig.meet_second_gate();
  REQUIRE(rig.is_latched());
  const std::uint64_t latch_id = rig.status().latch_id;
  for (std::size_t i = 0; i <= ramp_ticks; ++i) rig.speed(0.5);
  CHECK(rig.count(OutputKind::persist_latch) == 1);
  CHECK(rig.counter("G043") == 1);
  CHECK(rig.status().latch_id == latch_id);
  const std::string cause(rig.status().cause.view());
  CHECK(cause.starts_with("latched: two gates serve this robot"));
  CHECK(cause.find("; no standstill 200 ms after the stop: G043 base base_x: 0.5") !=
        std::string::npos);
}

TEST_CASE("G043 a latch of a robot that stood still when asked stays as it was") {
  Moving rig;
  rig.meet_second_gate();
  for (int i = 0; i < 6; ++i) rig.speed(0.0);
  CHECK(rig.counter("G043") == 0);
}

TEST_CASE("G043 a stop that was reset is watched on, armed or not") {
  for (const bool arms : {false, true}) {
    Moving rig;
    rig.stop();
    rig.speed(0.5);
    rig.reset(77);
    REQUIRE(rig.gate->state() == GateState::disarmed);
    if (arms) rig.arm();
    for (std::size_t i = 0; i <= ramp_ticks; ++i) rig.speed(0.5);
    CHECK(rig.is_latched());
    CHECK(rig.counter("G043") == 1);
  }
}

TEST_CASE("G043 what no row moved has no ramp when an unarmed gate stops, or at disarming") {
  GateRig rig;
  rig.limits.protocol.stop_ramp_ms = 200;
  rig.restart(BootInfo{true, false, {}});
  rig.send_hal_status();
  rig.velocities[base_x] = 0.5;
  rig.send_state();
  rig.send(EventKind::stop_level, StopLevel{77, "operator", "now"});
  for (int i = 0; i < 8; ++i) rig.next_tick(hold);
  CHECK(rig.gate->state() == GateState::stopped);
  rig.reset(77);
  rig.arm();
  rig.send(EventKind::disarm, Disarm{"test"});
  for (int i = 0; i < 8; ++i) rig.next_tick(hold);
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("G043 lockstep: a HAL that starts anew counts its ticks from where it is") {
  Moving rig(true);
  rig.stop();
  rig.now_ns += 501 * ms;
  rig.session = 0xBEEF;
  rig.send_hal_status(0xBEEF);
  rig.tick = 5000;
  rig.send_state();
  CHECK(rig.gate->state() == GateState::stopped);
  for (std::size_t i = 0; i < ramp_ticks; ++i) rig.speed(0.5);
  CHECK(rig.gate->state() == GateState::stopped);
  rig.speed(0.5);
  CHECK(rig.is_latched());
}
