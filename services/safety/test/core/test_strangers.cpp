// What nobody expects on the keys: strangers, cut-off names, messages of no known kind.

#include <string>

#include "acted_rows.hpp"
#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("an event of no known kind changes nothing") {
  GateRig rig;
  rig.ready();
  rig.send(static_cast<EventKind>(13), Arm{"test"});
  CHECK(rig.gate->state() == GateState::armed);
  CHECK(rig.out->items().empty());
}

TEST_CASE("a candidate on a key without a source, or with too long a one, gets no verdict") {
  GateRig rig;
  rig.ready();
  const auto frame = rig.chunk().frame();
  const std::string longest(Name::capacity, 'r');
  for (const std::string& source : {std::string(), longest + "r"}) {
    rig.send_frame(EventKind::candidate, frame, source.c_str());
    CHECK(rig.count(OutputKind::verdict) == 0);
  }
  CHECK(rig.counter("G001") == 2);
  rig.send_frame(EventKind::candidate, frame, longest.c_str());
  CHECK(rig.verdict().code == 4);
  CHECK(rig.counter("G001") == 2);
}

TEST_CASE("G002 before any HAL is followed not even session 0 is the right one") {
  GateRig rig;
  rig.session = 0;
  CHECK(rig.send_chunk(rig.chunk()).code == 2);
  rig.send_state();
  CHECK(rig.status().state_tick == 0);
  CHECK(rig.counter("G002") == 1);  // the chunk; states of nobody are ignored uncounted
  rig.send_hal_status(0);
  CHECK(rig.status().session == 0);
  CHECK(rig.count(OutputKind::log) == 0);
}

TEST_CASE("G002 a state of another robot, of session 0 or of tick 0 says nothing") {
  GateRig rig;
  rig.ready();
  const std::uint64_t tick = rig.status().state_tick;
  JointState foreign;
  foreign.session = rig.session;
  foreign.tick = tick + 1;
  foreign.robot_hash = hash_of(8);
  rig.send(EventKind::joint_state, foreign);
  CHECK(rig.status().state_tick == tick);
  CHECK(rig.counter("G002") == 1);
  foreign.robot_hash = hash_of(7);
  foreign.tick = 0;
  rig.send(EventKind::joint_state, foreign);
  CHECK(rig.gate->state() == GateState::armed);
  CHECK(rig.counter("G002") == 1);
  foreign.session = 0;
  rig.send(EventKind::joint_state, foreign);
  CHECK(rig.status().state_tick == tick);
  CHECK(rig.gate->state() == GateState::armed);
}

TEST_CASE("a second HAL is believed in by a valid state of a tick above 0, at once beside none") {
  GateRig rig;
  rig.send_hal_status();
  rig.send_hal_status(77);
  rig.session = 77;
  rig.tick = 0;
  rig.send_state();
  CHECK(rig.status().session == hal_session);
  rig.tick = 1;
  rig.positions[arm_1] = not_a_number;
  rig.send_state();
  CHECK(rig.status().session == hal_session);
  rig.positions[arm_1] = 0.0;
  rig.send_state();
  CHECK(rig.status().session == 77);
}

TEST_CASE("a heartbeat of a claim nobody holds, or on another's key, keeps nothing alive") {
  GateRig rig;
  rig.ready();
  rig.send(EventKind::heartbeat, Heartbeat{rig.claim_id + 1}, "runner");
  for (int i = 0; i < 6; ++i) {
    rig.next_tick();
    rig.send(EventKind::heartbeat, Heartbeat{rig.claim_id}, "other");
  }
  CHECK(rig.status().claims.size() == 1);
  rig.next_tick();
  CHECK(rig.status().claims.empty());
}

TEST_CASE("a lease nobody can read is counted, and is not another gate's") {
  GateRig rig;
  rig.ready();
  rig.send_frame(EventKind::lease, {1, 2, 3});
  CHECK(rig.counter("G001") == 1);
  CHECK(rig.gate->state() == GateState::armed);
}

TEST_CASE("a HAL that lists another number of passive joints does not fit") {
  GateRig rig;
  HalStatus status = rig.hal_status();
  (void)status.passive_joints.push_back("second_torso");
  rig.send(EventKind::hal_status, status);
  rig.send_state();
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(rig.refusal().reason == "the HAL has 2 passive joint, the gate file 1");
}

TEST_CASE("a HAL that changes its pacing under an armed gate disarms it") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();
    rig.lockstep = !lockstep;
    rig.send_hal_status();
    CHECK(rig.gate->state() == GateState::disarmed);
    CHECK(rig.status().cause == (lockstep ? "disarmed: the HAL changed: it paces in realtime now"
                                          : "disarmed: the HAL changed: it paces in lockstep now"));
  }
}

TEST_CASE("a latch record with id 0 is as good as unreadable: latched, under a new id") {
  GateRig rig;
  rig.restart(BootInfo{false, true, frame_of(LatchRecord{0, 5, "why"})});
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.count(OutputKind::persist_latch) == 1);
  CHECK(rig.status().latch_id != 0);
  CHECK(rig.status().cause == "latched before the restart: unreadable");
}

TEST_CASE("a passive joint that comes back inside its bounds is said too") {
  GateRig rig;
  rig.limits.passive_joints[0].jump_limit = 1.0;
  rig.restart(BootInfo{false, true, {}});
  rig.positions[torso] = 0.412;
  rig.ready();
  CHECK(rig.counter("G011") == 1);
  rig.positions[torso] = 0.4;
  rig.next_tick();
  CHECK(rig.count(OutputKind::log) == 1);
  CHECK(rig.counter("G011") == 1);
}

TEST_CASE("parts of one claim that were seen in different rows: nothing continues from that") {
  GateRig rig(true);
  rig.ready();
  ChunkBuilder chunk = rig.chunk();
  chunk.scalar(gripper, Mode::gripper_position, Row(4, 0.04));
  CHECK(rig.send_chunk(chunk).code == 0);
  const SafeChunk safe = rig.safe_chunk();
  rig.next_tick_of({Acted{2, 0, 0}, row_of(safe, 0), row_of(safe, 1), Acted{2, 0, 0}});
  const Verdict verdict = rig.send_chunk(rig.chunk());
  CHECK(verdict.code == 21);
  CHECK(verdict.axis == "acted");
}
