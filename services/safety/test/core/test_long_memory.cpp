// What the gate remembers, for how long, and what it must have forgotten.

#include <string>

#include "acted_rows.hpp"
#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("a reset stop is forgotten 2 s after its last copy: exactly then it is still a copy") {
  GateRig rig;
  const auto stopped_by_copy_after = [&rig](std::uint64_t pause) {
    rig.now_ns += pause;
    rig.send(EventKind::stop_level, StopLevel{5, "you", "because"});
    return rig.gate->state() == GateState::stopped;
  };
  CHECK(stopped_by_copy_after(0));
  rig.reset(5);
  CHECK_FALSE(stopped_by_copy_after(2000 * ms));
  CHECK_FALSE(stopped_by_copy_after(2000 * ms));
  CHECK(stopped_by_copy_after(2000 * ms + 1));
  rig.reset(5);
  CHECK_FALSE(stopped_by_copy_after(1));
}

TEST_CASE("copies that go on for 2 s under a new arming are a new stop, and then no copies") {
  GateRig rig;
  rig.send(EventKind::stop_level, StopLevel{5, "you", "because"});
  rig.reset(5);
  rig.connect_and_arm();
  const std::uint64_t armed_ns = rig.now_ns;
  while (rig.now_ns < armed_ns + 2000 * ms) {
    rig.next_tick();
    rig.send(EventKind::stop_level, StopLevel{5, "you", "because"});
    CHECK(rig.gate->state() == GateState::armed);
  }
  CHECK(rig.now_ns == armed_ns + 2000 * ms);
  rig.next_tick();
  rig.send(EventKind::stop_level, StopLevel{5, "you", "because"});
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(rig.counter("stops_ignored") == 40);
}

TEST_CASE(
    "armed without a claim, a gate disarms after more than 30 s, counted from the last claim") {
  GateRig rig;
  rig.ready();
  const auto live = [&rig](std::uint64_t ticks) {
    for (std::uint64_t i = 0; i < ticks; ++i) {
      rig.next_tick();
      if (rig.claim_id != 0) rig.send_heartbeat();
    }
  };
  live(800);  // 40 s with a claim
  CHECK(rig.gate->state() == GateState::armed);
  rig.send(EventKind::release, Release{"runner", rig.claim_id});
  rig.claim_id = 0;
  live(600);
  CHECK(rig.gate->state() == GateState::armed);
  live(1);
  CHECK(rig.gate->state() == GateState::disarmed);
  CHECK(rig.status().cause == "disarmed: no claim for 30 s");
}

TEST_CASE("a status comes after 500 ms, not before") {
  GateRig rig;
  rig.timer(0);
  rig.timer(500 * ms - 1);
  CHECK(rig.count(OutputKind::status) == 0);
  rig.timer(1);
  CHECK(rig.count(OutputKind::status) == 1);
  rig.timer(1);
  CHECK(rig.count(OutputKind::status) == 0);
}

TEST_CASE("what goes to disk goes once: the clean mark, its removal and the latch") {
  GateRig rig;
  CHECK(rig.count(OutputKind::write_clean_mark) == 1);
  rig.timer(1);
  CHECK(rig.count(OutputKind::write_clean_mark) == 0);
  rig.send(EventKind::lease, Lease{});
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.count(OutputKind::clear_clean_mark) == 1);
  CHECK(rig.count(OutputKind::persist_latch) == 1);
  rig.timer(1);
  CHECK(rig.count(OutputKind::persist_latch) == 0);
  GateRig armed;
  armed.connect_and_arm();
  armed.send(EventKind::lease, Lease{});
  CHECK(armed.gate->state() == GateState::latched);
  CHECK(armed.count(OutputKind::clear_clean_mark) == 0);  // gone since arming
}

TEST_CASE("a gate that boots says so with what it was given, and with nothing older") {
  GateRig rig;
  rig.send(EventKind::arm, Arm{"test"});
  rig.now_ns += 5000 * ms;
  rig.restart(BootInfo{false, true, {}});
  CHECK(rig.count(OutputKind::refusal) == 0);
  CHECK(rig.count(OutputKind::status) == 1);
  rig.timer(1);
  CHECK(rig.count(OutputKind::status) == 0);
}

TEST_CASE("resetting a stop, a lease and a status say so at once; what is still held is named") {
  GateRig rig;
  rig.connect_and_arm();
  for (const std::uint64_t id : {77ULL, 88ULL, 99ULL})
    rig.send(EventKind::stop_level, StopLevel{id, "operator", "test"});
  rig.reset(77);
  CHECK(rig.count(OutputKind::lease) == 1);
  CHECK(rig.count(OutputKind::status) == 1);
  CHECK(rig.status().cause == "stopped: 0000000000000058 is still held");
  rig.reset(1);
  CHECK(rig.refusal().fix == "fairlead reset 0000000000000058");
  rig.send(EventKind::disarm, Disarm{"test"});
  const Refusal refusal = rig.refusal();
  CHECK(refusal.fix == "fairlead reset 0000000000000058");
  CHECK(std::string(refusal.reason.view()).find("the gate is stopped, not armed") == 0);
}

TEST_CASE("arming on a state of exactly 250 ms is allowed") {
  GateRig rig;
  rig.send_hal_status();
  rig.send_state();
  rig.timer(250 * ms);
  CHECK(rig.arm().session == hal_session);
}

TEST_CASE("a latched gate tells how to get out while a joint moves") {
  GateRig rig;
  rig.connect_and_arm();
  rig.send(EventKind::lease, Lease{});
  const Text fix = rig.status().fix;
  rig.velocities[arm_1] = -1.0;
  rig.next_tick();
  rig.reset(rig.status().latch_id);
  const Refusal refusal = rig.refusal();
  CHECK(refusal.reason == "a joint is still moving");
  CHECK(refusal.fix == fix);
}

TEST_CASE("an unreadable stop is counted") {
  GateRig rig;
  rig.send_frame(EventKind::stop_level, {1});
  CHECK(rig.counter("G001") == 1);
  rig.send_frame(EventKind::disarm, {1});
  CHECK(rig.counter("G001") == 2);
}

TEST_CASE("lines of the log are their bytes") {
  GateRig rig;
  rig.connect_and_arm();
  bool found = false;
  rig.send(EventKind::disarm, Disarm{"me"});
  for (const Output& output : rig.out->items()) {
    if (output.kind != OutputKind::log) continue;
    const Bytes line = rig.out->payload(output);
    found = std::string(line.begin(), line.end()) == "disarmed: by me";
  }
  CHECK(found);
}

TEST_CASE("twenty chunks one after the other: each goes on from the row of the one before") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();
    SafeChunk running;
    for (int i = 0; i < 20; ++i) {
      const double speed = 0.05 * i;
      const Verdict verdict = rig.send_chunk(rig.chunk(Row(6, speed)));
      CHECK(verdict.code == 0);
      const SafeChunk safe = rig.safe_chunk();
      if (i > 1) CHECK(safe.after.hold == 0);
      if (i > 1) CHECK(safe.after.verdict_id != 0);
      const std::uint64_t acted_tick = rig.tick;
      const Acted act = safe.first_tick <= acted_tick ? row_of(safe, 0) : obey(running, acted_tick);
      rig.next_tick(i == 0 && !lockstep ? Acted{2, 0, 0} : act);
      rig.send_heartbeat();
      running = safe;
    }
    CHECK(rig.gate->state() == GateState::armed);
    CHECK(rig.counter("truncated") == 0);
  }
}
