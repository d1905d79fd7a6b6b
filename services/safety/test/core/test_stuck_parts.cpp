// G041: what begins anew for a part whose tool or base is told to move, and what is no change.

#include <functional>

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

namespace {

// The row in which the gate stops of those that turn a part by so much each, 0: in none.
int stops_in(const std::function<void(Limits&)>& change, std::uint8_t part, Mode mode,
             std::size_t axis, double each) {
  TrackedRig rig(true, [&](Limits& limits) {
    narrow(limits);
    limits.parts[base].modes.body_twist.gain = {1.0, 1.0};
    change(limits);
  });
  rig.begin(ChunkBuilder().along(part, mode, axis, Row(6, each)));
  for (int row = 1; row <= 6; ++row) {
    rig.act();
    if (rig.stopped()) return row;
  }
  return 0;
}

}  // namespace

TEST_CASE("G041 a base that turns in place moves nothing ahead: its slides' dead band counts") {
  const auto wide_turn = [](Limits& limits) { limits.joints[base_yaw].dead_band = 0.25; };
  // 6 mm a row: beyond 1/64 m in the third.
  CHECK(stops_in(wide_turn, base, Mode::body_twist, 0, 0.12) == 3);
  CHECK(stops_in(wide_turn, base, Mode::body_twist, 5, 0.6) == 0);  // 0.18 rad
}

TEST_CASE("G041 a turn may move a tool by as much as all links between them are long, either way") {
  // arm_1 turns about the column, the tool is 0.7 m off; its dead band of 1/64 rad is 11 mm there.
  const auto tool_at = [](double aside, double up) {
    return [=](Limits& limits) {
      limits.joints[arm_2].dead_band = 0.0;
      limits.kinematics.links[3].translation = {0.4, aside, up};
    };
  };
  const auto stops = [&](double aside, double up) {
    return stops_in(tool_at(aside, up), arm, Mode::cartesian_delta, 0, 0.004);
  };
  CHECK(stops(0.0, 0.0) == 3);
  CHECK(stops(0.3, 0.0) == 4);  // 0.8 m: 12.5 mm
  CHECK(stops(0.0, 0.3) == 4);
  CHECK(stops(0.4, 0.4) == 4);  // 0.993 m: 15.5 mm
}
