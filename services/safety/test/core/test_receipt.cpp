// How old something is counts from when it came in, not from when the gate got to it: what waited
// behind a long step is no newer by that.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

struct Late : GateRig {
  explicit Late(bool in_lockstep = false) : GateRig(in_lockstep) { ready(); }

  // Came in at `received_ns`, gets its turn now.
  void handle(EventKind kind, const auto& message, std::uint64_t received_ns) {
    const std::vector<std::uint8_t> frame = frame_of(message);
    gate->step(now_ns, Event{kind, "runner", frame, received_ns}, *out);
  }
  void handle_state(std::uint64_t of_tick, std::uint64_t received_ns) {
    JointState state;
    state.session = session;
    state.tick = of_tick;
    const std::vector<double> none(measured_count, 0.0);
    state.positions = state.velocities = state.efforts = NumberView(
        Bytes(reinterpret_cast<const std::uint8_t*>(none.data()), none.size() * sizeof(double)));
    for (std::size_t i = 0; i < part_count; ++i) (void)state.acted.push_back(Acted{2, 0, 0});
    state.robot_hash = hash_of(7);
    handle(EventKind::joint_state, state, received_ns);
  }
  [[nodiscard]] bool holds_claim() { return !status().claims.empty(); }
};

}  // namespace

TEST_CASE("a heartbeat that waited for its turn is as old as its arrival") {
  for (const std::uint64_t waited : {0 * ms, 200 * ms}) {
    Late rig(true);
    const std::uint64_t claimed_ns = rig.now_ns;
    rig.now_ns += 1900 * ms;
    rig.handle(EventKind::heartbeat, Heartbeat{rig.claim_id}, rig.now_ns - waited);
    rig.timer(2000 * ms - waited);
    CHECK(rig.holds_claim());
    rig.timer(1);
    CHECK_FALSE(rig.holds_claim());
    CHECK(rig.now_ns > claimed_ns);
  }
}

TEST_CASE("a heartbeat that comes out of order takes nothing back, and none is from the future") {
  Late rig(true);
  const std::uint64_t began_ns = rig.now_ns;
  rig.now_ns += 1000 * ms;
  rig.handle(EventKind::heartbeat, Heartbeat{rig.claim_id}, UINT64_MAX);
  rig.handle(EventKind::heartbeat, Heartbeat{rig.claim_id}, began_ns);
  rig.timer(2000 * ms);
  CHECK(rig.holds_claim());
  rig.timer(1);
  CHECK_FALSE(rig.holds_claim());
}

TEST_CASE("G011 a state that waited for its turn is as old as its arrival") {
  Late rig;
  rig.next_tick();
  rig.send_heartbeat();
  rig.now_ns += 150 * ms;
  rig.handle_state(rig.tick + 1, rig.now_ns - 100 * ms);
  REQUIRE(rig.lease().state_tick == rig.tick + 1);
  rig.timer(150 * ms);
  CHECK(rig.gate->state() == GateState::armed);
  rig.timer(1);
  CHECK(rig.gate->state() == GateState::stopped);
}

TEST_CASE("G013 a state that waited for its turn may be of no later tick than when it came in") {
  for (const std::uint64_t waited : {0 * ms, 100 * ms}) {
    Late rig;
    rig.next_tick();
    rig.now_ns += 100 * ms;
    rig.handle_state(rig.tick + 3, rig.now_ns - waited);
    CHECK(rig.gate->state() == (waited == 0 ? GateState::armed : GateState::stopped));
  }
}

TEST_CASE("G013 a state that came in before the newest one and gets its turn later is no leap") {
  Late rig;
  rig.next_tick();
  rig.handle_state(rig.tick + 1, rig.now_ns);
  CHECK(rig.gate->state() == GateState::armed);
  for (const std::uint64_t later : {0U, 3U}) {  // nor confirmed by a second one
    rig.handle_state(rig.tick + 1'000 + later, rig.now_ns - (60 + later) * ms);
    CHECK(rig.gate->state() == GateState::stopped);
    CHECK(rig.status().state_tick == rig.tick + 1);
  }
}

TEST_CASE("G013 lockstep without a claim: a leap that no lost state explains is never taken") {
  GateRig rig(true);
  rig.connect_and_arm();
  const std::uint64_t honest = rig.tick + 100'000;
  rig.tick = honest;
  rig.send_state();
  CHECK(rig.gate->state() == GateState::armed);
  for (const std::uint64_t absurd : {honest + 100'001, UINT64_MAX - 1, UINT64_MAX}) {
    rig.tick = absurd;
    rig.send_state();
    CHECK(rig.gate->state() == GateState::stopped);
    CHECK(rig.status().state_tick == honest);
  }
  CHECK(rig.counter("G013") == 1);
  rig.tick = honest + 1;
  rig.send_state();
  CHECK(rig.status().state_tick == honest + 1);
}
