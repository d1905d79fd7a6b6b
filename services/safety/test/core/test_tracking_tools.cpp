// G040: where a tool went, against the deltas, twists and poses that acted.

#include <cmath>
#include <numbers>

#include "tracked_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// The arm turns about its first joint: the tool, 0.7 m out, goes to the side by `across` and by a
// little inwards.
double turn_for(double across) { return std::asin(across / 0.7); }
double inwards(double across) { return 0.7 - std::sqrt(0.7 * 0.7 - across * across); }

void narrow_tool(Limits& limits, double linear, double angular) {
  for (CartesianLimits* mode :
       {&limits.parts[arm].modes.cartesian_delta, &limits.parts[arm].modes.cartesian_twist}) {
    mode->gain = {0.5, 1.0};
    mode->linear_tracking = linear;
    mode->angular_tracking = angular;
  }
}

// Whether the gate stops when the tool, told to go to the side, goes there by `across` a tick.
bool tool_stops(bool lockstep, Mode mode, double told, const Row& across, double linear,
                double angular) {
  TrackedRig rig(lockstep, [&](Limits& limits) { narrow_tool(limits, linear, angular); });
  rig.begin(ChunkBuilder().along(arm, mode, 1, Row(4, told)));
  double where = 0.0;
  for (const double step : across) {
    REQUIRE_FALSE(rig.stopped());
    where += step;
    rig.positions[arm_1] = turn_for(where);
    rig.positions[torso] += 0.01;  // what others do to the tool is not this part's
    rig.act();
  }
  return rig.stopped();
}

}  // namespace

TEST_CASE("G040 deltas and twists: the tool's displacement, along and across what was told") {
  constexpr double close = 1e-6;
  for (const bool lockstep : {true, false}) {
    for (const Mode mode : {Mode::cartesian_delta, Mode::cartesian_twist}) {
      const double unit = mode == Mode::cartesian_delta ? 1.0 : 1.0 / 0.05;
      const double told = 0.02 * unit;
      const auto stops = [&](const Row& across, double linear, double angular = 10.0) {
        return tool_stops(lockstep, mode, told, across, linear * unit, angular * unit);
      };
      // Across: 0.02 of 0.02 to the side is right, but for the circle.
      CHECK_FALSE(stops({0.02}, inwards(0.02) + close));
      CHECK(stops({0.02}, inwards(0.02) - close));
      // Along: too far, the wrong way, and in the second row too little.
      const double far = std::hypot(0.01, inwards(0.03));
      CHECK_FALSE(stops({0.03}, far + close));
      CHECK(stops({0.03}, far - close));
      CHECK(stops({-0.01}, 0.009));
      CHECK_FALSE(stops({0.0}, 0.001));
      CHECK_FALSE(stops({0.0, 0.0}, 0.0101));
      CHECK(stops({0.0, 0.0}, 0.0099));
      // The arm's turn was not asked for.
      CHECK_FALSE(stops({0.02}, 10.0, turn_for(0.02) + close));
      CHECK(stops({0.02}, 10.0, turn_for(0.02) - close));
    }
  }
}

TEST_CASE("G040 a pose: distance and angle of the tool from the one that acted") {
  const Row ahead{0.7, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0};
  constexpr double turn = 0.0625;
  const double distance = 1.4 * std::sin(turn / 2);
  const auto stops = [&](bool lockstep, double linear, double angular) {
    TrackedRig rig(lockstep, [&](Limits& limits) {
      limits.parts[arm].modes.cartesian_pose.linear_tracking = linear;
      limits.parts[arm].modes.cartesian_pose.angular_tracking = angular;
    });
    rig.begin(ChunkBuilder().poses(arm, Rows(4, ahead)));
    rig.positions[arm_1] = turn;
    rig.act();
    return rig.stopped();
  };
  for (const bool lockstep : {true, false}) {
    CHECK_FALSE(stops(lockstep, distance + 1e-12, 10.0));
    CHECK(stops(lockstep, distance - 1e-12, 10.0));
    CHECK_FALSE(stops(lockstep, 10.0, turn + 1e-12));
    CHECK(stops(lockstep, 10.0, turn - 1e-12));
  }
}

namespace {

// A delta of 0.002 m to the side happened to three quarters and the tool came to rest; what is told
// next asks for the same, and has not happened yet.
bool stops_from_rest(const ChunkBuilder& next) {
  TrackedRig rig(true, [](Limits& limits) {
    narrow_tool(limits, 0.0005, 10.0);
    CartesianLimits& twists = limits.parts[arm].modes.cartesian_twist;
    twists.linear_tracking = 0.005;
    (void)limits.parts[arm].modes.cartesian_delta.frames.push_back("column");
  });
  rig.begin(ChunkBuilder().along(arm, Mode::cartesian_delta, 1, {0.002}));
  rig.positions[arm_1] = turn_for(0.0015);
  rig.act();
  REQUIRE_FALSE(rig.stopped());
  rig.begin(next);
  rig.act();
  return rig.stopped();
}

}  // namespace

TEST_CASE("G040 lockstep: after a row of another mode or frame a tool begins at rest") {
  const ChunkBuilder twist = ChunkBuilder().along(arm, Mode::cartesian_twist, 1, {0.04});
  const ChunkBuilder other_frame =
      ChunkBuilder().add(arm, Mode::cartesian_delta, {{0, 0.002, 0, 0, 0, 0}}, {}, "column");
  const ChunkBuilder same = ChunkBuilder().along(arm, Mode::cartesian_delta, 1, {0.002});
  CHECK_FALSE(stops_from_rest(twist));
  CHECK_FALSE(stops_from_rest(other_frame));
  CHECK(stops_from_rest(same));  // that goes on: from half of 0.002 m, and 0.0005 m are allowed
}

TEST_CASE("G040 a body twist of a part whose motion tells none is not judged by it") {
  for (const bool lockstep : {true, false}) {
    TrackedRig rig(lockstep, [](Limits& limits) {
      CartesianLimits& mode = limits.parts[arm].modes.body_twist;
      mode = cartesian_mode(1.0, 1.5, {0, 1, 5});
      mode.gain = {0.5, 1.0};
      mode.linear_tracking = mode.angular_tracking = 1e-9;
    });
    rig.begin(ChunkBuilder().along(arm, Mode::body_twist, 0, {0.5, 0.5}));
    for (int i = 0; i < 2; ++i) {
      rig.positions[arm_1] += 0.1;
      rig.act();
      CHECK_FALSE(rig.stopped());
    }
  }
}

TEST_CASE("G040 a tool's motion is seen along the axes of the frame that the row names") {
  // The upper arm is turned to the left by a right angle: its y points backwards.
  const auto stops = [](bool lockstep, const Row& told, std::size_t joint, double change) {
    TrackedRig rig(lockstep, [](Limits& limits) {
      narrow_tool(limits, 0.005, 0.05);
      (void)limits.parts[arm].modes.cartesian_delta.frames.push_back("upper");
      limits.joints[arm_2].velocity_limit = 3.0;
    });
    for (int i = 0; i < 4; ++i) {
      rig.positions[arm_1] += std::numbers::pi / 8;
      rig.hold();
    }
    rig.hold();  // there it stands still
    rig.begin(ChunkBuilder().add(arm, Mode::cartesian_delta, Rows(4, told), {}, "upper"));
    rig.positions[joint] += change;
    rig.act();
    return rig.stopped();
  };
  for (const bool lockstep : {true, false}) {
    const Row aside{0, 0.02, 0, 0, 0, 0.02 / 0.7};
    CHECK_FALSE(stops(lockstep, aside, arm_1, turn_for(0.02)));
    CHECK(stops(lockstep, aside, arm_1, turn_for(-0.02)));
    const Row nod{0, 0, -0.03, 0, 0.1, 0};
    CHECK_FALSE(stops(lockstep, nod, arm_2, 0.1));
    CHECK(stops(lockstep, nod, arm_2, -0.1));
  }
}
