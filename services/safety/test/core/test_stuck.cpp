// G041: commanded motion, and a measured position that does not change.

#include "stuck_limits.hpp"
#include "tracked_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

void narrow(Limits& limits) {
  stick_soon(limits);
  limits.parts[arm].modes.joint_velocity.gain = {1.0, 1.0};
  for (CartesianLimits* mode :
       {&limits.parts[arm].modes.cartesian_delta, &limits.parts[arm].modes.cartesian_twist,
        &limits.parts[base].modes.body_twist})
    mode->gain = {0.5, 1.0};
}

// The tick, counted from 1, after which the gate stops; 0 if six rows pass.
int stops_after(const ChunkBuilder& command, bool lockstep, double change = 0.0,
                std::size_t joint = arm_1) {
  TrackedRig rig(lockstep, narrow);
  rig.begin(command);
  for (int row = 1; row <= 6; ++row) {
    rig.positions[joint] += change;
    rig.act();
    if (rig.stopped()) return row;
  }
  return 0;
}

ChunkBuilder speeds(double value) {
  return ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, Row(6, value));
}

}  // namespace

TEST_CASE("G041 stops after stuck_ticks rows that change nothing beyond the encoder's step") {
  for (const bool lockstep : {true, false}) {
    CHECK(stops_after(speeds(0.5), lockstep) == 3);
    CHECK(stops_after(speeds(-0.5), lockstep) == 3);
    CHECK(stops_after(speeds(0.5), lockstep, encoder_step / 4) == 3);
    CHECK(stops_after(speeds(0.5), lockstep, -encoder_step / 4) == 3);
    CHECK(stops_after(speeds(0.5), lockstep, 1.001 * encoder_step) == 0);
    CHECK(stops_after(speeds(0.5), lockstep, -1.001 * encoder_step) == 0);
    CHECK(stops_after(speeds(0.5), lockstep, 0.01, arm_2) == 3);
  }
}

TEST_CASE("G041 a joint that moves by less than a step a tick does move") {
  for (const bool lockstep : {true, false}) {
    CHECK(stops_after(speeds(0.5), lockstep, 0.6 * encoder_step) == 0);
    CHECK(stops_after(speeds(-0.5), lockstep, -0.6 * encoder_step) == 0);
  }
}

TEST_CASE("G041 within the dead band nothing has to move; slow rows add up to it") {
  for (const bool lockstep : {true, false}) {
    // 1/64 rad in periods of 0.05 s: four rows of 5/64 rad/s
    CHECK(stops_after(speeds(0.05), lockstep) == 0);
    CHECK(stops_after(speeds(0.078125 - 1e-9), lockstep) == 5);
    CHECK(stops_after(speeds(0.078125 + 1e-9), lockstep) == 4);
    CHECK(stops_after(speeds(-0.078125 - 1e-9), lockstep) == 4);
    CHECK(stops_after(speeds(0.0), lockstep) == 0);
    // To and fro: 0.01 rad at most.
    const Row to_and_fro{0.2, -0.2, 0.2, -0.2, 0.2, -0.2};
    CHECK(stops_after(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, to_and_fro),
                      lockstep) == 0);
    const auto target = [](double value) {
      return ChunkBuilder().joint(arm, Mode::joint_position, arm_1, Row(6, value));
    };
    CHECK(stops_after(target(0.015625), lockstep) == 0);
    CHECK(stops_after(target(just_above(0.015625)), lockstep) == 3);
    CHECK(stops_after(target(-0.015625), lockstep) == 0);
    CHECK(stops_after(target(-0.25), lockstep) == 3);
  }
}

TEST_CASE("G041 what is told counts by the gain's lower end, where that is none by its middle") {
  const auto stops = [](const Gain& gain, double speed) {
    TrackedRig rig(true, [&gain](Limits& limits) {
      narrow(limits);
      limits.parts[arm].modes.joint_velocity.gain = gain;
    });
    rig.begin(speeds(speed));
    for (int row = 1; row <= 6; ++row) {
      rig.act();
      if (rig.stopped()) return row;
    }
    return 0;
  };
  CHECK(stops({0.5, 1.5}, 0.15625 - 1e-9) == 5);
  CHECK(stops({0.5, 1.5}, 0.15625 + 1e-9) == 4);
  CHECK(stops({0.0, 1.0}, 0.15625 - 1e-9) == 5);
  CHECK(stops({0.0, 1.0}, 0.15625 + 1e-9) == 4);
  CHECK(stops({0.0, 0.0}, 0.5) == 0);
}

TEST_CASE("G041 a measured change begins anew") {
  for (const bool lockstep : {true, false}) {
    TrackedRig moved(lockstep, narrow);
    moved.begin(speeds(0.5));
    moved.act();
    moved.act();
    moved.positions[arm_1] += 2 * encoder_step;
    for (int i = 0; i < 3; ++i) moved.act();
    CHECK_FALSE(moved.stopped());
    moved.act();
    CHECK(moved.stopped());
  }
}

TEST_CASE("G041 holds, rows for other joints and other modes change nothing, and end nothing") {
  for (const bool lockstep : {true, false}) {
    const auto burst = [](TrackedRig& rig, const ChunkBuilder& command) {
      rig.begin(command);
      rig.act();
      rig.act();
      CHECK_FALSE(rig.stopped());
    };
    const auto two = [](std::uint8_t joint) {
      return ChunkBuilder().joint(arm, Mode::joint_velocity, joint, {0.4, 0.4, 0.4});
    };
    const auto third = [&two](TrackedRig& rig) {
      rig.begin(two(arm_1));
      CHECK_FALSE(rig.stopped());
      rig.act();
      CHECK(rig.stopped());
    };
    TrackedRig held(lockstep, narrow);
    burst(held, two(arm_1));
    for (int i = 0; i < 5; ++i) held.hold();
    third(held);

    TrackedRig other(lockstep, narrow);
    burst(other, two(arm_1));
    burst(other, two(arm_2));
    third(other);

    TrackedRig mode(lockstep, narrow);
    burst(mode, two(arm_1));
    mode.hold();
    burst(mode, ChunkBuilder().along(arm, Mode::cartesian_delta, 0, Row(3, 0.03)));
    mode.hold();
    third(mode);
  }
}

TEST_CASE("G041 arming begins anew") {
  TrackedRig rig(true, narrow);
  for (int i = 0; i < 2; ++i) {
    rig.begin(speeds(0.5));
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

TEST_CASE("G041 a target that was reached moves nothing") {
  for (const bool lockstep : {true, false}) {
    TrackedRig rig(lockstep, narrow);
    rig.positions[arm_1] = 0.25;
    rig.hold();
    rig.begin(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, Row(6, 0.25)));
    for (int i = 0; i < 6; ++i) rig.act();
    CHECK_FALSE(rig.stopped());
  }
}

TEST_CASE("G041 a tool or a base that is told to move changes at least one joint of its part") {
  for (const bool lockstep : {true, false}) {
    const auto tool = [](double value) {
      return ChunkBuilder().along(arm, Mode::cartesian_delta, 0, Row(6, value));
    };
    // Half of it happens at least: in four rows as far as 1/64 rad turns the tool, 0.7 m away.
    const double quarter = 0.7 * 0.015625 / 2.0;
    CHECK(stops_after(tool(0.6 * quarter), lockstep) == 0);
    CHECK(stops_after(tool(quarter - 1e-9), lockstep) == 5);
    CHECK(stops_after(tool(quarter + 1e-9), lockstep) == 4);
    CHECK(stops_after(tool(0.0), lockstep) == 0);
    CHECK(stops_after(tool(-0.0625), lockstep) == 3);
    CHECK(stops_after(tool(0.0625), lockstep, 2 * encoder_step, arm_2) == 0);
    CHECK(stops_after(tool(0.0625), lockstep, 2 * encoder_step, base_x) == 3);
    const auto turn = [](double value) {
      return ChunkBuilder().along(arm, Mode::cartesian_delta, 4, Row(6, value));
    };
    CHECK(stops_after(turn(0.0078125), lockstep) == 5);
    CHECK(stops_after(turn(0.0625), lockstep) == 3);
    const auto twist = [](std::uint8_t part, Mode mode, std::size_t axis, double value) {
      return ChunkBuilder().along(part, mode, axis, Row(6, value));
    };
    // 1/64 m in four periods of 0.05 s, of which half happens: 0.15625 m/s.
    CHECK(stops_after(twist(base, Mode::body_twist, 0, 0.15625 - 1e-9), lockstep) == 5);
    CHECK(stops_after(twist(base, Mode::body_twist, 0, 0.15625 + 1e-9), lockstep) == 4);
    CHECK(stops_after(twist(base, Mode::body_twist, 5, 0.7), lockstep) == 3);
    CHECK(stops_after(twist(arm, Mode::cartesian_twist, 3, 0.7), lockstep) == 3);
    const auto turned_pose = [](double angle) {
      const Row pose{0.7 * std::cos(angle), 0.7 * std::sin(angle), 0.5, 0.0, 0.0,
                     std::sin(0.5 * angle), std::cos(0.5 * angle)};
      return ChunkBuilder().poses(arm, Rows(6, pose));
    };
    CHECK(stops_after(turned_pose(0.0156), lockstep) == 0);
    CHECK(stops_after(turned_pose(0.0157), lockstep) == 3);
  }
}

TEST_CASE("G041 a tool mode of which nothing may happen proves nothing") {
  TrackedRig rig(true, [](Limits& limits) {
    narrow(limits);
    limits.parts[arm].modes.cartesian_delta.gain = {0.0, 0.0};
  });
  rig.begin(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, Row(6, 0.1)));
  for (int i = 0; i < 6; ++i) rig.act();
  CHECK_FALSE(rig.stopped());
}

TEST_CASE("G041 the stop names joint, change and the encoder's step, and is counted") {
  TrackedRig rig(true, narrow);
  rig.begin(speeds(0.5));
  for (int i = 0; i < 3; ++i) rig.act();
  CHECK(rig.cause() == "stopped: G041 arm arm_1: 0 rad, limit 0.000976562 rad (encoder_step)");
  CHECK(rig.counter("G041") == 1);
  TrackedRig tool(true, narrow);
  tool.begin(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, Row(6, 0.1)));
  for (int i = 0; i < 3; ++i) tool.act();
  CHECK(tool.cause() == "stopped: G041 arm arm_1: 0 rad, limit 0.000976562 rad (encoder_step)");
}

TEST_CASE("G041 a change is said without its sign") {
  TrackedRig rig(true, narrow);
  rig.begin(speeds(0.5));
  for (int i = 0; i < 3; ++i) {
    rig.positions[arm_1] -= encoder_step / 8;
    rig.act();
  }
  CHECK(rig.cause().find("arm_1: 0.0003") != std::string::npos);
}

TEST_CASE("G041 limits that are no numbers, or none at all") {
  const auto stops = [](double encoder_step, double dead_band) {
    TrackedRig rig(true, [&](Limits& limits) {
      narrow(limits);
      limits.joints[arm_1].encoder_step = encoder_step;
      limits.joints[arm_1].dead_band = dead_band;
    });
    rig.begin(speeds(0.5));
    for (int i = 0; i < 3; ++i) {
      rig.positions[arm_1] += 0.01;
      rig.act();
    }
    return rig.stopped();
  };
  CHECK_FALSE(stops(encoder_step, 0.015625));
  CHECK(stops(not_a_number, 0.015625));
  CHECK_FALSE(stops(encoder_step, infinite));
  CHECK(stops(infinite, not_a_number));
  CHECK_FALSE(stops(0.0, -infinite));
}

TEST_CASE("G041 a pose that stays away counts by its distance, too") {
  for (const bool lockstep : {true, false}) {
    const auto behind = [](double distance) {
      return ChunkBuilder().poses(arm, Rows(6, {0.7 - distance, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0}));
    };
    const auto free_stops = [&](double distance) {
      TrackedRig rig(lockstep, [](Limits& limits) {
        narrow(limits);
        limits.joints[arm_1].kind = JointKind::prismatic;
        limits.kinematics.links[2].motion = LinkMotion::slide;
        limits.kinematics.links[2].axis = {1.0, 0.0, 0.0};
      });
      rig.begin(behind(distance));
      for (int row = 1; row <= 6; ++row) {
        rig.act();
        if (rig.stopped()) return row;
      }
      return 0;
    };
    CHECK(free_stops(0.0156) == 0);
    CHECK(free_stops(0.0157) == 3);
  }
}
