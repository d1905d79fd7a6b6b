// G042: a joint that presses too hard, and a gripper that loses what it held.

#include "core/chunk/state_check.hpp"
#include "tracked_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double slip = 0.015625;

void narrow(Limits& limits) {
  for (JointLimits& joint : limits.joints) joint.contact_limit = 40.0;
  limits.parts[gripper].modes.gripper_position.slip_limit = slip;
}

ChunkBuilder opening(double value, std::size_t rows = 12) {
  return ChunkBuilder().scalar(gripper, Mode::gripper_position, Row(rows, value));
}

// It is told, and goes to 1/16 m in the tick after the next.
void close_from(TrackedRig& rig, const ChunkBuilder& command, double from) {
  rig.positions[gripper_joint] = from;
  rig.hold();
  rig.begin(command);
  rig.act();
  rig.positions[gripper_joint] = 0.0625;
  rig.velocities[gripper_joint] = from > 0.0625 ? -0.3 : 0.3;
  rig.act();
  rig.velocities[gripper_joint] = 0.0;
}

// A gripper that was told to close, went to 1/16 m and has been standing still since.
struct Grasping : TrackedRig {
  Grasping(bool in_lockstep, const ChunkBuilder& command, int still_ticks = 3, double from = 0.079)
      : TrackedRig(in_lockstep, narrow) {
    close_from(*this, command, from);
    for (int i = 0; i < still_ticks; ++i) act();
    REQUIRE_FALSE(stopped());
  }
};

// Whether it stops when the opening then is this.
bool stops_at(double now, bool lockstep, const ChunkBuilder& command, int still_ticks = 3,
              double from = 0.079) {
  Grasping rig(lockstep, command, still_ticks, from);
  rig.positions[gripper_joint] = now;
  rig.act();
  return rig.stopped();
}

}  // namespace

TEST_CASE("G042 a commanded joint presses up to its contact limit, of either sign") {
  for (const bool lockstep : {true, false}) {
    for (std::size_t j = 0; j < joint_count; ++j) {
      for (const double sign : {1.0, -1.0}) {
        TrackedRig rig(lockstep, narrow);
        rig.efforts[j] = 40.0 * sign;
        rig.hold();
        CHECK_FALSE(rig.stopped());
        rig.efforts[j] = just_above(40.0) * sign;
        rig.hold();
        CHECK(rig.stopped());
        CHECK(rig.counter("G042") == 1);
      }
    }
    TrackedRig passive(lockstep, narrow);
    passive.efforts[torso] = 1e5;
    passive.hold();
    CHECK_FALSE(passive.stopped());
  }
}

TEST_CASE("G042 the stop names part, joint, effort and limit, and comes before all but G013") {
  TrackedRig rig(true, [](Limits& limits) {
    narrow(limits);
    limits.parts[arm].modes.joint_position.tracking[arm_1] = 0.01;
  });
  rig.begin(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, Row(4, 0.25)));
  rig.efforts[arm_2] = -50.0;
  rig.act();
  CHECK(rig.lease().grants.empty());
  CHECK(rig.cause() == "stopped: G042 arm arm_2: 50 N m, limit 40 N m (contact_limit)");
  TrackedRig jump(true, narrow);
  jump.efforts[arm_2] = -50.0;
  jump.positions[arm_1] = 0.6;
  jump.hold();
  CHECK(jump.cause().starts_with("stopped: G013 "));
}

TEST_CASE(
    "G042 an effort or a limit that is no number never passes, and disarmed nothing is asked") {
  for (const double odd : {not_a_number, infinite, -infinite}) {
    TrackedRig rig(true, narrow);
    rig.efforts[arm_1] = odd;
    rig.hold();
    CHECK(rig.cause().starts_with("stopped: G011 arm_1: "));
  }
  TrackedRig unset_limit(true, [](Limits&) {});
  CHECK_FALSE(unset_limit.stopped());
  Limits limits = test_limits();
  limits.joints[arm_1].contact_limit = not_a_number;
  CHECK(check_contact(limits, state_at_rest()).code == 42);
  CHECK(check_contact(limits, state_at_rest()).raises_stop);
  limits.joints[arm_1].contact_limit = infinite;
  CHECK(check_contact(limits, state_at_rest()).ok());
  GateRig disarmed;
  disarmed.limits.joints[arm_1].contact_limit = 40.0;
  disarmed.restart(BootInfo{true, false, {}});
  disarmed.send_hal_status();
  disarmed.efforts[arm_1] = 50.0;
  disarmed.next_tick();
  CHECK(disarmed.gate->state() == GateState::disarmed);
}

TEST_CASE("G042 a gripper that stood still short of its target loses up to slip_limit") {
  for (const bool lockstep : {true, false}) {
    CHECK_FALSE(stops_at(0.0625 - slip, lockstep, opening(0.03)));
    CHECK(stops_at(just_below(0.0625 - slip), lockstep, opening(0.03)));
    CHECK_FALSE(stops_at(0.0625 - slip, lockstep, opening(0.03), 5));
    CHECK(stops_at(0.03, lockstep, opening(0.03)));
    // What opens it is no loss.
    CHECK_FALSE(stops_at(0.08, lockstep, opening(0.03)));
    // Held from the inside: it opens towards its target.
    const ChunkBuilder wide = ChunkBuilder().scalar(gripper, Mode::gripper_position, Row(12, 0.08));
    CHECK_FALSE(stops_at(0.0625 + slip - 1e-9, lockstep, wide, 3, 0.045));
    CHECK(stops_at(0.0625 + slip + 1e-9, lockstep, wide, 3, 0.045));
  }
}

TEST_CASE("G042 a slow loss counts from where the gripper began to hold") {
  for (const bool lockstep : {true, false}) {
    Grasping rig(lockstep, opening(0.03));
    for (int i = 0; i < 3; ++i) {
      CHECK_FALSE(rig.stopped());
      rig.positions[gripper_joint] -= 0.006;
      rig.act();
    }
    CHECK(rig.stopped());
    CHECK(rig.cause().starts_with("stopped: G042 gripper gripper_joint: 0.01"));
    CHECK(rig.cause().ends_with(" m, limit 0.015625 m (slip_limit: it lost what it held)"));
  }
}

TEST_CASE("G042 a gripper that still moves, or that has reached its target, holds nothing") {
  for (const bool lockstep : {true, false}) {
    CHECK_FALSE(stops_at(0.03, lockstep, opening(0.03), 2));
    TrackedRig moving(lockstep, narrow);
    moving.positions[gripper_joint] = 0.0625;
    moving.hold();
    moving.begin(opening(0.03));
    moving.velocities[gripper_joint] = -0.05;
    for (int i = 0; i < 6; ++i) moving.act();
    moving.positions[gripper_joint] = 0.03;
    moving.act();
    CHECK_FALSE(moving.stopped());
    // Within the joint's tolerance of 0.01 of the target it is there.
    CHECK_FALSE(stops_at(0.03, lockstep, opening(0.053)));
  }
}

TEST_CASE("G042 a hand that takes its time to begin loses nothing when it closes") {
  for (const bool lockstep : {true, false}) {
    TrackedRig rig(lockstep, narrow);
    rig.positions[gripper_joint] = 0.079;
    rig.hold();
    rig.begin(opening(0.03, 20));
    for (int i = 0; i < 6; ++i) rig.act();
    for (const double opened : {0.077, 0.055}) {
      rig.positions[gripper_joint] = opened;
      rig.act();
      CHECK_FALSE(rig.stopped());
    }
    // Now it has moved, and holds something; that it can lose.
    for (int i = 0; i < 3; ++i) rig.act();
    rig.positions[gripper_joint] = 0.055 - slip - 1e-9;
    rig.act();
    CHECK(rig.stopped());
  }
}

TEST_CASE("G042 motion seen is speed towards the target, or a way beyond the tolerance of 0.01 m") {
  for (const bool lockstep : {true, false}) {
    const auto stops = [lockstep](double opening_then, double speed) {
      TrackedRig rig(lockstep, narrow);
      rig.positions[gripper_joint] = 0.0625;
      rig.hold();
      rig.begin(opening(0.02, 12));
      rig.act();
      rig.velocities[gripper_joint] = speed;
      rig.positions[gripper_joint] = opening_then;
      rig.act();
      rig.velocities[gripper_joint] = 0.0;
      for (int i = 0; i < 3; ++i) rig.act();
      rig.positions[gripper_joint] = opening_then - 0.02;
      rig.act();
      return rig.stopped();
    };
    CHECK_FALSE(stops(0.0625, 0.0));
    CHECK_FALSE(stops(0.0625, 0.3));
    CHECK_FALSE(stops(0.0625, -just_below(0.05)));
    CHECK(stops(0.0625, -0.05));
    CHECK_FALSE(stops(0.053, 0.0));
    CHECK(stops(0.052, 0.0));
    CHECK_FALSE(stops(0.075, 0.0));
  }
}

TEST_CASE("G042 another target is another grasp, at first of the same object") {
  for (const bool lockstep : {true, false}) {
    const auto stops = [lockstep](int still_ticks, double target, double then) {
      Grasping rig(lockstep, opening(0.03, 6));
      rig.act();
      rig.begin(opening(target));
      for (int i = 0; i < still_ticks; ++i) rig.act();
      rig.positions[gripper_joint] = then;
      rig.act();
      return rig.stopped();
    };
    CHECK_FALSE(stops(2, 0.015, 0.04));
    CHECK(stops(3, 0.015, 0.04));
    // The other way it has not gone yet.
    CHECK_FALSE(stops(5, 0.08, 0.0625 + 0.0175));
  }
}

TEST_CASE("G042 a gripper that holds without rows keeps its grasp, and may lose it") {
  for (const bool lockstep : {true, false}) {
    Grasping rig(lockstep, opening(0.03, 5));
    for (int i = 0; i < 5; ++i) rig.hold();
    CHECK_FALSE(rig.stopped());
    rig.positions[gripper_joint] = 0.04;
    rig.hold();
    CHECK(rig.stopped());

    Grasping released(lockstep, opening(0.03, 5));
    released.send(EventKind::release, Release{"runner", released.claim_id});
    released.hold();
    released.positions[gripper_joint] = 0.04;
    released.hold();
    CHECK_FALSE(released.stopped());
  }
}

TEST_CASE("G042 a binary gripper holds short of its end stops") {
  for (const bool lockstep : {true, false}) {
    const ChunkBuilder close = ChunkBuilder().scalar(gripper, Mode::gripper_binary, Row(8, 1.0));
    CHECK(stops_at(0.04, lockstep, close));
    CHECK_FALSE(stops_at(0.08, lockstep, close));
    const ChunkBuilder open = ChunkBuilder().scalar(gripper, Mode::gripper_binary, Row(8, 0.0));
    CHECK(stops_at(0.0625 + 0.0175, lockstep, open, 3, 0.045));
    CHECK_FALSE(stops_at(0.04, lockstep, open, 3, 0.045));
  }
}

TEST_CASE("G042 a slip limit that is no number allows none, an infinite one any") {
  const auto stops = [](double limit) {
    TrackedRig rig(true, [limit](Limits& limits) {
      limits.parts[gripper].modes.gripper_position.slip_limit = limit;
    });
    close_from(rig, opening(0.03), 0.079);
    for (int i = 0; i < 3; ++i) rig.act();
    rig.positions[gripper_joint] = 0.04;
    rig.act();
    return rig.stopped();
  };
  CHECK_FALSE(stops(infinite));
  CHECK(stops(not_a_number));
  CHECK(stops(slip));
}
