// G040 of a base whose controller turns x and y of joint_velocity by minus its yaw.

#include <doctest/doctest.h>

#include <cmath>

#include "tracked_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double slack = 0.125;

}  // namespace

TEST_CASE("G040 a base told against its yaw: its slides are compared with the row turned back") {
  const double quarter = std::acos(0.0);
  for (const double sign : {1.0, -1.0}) {
    const auto turned = [](Limits& limits) {
      limits.base.against_yaw = true;
      JointModeLimits& mode = limits.parts[base].modes.joint_velocity;
      mode.gain = {1.0, 1.0};
      for (const std::size_t j : {base_x, base_y}) mode.tracking[j] = slack;
    };
    TrackedRig rig(true, turned);
    rig.positions[base_yaw] = quarter;
    rig.restart(BootInfo{true, false, {}});
    rig.ready();
    rig.hold();
    rig.begin(ChunkBuilder().add(base, Mode::joint_velocity, Rows(4, Row{0.5, 0, 0, 0, 0, 0}),
                                 {base_x, base_y}));
    rig.velocities[base_y] = -0.5;
    rig.act();
    CHECK_FALSE(rig.stopped());
    rig.velocities[base_y] = -0.5 + sign * 0.126;
    rig.act();
    CHECK(rig.stopped());
  }
}
