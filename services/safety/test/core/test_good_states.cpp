// A latch is reset after ten good states in a row; what was before its cause does not count.

#include <string>

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted hold{2, 0, 0};

void good_states(GateRig& rig, int count) {
  for (int i = 0; i < count; ++i) rig.next_tick(hold);
}

void hear_another_gate(GateRig& rig) {
  Lease lease;
  lease.epoch = 77;
  rig.send(EventKind::lease, lease);
}

std::string refusal_of_reset(GateRig& rig) {
  rig.reset(rig.status().latch_id);
  return std::string(rig.refusal().reason.view());
}

// Latched by another gate's lease, and ten good states ago.
struct Latched : GateRig {
  Latched() {
    limits.protocol.stop_ramp_ms = 1000;
    restart(BootInfo{true, false, {}});
    connect_and_arm();
    hear_another_gate(*this);
    REQUIRE(gate->state() == GateState::latched);
  }
};

}  // namespace

TEST_CASE("ten good states reset a latch, nine do not") {
  Latched rig;
  good_states(rig, 9);
  CHECK(refusal_of_reset(rig).starts_with("only 9 good joint states since the cause, 10 needed"));
  good_states(rig, 1);
  rig.reset(rig.status().latch_id);
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("good states before a latch do not count") {
  GateRig rig;
  rig.connect_and_arm();
  good_states(rig, 20);
  for (int stop = 0; stop < 3; ++stop) {
    rig.take_claim();
    rig.send_chunk(rig.chunk({not_a_number}));
    if (stop == 2) break;
    rig.reset(rig.lease().stop_ids[0]);
    rig.epoch = rig.arm().epoch;
  }
  REQUIRE(rig.gate->state() == GateState::latched);
  CHECK(refusal_of_reset(rig).starts_with("only 0 good joint states"));
}

TEST_CASE("while the other gate is heard no state is good") {
  Latched rig;
  good_states(rig, 10);
  hear_another_gate(rig);
  CHECK(refusal_of_reset(rig).starts_with("only 0 good joint states"));
}

TEST_CASE("a state that is no good one begins the count anew") {
  Latched rig;
  good_states(rig, 10);
  rig.positions[arm_1] = not_a_number;
  rig.next_tick(hold);
  rig.positions[arm_1] = 0.0;
  CHECK(refusal_of_reset(rig).starts_with("only 0 good joint states"));
}

TEST_CASE("rows that act on after a latch begin the count anew when the ramp has passed") {
  Latched rig;
  for (int i = 0; i < 20; ++i) rig.next_tick(Acted{0, 4711, 0});
  CHECK(rig.status().cause.view().find("; ") == std::string_view::npos);
  rig.next_tick(Acted{0, 4711, 0});
  CHECK(rig.status().cause.view().find("; no standstill 1000 ms") != std::string_view::npos);
  CHECK(refusal_of_reset(rig).starts_with("only 1 good joint states"));
}

TEST_CASE("stops of the gate's own count from one HAL session to the next") {
  GateRig rig;
  rig.connect_and_arm();
  for (int stop = 0; stop < 2; ++stop) {
    rig.take_claim();
    rig.send_chunk(rig.chunk({not_a_number}));
    rig.reset(rig.lease().stop_ids[0]);
    rig.epoch = rig.arm().epoch;
  }
  rig.send(EventKind::disarm, Disarm{"test"});
  rig.session = 2;
  rig.send_hal_status(2);
  rig.now_ns += 600 * ms;
  rig.tick = 0;
  rig.next_tick(hold);
  rig.epoch = rig.arm().epoch;
  rig.take_claim();
  rig.send_chunk(rig.chunk({not_a_number}));
  CHECK(rig.gate->state() == GateState::latched);
}

TEST_CASE("copies of a stop that went on under a new arming are a new one, and reset as such") {
  GateRig rig;
  rig.connect_and_arm();
  const auto copy = [&rig] { rig.send(EventKind::stop_level, StopLevel{7, "operator", ""}); };
  copy();
  rig.reset(7);
  rig.epoch = rig.arm().epoch;
  while (rig.gate->state() == GateState::armed) {
    rig.next_tick(hold);
    copy();
  }
  REQUIRE(rig.gate->state() == GateState::stopped);
  good_states(rig, 60);
  rig.reset(7);
  REQUIRE(rig.gate->state() == GateState::disarmed);
  copy();
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("lockstep: a lost state, behind which the world came to stand, keeps no latch") {
  for (const bool lockstep : {false, true}) {
    CAPTURE(lockstep);
    GateRig rig(lockstep);
    rig.restart(BootInfo{false, false, {}});
    rig.send_hal_status();
    rig.next_tick();
    ++rig.tick;  // in this one it moved
    rig.positions[arm_1] += 0.1;
    rig.next_tick();
    rig.reset(rig.status().latch_id);
    CHECK(rig.refusal().reason == "a joint is still moving");
    for (int i = 0; i < 10; ++i) rig.send_state();  // it stands, and the world waits
    rig.reset(rig.status().latch_id);
    CHECK(rig.gate->state() == (lockstep ? GateState::disarmed : GateState::latched));
  }
}
