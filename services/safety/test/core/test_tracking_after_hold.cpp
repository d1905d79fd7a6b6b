// G040: a tool and a base that still move when a row begins may go on as they do, or come to rest.

#include "tracked_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double period_s = 0.05;

// Rows of zeros act on a part that moves; whether the gate stops after the first, when joints went
// on by `share` of how fast they were.
struct Coasting {
  std::uint8_t part;
  Mode mode;
  std::size_t joint;
  double speed;
  double linear_tracking, angular_tracking;  // per second

  bool stops(bool lockstep, double share) const {
    TrackedRig rig(lockstep, [this](Limits& limits) { narrow(limits); });
    rig.velocities[joint] = speed;
    rig.hold();
    rig.begin(ChunkBuilder().along(part, mode, 0, Row(4, 0.0)));
    rig.positions[joint] += share * speed * period_s;
    rig.act();
    return rig.stopped();
  }

 private:
  void narrow(Limits& limits) const {
    ModeLimits& modes = limits.parts[part].modes;
    CartesianLimits& limit = mode == Mode::body_twist        ? modes.body_twist
                             : mode == Mode::cartesian_twist ? modes.cartesian_twist
                                                             : modes.cartesian_delta;
    const double unit = mode == Mode::cartesian_delta ? period_s : 1.0;
    limit.gain = {0.5, 1.0};
    limit.linear_tracking = linear_tracking * unit;
    limit.angular_tracking = angular_tracking * unit;
  }
};

// From rest, over the speed it had, to as far beyond as is allowed: an eighth of it.
void check(const Coasting& coasting) {
  for (const bool lockstep : {true, false}) {
    CAPTURE(static_cast<int>(coasting.mode));
    for (const double share : {0.0, 0.5, 1.0, 1.12}) CHECK_FALSE(coasting.stops(lockstep, share));
    for (const double share : {-0.14, 1.14, 3.0}) CHECK(coasting.stops(lockstep, share));
  }
}

}  // namespace

TEST_CASE("G040 after a hold in which a tool still moved, that motion is as good as standstill") {
  for (const Mode mode : {Mode::cartesian_delta, Mode::cartesian_twist}) {
    // The tool is 0.7 m from the axis.
    check({arm, mode, arm_1, 0.04, 0.7 * 0.005, vast});
    check({arm, mode, arm_1, 0.04, vast, 0.005});
  }
}

TEST_CASE("G040 after a hold in which a base still moved, that motion is as good as standstill") {
  check({base, Mode::body_twist, base_y, 0.4, 0.05, vast});
  check({base, Mode::body_twist, base_yaw, 0.4, vast, 0.05});
}
