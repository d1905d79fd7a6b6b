// Who has the keys of HAL or gate and speaks in its place: what the gate itself knows gives them
// away.

#include <string>

#include "acted_rows.hpp"
#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

std::string cause(GateRig& rig) { return std::string(rig.status().cause.view()); }

}  // namespace

TEST_CASE("two states of one tick that differ are of two HALs: a stop, named") {
  GateRig rig;
  rig.ready();
  rig.next_tick();
  rig.send_state();  // once more
  CHECK(rig.gate->state() == GateState::armed);
  rig.positions[base_x] += 1e-12;
  rig.send_state();
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(cause(rig) ==
        "stopped: two HALs publish for this robot: a second state of tick 101 of session "
        "000000000000abcd; the newest is of tick 101");
  CHECK(rig.status().stop_ids.size() == 1);
  CHECK(rig.counter("G002") == 1);
  rig.send_state();
  CHECK(rig.status().stop_ids.size() == 1);
  CHECK(rig.counter("G002") == 2);
}

TEST_CASE("before it is armed a second state of a tick is counted, and no good one") {
  GateRig rig;
  rig.restart(BootInfo{false, false, {}});
  rig.send_hal_status();
  for (int i = 0; i < 10; ++i) rig.next_tick();
  rig.efforts[base_x] = 1e-9;
  rig.send_state();
  CHECK(rig.gate->state() == GateState::latched);
  CHECK(rig.counter("G002") == 1);
  rig.reset(rig.status().latch_id);
  CHECK(rig.refusal().reason == "only 0 good joint states since the cause, 10 needed");
}

TEST_CASE("a state that the newest has overtaken may be a late copy: whatever it says is ignored") {
  GateRig rig;
  rig.ready();
  rig.next_tick();
  rig.positions[base_x] += 1e-12;
  --rig.tick;
  for (int i = 0; i < 50; ++i) rig.send_state();
  CHECK(rig.gate->state() == GateState::armed);
  CHECK(rig.counter("G002") == 0);
}

TEST_CASE("a row that the gate did not release latches it; one that it released does not") {
  GateRig rig;
  rig.ready();
  const std::uint64_t first = rig.send_chunk(rig.chunk()).verdict_id;
  const SafeChunk safe = rig.safe_chunk();
  CHECK(safe.verdict_id == first);
  rig.next_tick();
  rig.next_tick(row_of(safe, 0));
  CHECK(rig.gate->state() == GateState::armed);
  const auto acts = [&rig](std::uint64_t verdict) { rig.next_tick(Acted{0, verdict, 0}); };
  SUBCASE("the next, which it has not given yet") {
    const std::uint64_t newest = rig.send_chunk(rig.chunk()).verdict_id;
    acts(newest + 1);
    CHECK(rig.gate->state() == GateState::latched);
    CHECK(rig.lease().grants.empty());
    CHECK(cause(rig) == "latched: two gates serve this robot: arm executed row 0 of verdict " +
                            std::to_string(newest + 1) + ", which this one did not release");
  }
  SUBCASE("a refused one") {
    acts(rig.send_chunk(rig.chunk({9.0})).verdict_id);
    CHECK(rig.gate->state() == GateState::latched);
  }
  SUBCASE("a row after its last") {
    rig.next_tick(row_of(safe, safe.horizon));
    CHECK(rig.gate->state() == GateState::latched);
  }
  SUBCASE("a row of a part that it does not tell anything") {
    rig.next_tick_of({row_of(safe, 1), Acted{1, 0, 0}, row_of(safe, 1), Acted{1, 0, 0}});
    CHECK(rig.gate->state() == GateState::latched);
  }
  SUBCASE("the next, by the part that it has given others to") {
    rig.next_tick_of({Acted{1, 0, 0}, Acted{1, 0, 0}, Acted{0, first + 1, 0}, Acted{1, 0, 0}});
    CHECK(rig.gate->state() == GateState::latched);
  }
  SUBCASE("one of a claim that has ended") {
    rig.send(EventKind::release, Release{"runner", rig.claim_id});
    rig.next_tick(row_of(safe, 1));
    CHECK(rig.gate->state() == GateState::armed);
  }
  SUBCASE("one before its first") {
    acts(first - 1);
    CHECK(rig.gate->state() == GateState::latched);
  }
  SUBCASE("while nothing is armed it may be the last run's") {
    rig.send(EventKind::disarm, Disarm{"me"});
    acts(first - 1);
    CHECK(rig.gate->state() == GateState::disarmed);
  }
}
