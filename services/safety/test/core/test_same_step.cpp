// Two things in one step: what the first left to be done is not done after the second.

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// Armed for just under 30 s without a claim; the next event disarms before it is looked at.
struct LongIdle : GateRig {
  LongIdle() {
    connect_and_arm();
    const std::uint64_t armed_ns = now_ns;
    while (now_ns - armed_ns < 30'000 * ms) next_tick();
    REQUIRE(gate->state() == GateState::armed);
    now_ns += 1;
  }
};

}  // namespace

TEST_CASE("armed again in the step that disarmed: the exit is not marked clean") {
  LongIdle rig;
  rig.send(EventKind::arm, Arm{"test"});
  CHECK(rig.gate->state() == GateState::armed);
  CHECK(rig.count(OutputKind::clear_clean_mark) == 1);
  CHECK(rig.count(OutputKind::write_clean_mark) == 0);
}

TEST_CASE("stopped in the step that disarmed: the exit is not marked clean") {
  LongIdle rig;
  rig.send(EventKind::stop_level, StopLevel{7, "operator", "now"});
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(rig.count(OutputKind::write_clean_mark) == 0);
}

TEST_CASE("latched in the step that disarmed: the exit is not marked clean") {
  LongIdle rig;
  Lease lease;
  lease.epoch = 77;  // nobody's here: another gate
  rig.send(EventKind::lease, lease);
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.count(OutputKind::write_clean_mark) == 0);
}

TEST_CASE("a stop reset while latched goes out at once, and the latch stays") {
  GateRig rig;
  rig.connect_and_arm();
  rig.send(EventKind::stop_level, StopLevel{7, "operator", "now"});
  Lease lease;
  lease.epoch = 77;
  rig.send(EventKind::lease, lease);
  REQUIRE(rig.gate->state() == GateState::latched);
  rig.reset(7);
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.count(OutputKind::status) == 1);
  CHECK(rig.lease().stop_ids.empty());
}
