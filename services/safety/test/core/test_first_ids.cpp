// Ids that a gate draws, and HAL sessions with the smallest number there is.

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("a gate draws its first epoch, then half of what its verdicts count on from") {
  GateRig rig;  // draws 1001, 1002 and so on
  CHECK(rig.status().epoch == 1001);
  rig.ready();
  CHECK(rig.epoch == 1003);
  CHECK(rig.claim_id == 1004);
  CHECK(rig.send_chunk(rig.chunk()).verdict_id == 502);
  CHECK(rig.send_chunk(rig.chunk()).verdict_id == 503);
}

namespace {

// An epoch, then 1: of that no half is left, and verdicts count from 1.
class SmallIds : public IdSource {
 public:
  std::uint64_t next_id() override { return ++drawn_ == 2 ? 1 : 1000 + drawn_; }

 private:
  std::uint64_t drawn_ = 0;
};

}  // namespace

TEST_CASE("verdict 1 is one like any other: its row is the gate's own, also after its claim") {
  SmallIds ids;
  GateRig rig;
  rig.gate = std::make_unique<Gate>(rig.limits, ids);
  rig.gate->boot(rig.now_ns, BootInfo{true, false, {}}, *rig.out);
  rig.ready();
  REQUIRE(rig.send_chunk(rig.chunk()).verdict_id == 1);
  rig.next_tick();
  rig.next_tick(Acted{0, 1, 0});
  rig.send(EventKind::release, Release{"runner", rig.claim_id});
  rig.next_tick(Acted{0, 1, 1});
  CHECK(rig.gate->state() == GateState::armed);
}

TEST_CASE("HAL session 1 is followed like any other, and once left is never followed again") {
  GateRig rig;
  rig.session = 1;
  rig.send_hal_status(1);
  rig.send_state();
  CHECK(rig.status().session == 1);
  CHECK(rig.status().state_tick == rig.tick);
  rig.session = 2;
  rig.send_hal_status(2);
  rig.now_ns += 600 * ms;
  rig.next_tick();
  CHECK(rig.status().session == 2);
  rig.session = 1;
  rig.send_hal_status(1);
  rig.now_ns += 600 * ms;
  rig.next_tick();
  CHECK(rig.status().session == 2);
}

TEST_CASE("HAL session 1 follows another that has gone") {
  GateRig rig;
  rig.session = 5;
  rig.send_hal_status(5);
  rig.send_state();
  rig.session = 1;
  rig.send_hal_status(1);
  rig.now_ns += 600 * ms;
  rig.next_tick();
  CHECK(rig.status().session == 1);
}

TEST_CASE("no session has number 0: its states and its status are nobody's") {
  GateRig rig;
  rig.send_hal_status();
  rig.send_state();
  rig.now_ns += 600 * ms;
  rig.session = 0;
  rig.next_tick();
  rig.send_hal_status(0);
  rig.now_ns += 600 * ms;
  rig.next_tick();
  CHECK(rig.status().session == hal_session);
}
