// A base whose controller turns x and y of joint_velocity by minus its yaw: G040, and its speed.

#include <doctest/doctest.h>

#include <cmath>

#include "core/modes/commanded_motion.hpp"
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

TEST_CASE("a slide is told at most its own speed, or both slides' where rows are turned") {
  Limits limits = test_limits();
  limits.joints[base_x].velocity_limit = 3.0;
  limits.joints[base_y].velocity_limit = 4.0;
  CHECK(fastest_command(limits, base_x) == 3.0);
  CHECK(fastest_command(limits, base_y) == 4.0);
  limits.base.against_yaw = true;
  CHECK(fastest_command(limits, base_x) == 5.0);
  CHECK(fastest_command(limits, base_y) == 5.0);
  CHECK(fastest_command(limits, base_yaw) == 1.5);
  CHECK(fastest_command(limits, arm_1) == 1.5);
  limits.base.present = false;
  CHECK(fastest_command(limits, base_x) == 3.0);
}
