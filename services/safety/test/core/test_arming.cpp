// The robot's morning: boot, arm, leases, status, disarm, another HAL.

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

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
  rig.restart(BootInfo{false, true, {}});
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
  CHECK(rig.refusal().fix == "fairlead status");
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

TEST_CASE("armed without a claim for 30 s disarms, in lockstep too") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.connect_and_arm();
    for (int i = 0; i < 601; ++i) rig.next_tick();
    CHECK(rig.gate->state() == GateState::disarmed);
  }
}

TEST_CASE("a new HAL session disarms, and the old one is never followed again") {
  GateRig rig(true);
  rig.ready();
  rig.send_hal_status(0x1111);
  CHECK(rig.gate->state() == GateState::armed);  // announced, but not there yet
  rig.now_ns += 501 * ms;                        // the old one is silent
  rig.session = 0x1111;
  rig.tick = 1;
  rig.send_state();
  CHECK(rig.gate->state() == GateState::disarmed);
  CHECK(rig.lease().session == 0x1111);
  CHECK(rig.lease().state_tick == 1);
  rig.send_hal_status(hal_session);
  rig.session = hal_session;
  rig.timer(25 * ms);
  CHECK(rig.lease().session == 0x1111);
  rig.send_state();  // of the old session
  CHECK(rig.counter("G002") == 1);
  CHECK(rig.status().state_tick == 1);
}

TEST_CASE("G002 counts no state before a HAL is followed, and one of a HAL that comes anew") {
  GateRig rig;
  rig.send_state();
  CHECK(rig.counter("G002") == 0);
  rig.connect_and_arm();
  rig.session = 0x1111;
  for (int i = 0; i < 3; ++i) rig.next_tick();
  CHECK(rig.counter("G002") == 3);  // of nobody who announced itself
  CHECK(rig.status().state_tick == 100);
  rig.send_hal_status(0x1111);
  for (int i = 0; i < 7; ++i) rig.next_tick();
  CHECK(rig.counter("G002") == 4);
  CHECK(rig.status().state_tick == 100);  // still ignored
  for (int i = 0; i < 7; ++i) rig.next_tick();
  CHECK(rig.status().session == 0x1111);
  CHECK(rig.counter("G002") == 4);
}

TEST_CASE("a stray hal/status of another HAL does not shut out the real one") {
  GateRig rig;
  rig.ready();
  rig.send_hal_status(0x1111);
  for (int i = 0; i < 20; ++i) {
    rig.next_tick();
    rig.send_hal_status();
    rig.send_heartbeat();
  }
  CHECK(rig.gate->state() == GateState::armed);
  rig.timer(25 * ms);
  CHECK(rig.lease().session == hal_session);
}

TEST_CASE("two HALs at once disarm, and the cause and the refusal to arm name both") {
  GateRig rig;
  rig.ready();
  rig.send_hal_status(0x1111);
  rig.session = 0x1111;
  rig.send_state();
  CHECK(rig.gate->state() == GateState::disarmed);
  CHECK(rig.status().cause ==
        "disarmed: two HALs publish for this robot: sessions 000000000000abcd and "
        "0000000000001111");
  rig.session = hal_session;
  rig.next_tick();
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(rig.refusal().reason ==
        "two HALs publish for this robot: sessions 000000000000abcd and 0000000000001111");
  for (int i = 0; i < 41; ++i) rig.next_tick();  // the other one has gone
  CHECK(rig.arm().session == hal_session);
}

TEST_CASE("a hal/status that cannot be read is said once, and arming is refused because of it") {
  GateRig rig;
  rig.send_hal_status();
  rig.send_state();
  rig.send_frame(EventKind::hal_status, {0x93});
  CHECK(rig.count(OutputKind::log) == 1);
  rig.send_frame(EventKind::hal_status, {0x93});
  CHECK(rig.count(OutputKind::log) == 0);
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(rig.refusal().reason == "the newest hal/status is unreadable: cut short");
  rig.send_hal_status();
  CHECK(rig.arm().session == hal_session);
}

TEST_CASE("arming waits for the HAL to end the reset of its episode") {
  GateRig rig;
  HalStatus status = rig.hal_status();
  status.state = "resetting";
  rig.send(EventKind::hal_status, status);
  rig.send_state();
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(rig.refusal().reason == "the HAL is resetting its episode");
  rig.send_hal_status();
  CHECK(rig.arm().session == hal_session);
}

TEST_CASE("a HAL that changes its facts under an armed gate disarms it") {
  GateRig rig;
  rig.ready();
  HalStatus changed = rig.hal_status();
  changed.period_ns = 10 * ms;
  rig.send(EventKind::hal_status, changed);
  CHECK(rig.gate->state() == GateState::disarmed);
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
