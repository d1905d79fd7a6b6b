// Until when a lease grants, in realtime.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

std::uint64_t granted_until(GateRig& rig) {
  REQUIRE(rig.lease().grants.size() == 1);
  return rig.lease().grants[0].until_tick;
}

}  // namespace

TEST_CASE("a grant is for 75 ms, in whole ticks, from the first tick there is") {
  GateRig rig;
  rig.tick = 1;
  rig.ready();
  rig.next_tick();
  CHECK(rig.lease().state_tick == 2);
  CHECK(granted_until(rig) == 4);
}

TEST_CASE("a grant of whole ticks and a nanosecond lasts a tick more") {
  GateRig rig;
  rig.limits.period_ns = 2'027'027;  // 37 of them are 74,999,999 ns
  rig.restart(BootInfo{true, false, {}});
  HalStatus status = rig.hal_status();
  status.period_ns = 2'027'027;
  rig.send(EventKind::hal_status, status);
  rig.send_state();
  rig.arm();
  Claim claim = rig.claim_request();
  claim.period_ns = 2'027'027;
  rig.send(EventKind::claim, claim);
  ++rig.tick;
  rig.now_ns += 2'027'027;
  rig.send_state();
  CHECK(granted_until(rig) == rig.tick + 38);
}
