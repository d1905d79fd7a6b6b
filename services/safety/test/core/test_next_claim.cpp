// What a claim leaves behind when it ends, and what the next one in its place does not get.

#include "core/monitor/grasp_watch.hpp"
#include "tracked_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

void end_claim(GateRig& rig) { rig.send(EventKind::release, Release{"runner", rig.claim_id}); }

// A hand that closed on something at 1/16 m, in lockstep.
struct Holding : TrackedRig {
  Holding()
      : TrackedRig(true, [](Limits& robot) {
          robot.parts[gripper].modes.gripper_position.slip_limit = 0.015625;
        }) {
    positions[gripper_joint] = 0.079;
    hold();
    close();
    act();
    positions[gripper_joint] = 0.0625;
    velocities[gripper_joint] = -0.3;
    act();
    velocities[gripper_joint] = 0.0;
    for (int i = 0; i < 3; ++i) act();
    REQUIRE_FALSE(stopped());
  }
  void close() { begin(ChunkBuilder().scalar(gripper, Mode::gripper_position, Row(12, 0.03))); }
  /// A claim that tells the same; the hand then closes to nothing.
  bool stops_under_the_next() {
    take_claim();
    close();
    positions[gripper_joint] = 0.03;
    act();
    return stopped();
  }
};

}  // namespace

TEST_CASE("a chunk that waited for the next state ends with its claim, not under the next one") {
  GateRig rig;
  rig.ready();
  ChunkBuilder early = rig.chunk();
  early.chunk.obs_tick = rig.tick + 1;
  early.chunk.oldest_tick = rig.tick;
  rig.send_frame(EventKind::candidate, early.frame(), "runner");
  REQUIRE(rig.count(OutputKind::verdict) == 0);
  end_claim(rig);
  rig.take_claim();
  rig.next_tick();
  CHECK(rig.count(OutputKind::verdict) == 0);
}

TEST_CASE("G042 what a hand held under a claim that ended, the next one cannot lose") {
  Holding released;
  end_claim(released);
  released.hold();
  CHECK_FALSE(released.stops_under_the_next());
  Holding rearmed;
  rearmed.send(EventKind::disarm, Disarm{"test"});
  rearmed.hold();
  rearmed.epoch = rearmed.arm().epoch;
  CHECK_FALSE(rearmed.stops_under_the_next());
}

TEST_CASE("G025 a row that was released may still act when its claim has ended") {
  GateRig rig;
  rig.ready();
  ChunkBuilder first = rig.chunk({0.5});
  first.chunk.start_tick += 1;
  REQUIRE(rig.send_chunk(first).code == 0);
  end_claim(rig);
  rig.take_claim();
  ChunkBuilder twist = rig.chunk();
  twist.chunk.parts.clear();
  twist.chunk.start_tick += 1;
  twist.along(base, Mode::body_twist, 0, {0.4});
  CHECK(rig.send_chunk(twist).code == 25);
}

TEST_CASE("30 s without a claim begin when its heartbeat was missed") {
  GateRig rig;
  rig.ready();
  while (rig.lease().grants.size() == 1) rig.next_tick();
  const std::uint64_t ended_ns = rig.now_ns;
  while (rig.now_ns - ended_ns < 30'000 * ms) rig.next_tick();
  CHECK(rig.gate->state() == GateState::armed);
  rig.timer(1);
  CHECK(rig.gate->state() == GateState::disarmed);
}

TEST_CASE("G025 the first of the parts in motion at arming is as unknown as the others") {
  GateRig rig(true);
  rig.velocities[arm_1] = 0.5;
  rig.ready();
  ChunkBuilder turn = rig.chunk();
  turn.chunk.parts.clear();
  turn.joint(arm, Mode::joint_velocity, arm_1, {0.5});
  CHECK(rig.send_chunk(turn).code == 25);
  rig.velocities[arm_1] = 0.0;
  rig.next_tick();
  ChunkBuilder still = rig.chunk();
  still.chunk.parts.clear();
  still.joint(arm, Mode::joint_velocity, arm_1, {0.0});
  CHECK(rig.send_chunk(still).code == 0);
}

TEST_CASE(
    "lockstep: while a row of an ended claim acts, the next claim holds without being asked") {
  TrackedRig rig(true, [](Limits&) {});
  rig.begin(rig.chunk());
  rig.act();
  end_claim(rig);
  rig.take_claim();
  rig.next_tick(row_of(rig.safe, 1));
  REQUIRE(rig.lease().grants.size() == 1);
  CHECK(rig.lease().grants[0].decision == static_cast<std::uint8_t>(Decision::hold));
  CHECK(rig.send_chunk(rig.chunk()).code == 21);
  rig.hold();
  CHECK(rig.lease().grants[0].decision == static_cast<std::uint8_t>(Decision::undecided));
  CHECK(rig.send_chunk(rig.chunk()).code == 0);
}
