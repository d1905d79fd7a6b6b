// What stops the robot: operators, and G011 and G013 on the measured state.

#include <string>

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

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
  for (std::uint64_t id = 1; id <= max_stops; ++id)  // the last place is for all others
    CHECK(rig.status().stop_ids.contains(id) == (id < max_stops));
  rig.reset(1);
  rig.send(EventKind::stop_level, StopLevel{max_stops + 1, "flood", ""});
  CHECK(rig.status().stop_ids.contains(max_stops + 1));
  for (std::uint64_t id = 1; id <= max_stops + 1; ++id) rig.reset(id);
  CHECK(rig.gate->state() == GateState::stopped);  // for those that found no place
  REQUIRE(rig.status().stop_ids.size() == 1);
  rig.reset(rig.status().stop_ids[0]);
  CHECK(rig.gate->state() == GateState::disarmed);
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
    rig.pass(ticks - 1);
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

TEST_CASE("G011 a state that does not say what every part did stops") {
  GateRig rig;
  rig.connect_and_arm();
  rig.part_count = 3;
  rig.next_tick();
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(rig.counter("G011") == 1);
}

TEST_CASE("states that are late, unreadable or another robot's change nothing") {
  GateRig rig;
  rig.ready();
  rig.next_tick();
  const std::uint64_t newest = rig.tick;
  rig.tick = newest - 1;
  rig.send_state();
  rig.tick = 0;
  rig.send_state();
  rig.send_frame(EventKind::joint_state, {0x9B, 0x01});
  rig.send_frame(EventKind::hal_status, {0x9B, 0x01});
  rig.send_frame(EventKind::heartbeat, {0x93});
  CHECK(rig.status().state_tick == newest);
  CHECK(rig.counter("G001") == 3);
  CHECK(rig.gate->state() == GateState::armed);
}

TEST_CASE("G013 a state cannot claim more ticks than periods can have passed, and is not taken") {
  GateRig rig;
  rig.connect_and_arm();
  rig.next_tick();
  const std::uint64_t honest = rig.tick;
  rig.tick += 2;
  rig.next_tick();  // three ticks in one period
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(std::string(rig.status().cause.view()).find("G013 tick") != std::string::npos);
  CHECK(rig.status().state_tick == honest);
  rig.tick = honest;
  rig.next_tick();
  CHECK(rig.status().state_tick == honest + 1);  // later honest states count
  rig.tick += 5000;                              // also where a state cannot stop anything
  rig.next_tick();
  CHECK(rig.status().state_tick == honest + 1);
}

TEST_CASE("copies of a reset stop are ignored and counted until none came for two seconds") {
  GateRig rig;
  rig.connect_and_arm();
  const auto press = [&rig] { rig.send(EventKind::stop_level, StopLevel{5, "e-stop", ""}); };
  press();
  rig.reset(5);
  for (int i = 0; i < 3; ++i) {
    rig.timer(1900 * ms);
    press();
    CHECK(rig.gate->state() == GateState::disarmed);
  }
  CHECK(rig.counter("stops_ignored") == 3);
  rig.timer(2001 * ms);
  press();  // the same button, pressed again
  CHECK(rig.gate->state() == GateState::stopped);
}

TEST_CASE("copies of a reset stop that go on under a new arming are a new stop") {
  GateRig rig(true);
  rig.connect_and_arm();
  rig.send(EventKind::stop_level, StopLevel{5, "e-stop", ""});
  rig.reset(5);
  rig.arm();
  for (int i = 0; i < 40; ++i) {
    rig.timer(50 * ms);
    rig.send(EventKind::stop_level, StopLevel{5, "e-stop", ""});
    CHECK(rig.gate->state() == GateState::armed);
  }
  rig.timer(50 * ms);
  rig.send(EventKind::stop_level, StopLevel{5, "e-stop", ""});
  CHECK(rig.gate->state() == GateState::stopped);
}

TEST_CASE("G013 a state that came late is no measure for those after it") {
  GateRig rig;
  rig.connect_and_arm();
  rig.next_tick();
  rig.now_ns += 150 * ms;  // this one spends three periods on the way
  rig.next_tick();
  rig.tick += 3;  // what was sent meanwhile is lost; the next comes in time
  rig.now_ns += 1 * ms;
  rig.tick += 1;
  rig.send_state();
  CHECK(rig.gate->state() == GateState::armed);
}

TEST_CASE("G013 a tick count that is confirmed by a second state is taken, after the stop") {
  GateRig rig;
  rig.connect_and_arm();
  rig.next_tick();
  rig.tick += 20;  // everything before came a second late, or the HAL's clock was changed
  rig.next_tick();
  CHECK(rig.gate->state() == GateState::stopped);
  rig.next_tick();
  CHECK(rig.status().state_tick == rig.tick);
  CHECK(rig.gate->state() == GateState::stopped);
}
