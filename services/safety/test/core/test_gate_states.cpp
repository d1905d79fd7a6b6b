// The robot's day as the gate sees it: boot, arm, stop, latch, reset.

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

TEST_CASE("before boot the gate answers status and nothing else") {
  GateRig rig;
  CountingIds ids;
  Gate gate(rig.limits, ids);
  const auto frame = frame_of(StatusQuery{});
  gate.step(1, Event{EventKind::status, "", frame, 1}, *rig.out);
  CHECK(rig.reply<GateStatus>().state == 0);
  gate.step(1, Event{EventKind::arm, "", frame_of(Arm{"test"}), 1}, *rig.out);
  CHECK(rig.out->items().empty());
}

TEST_CASE("the first start is disarmed, marks itself clean and grants nothing") {
  GateRig rig;
  CHECK(rig.gate->state() == GateState::disarmed);
  CHECK(rig.count(OutputKind::write_clean_mark) == 1);
  CHECK(rig.lease().state == static_cast<std::uint8_t>(GateState::disarmed));
  CHECK(rig.lease().grants.empty());
}

TEST_CASE("arming needs a HAL that fits the gate file, and a state") {
  GateRig rig;
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(rig.refusal().reason == "no hal/status received yet");
  HalStatus wrong = rig.hal_status();
  SUBCASE("robot hash") { wrong.robot_hash = hash_of(8); }
  SUBCASE("period") { wrong.period_ns = 10 * ms; }
  SUBCASE("joint order") { std::swap(wrong.joints[0], wrong.joints[1]); }
  SUBCASE("joint missing") { (void)wrong.joints.resize(5); }
  SUBCASE("passive joint") { wrong.passive_joints[0] = "lift"; }
  SUBCASE("pacing") { wrong.pacing = "warp"; }
  SUBCASE("fault") { wrong.state = "fault"; }
  rig.send(EventKind::hal_status, wrong);
  rig.send_state();
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(rig.count(OutputKind::refusal) == 1);
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("arming needs a fresh state in realtime and any state in lockstep") {
  GateRig realtime;
  realtime.send_hal_status();
  realtime.send(EventKind::arm, Arm{"test"});
  CHECK(realtime.refusal().reason == "no valid joint state received yet");
  realtime.send_state();
  realtime.timer(251 * ms);
  realtime.send(EventKind::arm, Arm{"test"});
  CHECK(realtime.refusal().reason ==
        "the newest joint state is 251 ms old, at most 250 ms allowed");

  GateRig lockstep(true);
  lockstep.send_hal_status();
  lockstep.send_state();
  lockstep.timer(5000 * ms);
  CHECK(lockstep.arm().session == hal_session);
}

TEST_CASE("lockstep is the gate file's to allow, not a message's") {
  GateRig rig(true);
  rig.limits.lockstep_allowed = false;
  rig.restart(BootInfo{true, false, {}});
  rig.send_hal_status();
  rig.send_state();
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(rig.refusal().reason == "the HAL paces in lockstep, which profile sim does not allow");
}

TEST_CASE(
    "arming starts a new epoch, with leases counted from 1, and takes the clean mark away first") {
  GateRig rig;
  const std::uint64_t before = rig.lease().epoch;
  rig.connect_and_arm();
  CHECK(rig.epoch != before);
  CHECK(rig.lease().epoch == rig.epoch);
  CHECK(rig.lease().lease_seq == 1);
  CHECK(rig.lease().state == static_cast<std::uint8_t>(GateState::armed));
  std::size_t mark = 0, lease = 0, place = 0;
  for (const Output& output : rig.out->items()) {
    ++place;
    if (output.kind == OutputKind::clear_clean_mark) mark = place;
    if (output.kind == OutputKind::lease) lease = place;
  }
  CHECK(mark > 0);
  CHECK(mark < lease);
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(rig.refusal().fix == "fairlead disarm");
}

TEST_CASE("leases come with every state and at least every 25 ms") {
  GateRig rig;
  rig.connect_and_arm();
  rig.next_tick();
  CHECK(rig.lease().state_tick == rig.tick);
  rig.timer(5 * ms);
  CHECK(rig.count(OutputKind::lease) == 0);
  rig.timer(15 * ms);
  CHECK(rig.count(OutputKind::lease) == 0);
  rig.timer(5 * ms);
  CHECK(rig.count(OutputKind::lease) == 1);
}

TEST_CASE("status comes on change and twice a second") {
  GateRig rig;
  rig.connect_and_arm();
  CHECK(rig.count(OutputKind::status) == 1);
  rig.timer(100 * ms);
  CHECK(rig.count(OutputKind::status) == 0);
  rig.timer(100 * ms);
  rig.send_state();
  rig.timer(400 * ms);
  CHECK(rig.count(OutputKind::status) == 1);
}

TEST_CASE("disarming ends every claim; disarming twice is fine") {
  GateRig rig;
  rig.ready();
  CHECK(rig.lease().grants.size() == 1);
  rig.send(EventKind::disarm, Disarm{"test"});
  CHECK(rig.reply<Done>().text == "disarmed");
  CHECK(rig.lease().grants.empty());
  CHECK(rig.count(OutputKind::write_clean_mark) == 1);
  rig.send(EventKind::disarm, Disarm{"test"});
  CHECK(rig.reply<Done>().text == "disarmed");
}

TEST_CASE("armed without a claim for 30 s disarms, in realtime only") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.connect_and_arm();
    for (int i = 0; i < 601; ++i) rig.next_tick();
    CHECK(rig.gate->state() == (lockstep ? GateState::armed : GateState::disarmed));
  }
}

TEST_CASE("a new HAL session disarms, and the old one is never followed again") {
  GateRig rig;
  rig.ready();
  rig.send_hal_status(0x1111);
  CHECK(rig.gate->state() == GateState::disarmed);
  CHECK(rig.lease().session == 0x1111);
  CHECK(rig.lease().state_tick == 0);
  rig.send_hal_status(hal_session);
  rig.timer(25 * ms);
  CHECK(rig.lease().session == 0x1111);
  rig.send_state();  // of the old session
  CHECK(rig.counter("G002") == 1);
  CHECK(rig.status().state_tick == 0);
}

TEST_CASE("a HAL that changes its facts under an armed gate disarms it") {
  GateRig rig;
  rig.ready();
  HalStatus changed = rig.hal_status();
  changed.period_ns = 10 * ms;
  rig.send(EventKind::hal_status, changed);
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("an operator's stop ends claims, is listed in leases, and only its id clears it") {
  GateRig rig;
  rig.ready();
  rig.send(EventKind::stop_level, StopLevel{77, "operator", "test"});
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(rig.lease().stop_ids.contains(77));
  CHECK(rig.lease().grants.empty());
  CHECK(rig.status().fix == "fairlead reset 000000000000004d");
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(rig.refusal().fix == "fairlead reset 000000000000004d");
  rig.send(EventKind::disarm, Disarm{"test"});
  CHECK(rig.count(OutputKind::refusal) == 1);
  rig.reset(78);
  CHECK(rig.refusal().reason == "no stop or latch 000000000000004e is held");
  CHECK(rig.counter("resets_refused") == 1);
  rig.reset(77);
  CHECK(rig.gate->state() == GateState::disarmed);
  rig.send(EventKind::stop_level, StopLevel{77, "operator", "a late copy"});
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("every held stop has to be reset") {
  GateRig rig;
  rig.connect_and_arm();
  rig.send(EventKind::stop_level, StopLevel{77, "operator", "one"});
  rig.send(EventKind::stop_level, StopLevel{88, "runner", "two"});
  CHECK(rig.lease().stop_ids.size() == 2);
  rig.reset(77);
  CHECK(rig.gate->state() == GateState::stopped);
  rig.reset(88);
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("a stop also stops a disarmed gate, and exiting then is not clean") {
  GateRig rig;
  rig.send(EventKind::stop_level, StopLevel{77, "operator", "test"});
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(rig.count(OutputKind::clear_clean_mark) == 1);
  CHECK(rig.count(OutputKind::write_clean_mark) == 0);
}

TEST_CASE("a stop request nobody can read still stops") {
  GateRig rig;
  rig.ready();
  rig.send_frame(EventKind::stop_level, {0x01, 0x02});
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(rig.lease().stop_ids.size() == 1);
  rig.send(EventKind::stop_level, StopLevel{0, "nobody", "no id"});
  CHECK(rig.status().stop_ids.size() == 1);
}

TEST_CASE("more stops than there is room for keep the gate stopped") {
  GateRig rig;
  rig.ready();
  for (std::uint64_t id = 1; id <= max_stops + 4; ++id)
    rig.send(EventKind::stop_level, StopLevel{id, "flood", ""});
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(rig.status().stop_ids.size() == max_stops);
  rig.reset(1);
  rig.send(EventKind::stop_level, StopLevel{max_stops + 1, "flood", ""});
  CHECK(rig.status().stop_ids.contains(max_stops + 1));
}

TEST_CASE("G011 no new state for 250 ms stops an armed gate in realtime") {
  GateRig rig;
  rig.ready();
  rig.timer(250 * ms);
  CHECK(rig.gate->state() == GateState::armed);
  rig.timer(1);
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(std::string(rig.status().cause.view()).find("G011") != std::string::npos);
}

TEST_CASE("G011 a repeated tick is no new state; in lockstep the world may wait") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();
    for (int i = 0; i < 6; ++i) {
      rig.now_ns += 50 * ms;
      rig.send_state();
      rig.send_heartbeat();
    }
    CHECK(rig.gate->state() == (lockstep ? GateState::armed : GateState::stopped));
  }
}

TEST_CASE("G011 a joint that is missing or not finite stops an armed gate, not a disarmed one") {
  for (const double bad : {not_a_number, infinite, -infinite}) {
    GateRig rig;
    rig.send_hal_status();
    rig.positions[arm_2] = bad;
    rig.send_state();
    CHECK(rig.gate->state() == GateState::disarmed);
    rig.positions[arm_2] = 0.0;
    rig.send_state();
    rig.arm();
    rig.velocities[torso] = bad;
    rig.next_tick();
    CHECK(rig.gate->state() == GateState::stopped);
  }
  GateRig rig;
  rig.connect_and_arm();
  rig.positions.pop_back();
  rig.next_tick();
  CHECK(rig.gate->state() == GateState::stopped);
}

TEST_CASE("G013 a measured jump stops; what the robot can do in the ticks between does not") {
  const auto state_after = [](double distance, std::uint64_t ticks) {
    GateRig rig;
    rig.connect_and_arm();
    rig.next_tick();
    rig.positions[arm_1] = distance;
    rig.tick += ticks - 1;
    rig.next_tick();
    return rig.gate->state();
  };
  CHECK(state_after(0.5, 1) == GateState::armed);
  CHECK(state_after(just_above(0.5), 1) == GateState::stopped);
  CHECK(state_after(-0.6, 1) == GateState::stopped);
  CHECK(state_after(1.5, 3) == GateState::armed);
  CHECK(state_after(1.6, 3) == GateState::stopped);
}

TEST_CASE("G013 a continuous joint may be reported in another turn") {
  GateRig rig;
  rig.positions[base_yaw] = 3.1;
  rig.connect_and_arm();
  rig.next_tick();
  rig.positions[base_yaw] = -3.1;
  rig.next_tick();
  CHECK(rig.gate->state() == GateState::armed);
}

TEST_CASE("G013 arming forgets where the robot was before") {
  GateRig rig;
  rig.connect_and_arm();
  rig.next_tick();
  rig.send(EventKind::disarm, Disarm{"test"});
  rig.positions[arm_1] = 1.5;  // an episode reset
  rig.next_tick();
  rig.arm();
  rig.positions[arm_1] = 0.5;  // and a late settling, before the first armed state
  rig.next_tick();
  CHECK(rig.gate->state() == GateState::armed);
}

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
  GateRig spread;
  spread.connect_and_arm();
  for (int i = 0; i < 4; ++i) {
    stop_by_nan(spread);
    CHECK(spread.gate->state() == GateState::stopped);
    come_back(spread);
    spread.tick += 600;  // 30 s
    spread.next_tick();
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
  rig.next_tick();
  for (int i = 0; i < 8; ++i) rig.send_state();  // repeats count
  rig.reset(id);
  CHECK(rig.refusal().reason == "only 9 good joint states since the cause, 10 needed");
  rig.send_state();
  rig.reset(id + 1);
  CHECK(rig.count(OutputKind::refusal) == 1);
  rig.reset(id);
  CHECK(rig.count(OutputKind::clear_latch) == 1);
  CHECK(rig.count(OutputKind::write_clean_mark) == 1);
  CHECK(rig.gate->state() == GateState::disarmed);
  rig.reset(id);  // a late copy
  CHECK(rig.count(OutputKind::refusal) == 1);
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

TEST_CASE("an armed gate of an unreadable query stays as it is") {
  GateRig rig;
  rig.connect_and_arm();
  for (const EventKind kind : {EventKind::arm, EventKind::disarm, EventKind::reset,
                               EventKind::claim, EventKind::release, EventKind::status}) {
    rig.send_frame(kind, {0x93});
    CHECK(rig.refusal().reason == "unreadable request: cut short");
  }
  rig.send_frame(EventKind::disarm, {});
  CHECK(rig.gate->state() == GateState::armed);
}
