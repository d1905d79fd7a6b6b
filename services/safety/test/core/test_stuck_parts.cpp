// G041: what begins anew for a part whose tool or base is told to move, and what is no change.

#include "stuck_limits.hpp"
#include "tracked_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

void narrow(Limits& limits) {
  stick_soon(limits);
  limits.parts[arm].modes.joint_velocity.gain = {1.0, 1.0};
  limits.parts[arm].modes.cartesian_delta.gain = {1.0, 1.0};
}

const ChunkBuilder speeds = ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, Row(6, 0.5));
const ChunkBuilder deltas = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, Row(6, 0.05));

}  // namespace

TEST_CASE("G041 a change of exactly one encoder step is none: that much a resting joint shows") {
  for (const bool lockstep : {true, false}) {
    for (const double change : {encoder_step, just_above(encoder_step)}) {
      TrackedRig rig(lockstep, narrow);
      rig.begin(speeds);
      rig.positions[arm_1] = change;
      for (int i = 0; i < 3; ++i) rig.act();
      CHECK(rig.stopped() == (change == encoder_step));
    }
  }
}

TEST_CASE("G041 a measured change of any joint begins anew for a tool") {
  for (const bool lockstep : {true, false}) {
    for (const std::size_t joint : {arm_1, arm_2}) {
      TrackedRig rig(lockstep, narrow);
      rig.begin(deltas);
      rig.act();
      rig.act();
      rig.positions[joint] += 2 * encoder_step;
      for (int i = 0; i < 3; ++i) rig.act();
      CHECK_FALSE(rig.stopped());
      rig.act();
      CHECK(rig.stopped());
    }
  }
}

TEST_CASE("G041 arming begins anew for a tool") {
  TrackedRig rig(true, narrow);
  for (int i = 0; i < 2; ++i) {
    rig.begin(deltas);
    rig.act();
    rig.act();
    rig.hold();
    CHECK_FALSE(rig.stopped());
    rig.send(EventKind::disarm, Disarm{"test"});
    rig.hold();
    rig.ready();
    rig.hold();
  }
}
