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
