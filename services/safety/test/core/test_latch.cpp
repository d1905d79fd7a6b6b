// When stopping is not enough: the latch, across restarts, and the way back.

#include <string>

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// Raise one stop of the gate's own and come back to armed, as a patient operator would.
void stop_by_nan(GateRig& rig) {
  rig.take_claim();
  rig.send_chunk(rig.chunk({not_a_number}));
}

void come_back(GateRig& rig) {
  rig.reset(rig.lease().stop_ids[0]);
  rig.epoch = rig.arm().epoch;
}

}  // namespace

TEST_CASE("three stops of the gate's own within 60 s of ticks latch") {
  GateRig rig;
  rig.connect_and_arm();
  stop_by_nan(rig);
  CHECK(rig.gate->state() == GateState::stopped);
  come_back(rig);
  stop_by_nan(rig);
  CHECK(rig.gate->state() == GateState::stopped);
  come_back(rig);
  stop_by_nan(rig);
  CHECK(rig.gate->state() == GateState::latched);
  std::size_t lease = 0, persist = 0, place = 0;
  for (const Output& output : rig.out->items()) {
    ++place;
    if (output.kind == OutputKind::lease) lease = place;
    if (output.kind == OutputKind::persist_latch) persist = place;
  }
  CHECK(lease > 0);
  CHECK(lease < persist);  // the hold goes out before the disk is touched
}

TEST_CASE("stops spread wider than the window do not latch, nor do an operator's") {
  GateRig spaced;
  spaced.connect_and_arm();
  for (int i = 0; i < 4; ++i) {
    stop_by_nan(spaced);
    CHECK(spaced.gate->state() == GateState::stopped);
    spaced.pass(600);                                            // 30 s
    for (int state = 0; state < 3; ++state) spaced.next_tick();  // seen at standstill
    come_back(spaced);
  }
  GateRig operators;
  operators.connect_and_arm();
  for (std::uint64_t id = 1; id <= 5; ++id) {
    operators.send(EventKind::stop_level, StopLevel{id, "operator", ""});
    CHECK(operators.gate->state() == GateState::stopped);
    operators.reset(id);
    operators.arm();
  }
}

namespace {

GateRig latched_rig() {
  GateRig rig;
  rig.restart(BootInfo{false, false, {}});
  return rig;
}

}  // namespace

TEST_CASE("an unclean exit boots latched and says so") {
  GateRig rig = latched_rig();
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.count(OutputKind::persist_latch) == 1);
  const auto record = rig.get<LatchRecord>(OutputKind::persist_latch);
  CHECK(record.latch_id == rig.status().latch_id);
  CHECK(std::string(rig.status().cause.view()).find("not clean") != std::string::npos);
}

TEST_CASE("a clean exit boots disarmed") {
  GateRig rig;
  rig.restart(BootInfo{false, true, {}});
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("a latch outlives the process, with its id; unreadable it latches all the same") {
  GateRig rig;
  const auto record = frame_of(LatchRecord{4711, 5, "the cause"});
  rig.restart(BootInfo{false, true, record});
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.status().latch_id == 4711);
  CHECK(rig.status().cause == "latched before the restart: the cause");
  const std::vector<std::uint8_t> garbage{1, 2, 3};
  rig.restart(BootInfo{false, true, garbage});
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.status().latch_id != 0);
}

TEST_CASE("a latch is reset by its id, at standstill, after ten good states, to disarmed") {
  GateRig rig = latched_rig();
  const std::uint64_t id = rig.status().latch_id;
  rig.reset(id);
  CHECK(rig.refusal().reason == "no joint state received: standstill is not known");
  rig.send_hal_status();
  rig.velocities[arm_1] = 0.05;
  for (int i = 0; i < 10; ++i) rig.next_tick();
  rig.reset(id);
  CHECK(rig.refusal().reason == "a joint is still moving");
  rig.velocities[arm_1] = just_below(0.05);
  rig.positions[arm_1] = not_a_number;
  rig.next_tick();  // the cause is back: counting starts again
  rig.positions[arm_1] = 0.0;
  for (int i = 0; i < 9; ++i) rig.next_tick();
  rig.send_state();  // a copy
  rig.reset(id);
  CHECK(rig.refusal().reason == "only 9 good joint states since the cause, 10 needed");
  rig.next_tick();
  rig.reset(id + 1);
  CHECK(rig.count(OutputKind::refusal) == 1);
  rig.reset(id);
  CHECK(rig.count(OutputKind::clear_latch) == 1);
  CHECK(rig.count(OutputKind::write_clean_mark) == 1);
  CHECK(rig.gate->state() == GateState::disarmed);
  rig.reset(id);  // a late copy
  CHECK(rig.count(OutputKind::refusal) == 1);
}

TEST_CASE("where two persons are asked for, one alone does not reset a latch") {
  GateRig rig;
  rig.limits.protocol.second_person_s = 60;
  rig.restart(BootInfo{false, false, {}});
  rig.send_hal_status();
  for (int i = 0; i < 10; ++i) rig.next_tick();
  const std::uint64_t id = rig.status().latch_id;
  const auto asks = [&](const char* by) {
    rig.send(EventKind::reset, Reset{by, id});
    return rig.gate->state() == GateState::disarmed;
  };
  const auto passes = [&](std::uint64_t time_ns) {
    rig.now_ns += time_ns - rig.limits.period_ns;
    rig.next_tick();
  };
  CHECK_FALSE(asks("ada@lab (fairlead)"));
  const std::string text =
      "ada@lab (fairlead) asked to reset the latch; another person has to ask too, within 60 s";
  CHECK(rig.refusal().reason == text.c_str());
  const Text fix = rig.refusal().fix;
  CHECK(fix == rig.status().fix);
  CHECK_FALSE(asks("ada@another.host (a program)"));
  CHECK_FALSE(asks("@lab"));  // nobody
  CHECK_FALSE(asks("ben"));   // nobody asked before
  passes(60'000 * ms + 1);
  CHECK_FALSE(asks("ada"));  // too late: ben's is over
  passes(60'000 * ms);
  rig.reset(id + 1);
  CHECK(rig.refusal().reason.view().ends_with("is held"));
  CHECK(asks("ben@lab"));
  CHECK(rig.count(OutputKind::clear_latch) == 1);
  CHECK(rig.status().cause.view().ends_with("was reset by ada and ben@lab"));

  Lease foreign;
  foreign.epoch = 5;
  rig.send(EventKind::lease, foreign);  // of a second gate: another latch
  for (int i = 0; i < 10; ++i) rig.next_tick();
  const std::uint64_t next = rig.status().latch_id;
  rig.send(EventKind::reset, Reset{"cleo", next});
  CHECK(rig.gate->state() == GateState::latched);  // nobody asked to reset this one
  rig.send(EventKind::stop_level, StopLevel{77, "cleo", ""});
  rig.reset(77);  // a stop takes one person
  CHECK(rig.reply<Done>().text == "000000000000004d was reset");
  rig.send(EventKind::reset, Reset{"ada", next});
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE(
    "a latch is reset after ten states at standstill: one may be a motion that turns around") {
  GateRig rig = latched_rig();
  rig.send_hal_status();
  for (int i = 0; i < 9; ++i) rig.next_tick();
  rig.velocities[arm_1] = 0.05;
  rig.next_tick();
  rig.velocities[arm_1] = 0.0;
  for (int i = 0; i < 9; ++i) rig.next_tick();
  rig.reset(rig.status().latch_id);
  CHECK(rig.refusal().reason == "only 9 good joint states since the cause, 10 needed");
  rig.next_tick();
  rig.reset(rig.status().latch_id);
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("a latched gate lists stops, and leads through stopped when one is still held") {
  GateRig rig = latched_rig();
  rig.send_hal_status();
  for (int i = 0; i < 10; ++i) rig.next_tick();
  rig.send(EventKind::stop_level, StopLevel{77, "operator", ""});
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.lease().stop_ids.contains(77));
  rig.reset(rig.status().latch_id);
  CHECK(rig.gate->state() == GateState::stopped);
  rig.reset(77);
  CHECK(rig.gate->state() == GateState::disarmed);

  GateRig other = latched_rig();
  other.send(EventKind::stop_level, StopLevel{77, "operator", ""});
  other.reset(77);
  CHECK(other.gate->state() == GateState::latched);
  CHECK(other.reply<Done>().text == "000000000000004d was reset");
}

TEST_CASE("a latch is not reset on a state from long ago") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.restart(BootInfo{false, false, {}});
    rig.send_hal_status();
    for (int i = 0; i < 10; ++i) rig.next_tick();
    const std::uint64_t limit_ms = lockstep ? 500 : 250;
    rig.timer((limit_ms + 1) * ms);
    rig.reset(rig.status().latch_id);
    CHECK(rig.count(OutputKind::refusal) == 1);
    CHECK(rig.gate->state() == GateState::latched);
    rig.send_state();  // a repeat shows that the robot is there, in lockstep
    if (!lockstep) {
      rig.reset(rig.status().latch_id);
      CHECK(rig.gate->state() == GateState::latched);
      rig.next_tick();
    }
    rig.timer(limit_ms * ms);
    rig.reset(rig.status().latch_id);
    CHECK(rig.gate->state() == GateState::disarmed);
  }
}

TEST_CASE("leases of another gate latch, in any state, and hold the latch while they come") {
  GateRig rig;
  rig.ready();
  const Lease own = rig.lease();
  rig.send(EventKind::lease, own);  // this gate's own, on its way round
  CHECK(rig.gate->state() == GateState::armed);
  Lease foreign = own;
  foreign.epoch = 0x1234567;
  rig.send(EventKind::lease, foreign);
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.lease().grants.empty());
  CHECK(std::string(rig.status().cause.view()).find("two gates") != std::string::npos);
  for (int i = 0; i < 10; ++i) rig.next_tick();
  rig.send(EventKind::lease, foreign);
  rig.reset(rig.status().latch_id);
  CHECK(rig.count(OutputKind::refusal) == 1);
  for (int i = 0; i < 10; ++i) rig.next_tick();
  rig.reset(rig.status().latch_id);
  CHECK(rig.gate->state() == GateState::disarmed);
  rig.send(EventKind::lease, foreign);
  CHECK(rig.gate->state() == GateState::latched);
}

TEST_CASE("the numbers of a foreign lease are left behind: by its latch, and by that one's reset") {
  GateRig rig;
  rig.ready();
  const auto ahead = [&rig] {
    Lease foreign = rig.lease();
    foreign.lease_seq += 1000;
    return foreign;
  };
  const Lease foreign = ahead();
  rig.send(EventKind::lease, foreign);
  const std::uint64_t latched = rig.lease().epoch;
  CHECK(latched != foreign.epoch);
  for (int i = 0; i < 10; ++i) rig.next_tick();
  rig.reset(rig.status().latch_id);
  CHECK(rig.lease().epoch == latched);  // in which nobody else spoke

  rig.send(EventKind::lease, ahead());
  rig.next_tick();
  rig.send(EventKind::lease, ahead());
  rig.next_tick();
  const std::uint64_t overtaken = rig.lease().epoch;
  for (int i = 0; i < 10; ++i) rig.next_tick();
  rig.reset(rig.status().latch_id);
  CHECK(rig.gate->state() == GateState::disarmed);
  CHECK(rig.lease().epoch != overtaken);
}

TEST_CASE("hardware: a state folder that was never used boots latched unless that is right") {
  GateRig rig;
  rig.limits.lockstep_allowed = false;
  rig.restart(BootInfo{true, false, {}});
  CHECK(rig.gate->state() == GateState::latched);
  rig.restart(BootInfo{true, false, {}, true});
  CHECK(rig.gate->state() == GateState::disarmed);
}
