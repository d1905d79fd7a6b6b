// G040: measured motion against the rows that acted, of joints and the base, in both pacings.

#include <cmath>
#include <functional>
#include <numbers>

#include "tracked_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// Half to all of what a row asks for happens in its tick; an eighth more or less is fine.
constexpr double slack = 0.125;
constexpr double eps = 1e-12;
constexpr Gain half_to_all{0.5, 1.0};

void narrow(Limits& limits) {
  ModeLimits& modes = limits.parts[arm].modes;
  for (const std::size_t j : {arm_1, arm_2}) {
    modes.joint_position.tracking[j] = slack;
    modes.joint_velocity.tracking[j] = slack;
  }
  modes.joint_velocity.gain = half_to_all;
  CartesianLimits& twist = limits.parts[base].modes.body_twist;
  twist.gain = half_to_all;
  twist.linear_tracking = twist.angular_tracking = slack;
}

struct Case {
  std::function<void(TrackedRig&)> measure;
  bool stops;
};

// Whether the gate stops after the last of some rows, told what was measured by then.
void check_cases(const ChunkBuilder& command, std::size_t rows_before,
                 const std::function<void(TrackedRig&)>& measured_before,
                 const std::vector<Case>& cases) {
  for (const bool lockstep : {true, false}) {
    for (const Case& item : cases) {
      TrackedRig rig(lockstep, narrow);
      rig.begin(command);
      measured_before(rig);
      for (std::size_t i = 0; i < rows_before; ++i) rig.act();
      REQUIRE_FALSE(rig.stopped());
      item.measure(rig);
      rig.act();
      CAPTURE(lockstep);
      CHECK(rig.stopped() == item.stops);
    }
  }
}

Case position(double value, bool stops) {
  return {[value](TrackedRig& rig) { rig.positions[arm_1] = value; }, stops};
}

Case speed(double value, bool stops) {
  return {[value](TrackedRig& rig) { rig.velocities[arm_1] = value; }, stops};
}

void nothing(TrackedRig&) {}

}  // namespace

TEST_CASE("G040 joint targets: the joint is within the tracking limit of the target that acted") {
  const ChunkBuilder up = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, Row(4, 0.25));
  check_cases(up, 0, nothing,
              {position(0.125, false), position((0.125 - eps), true), position(0.25, false),
               position(0.375, false), position((0.375 + eps), true)});
}

TEST_CASE("G040 joint velocities after a hold: from standstill to the upper share, and the slack") {
  for (const double sign : {1.0, -1.0}) {
    const ChunkBuilder command =
        ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, Row(4, 0.5 * sign));
    check_cases(command, 0, nothing,
                {speed(0.625 * sign, false), speed((0.625 + eps) * sign, true),
                 speed(-0.125 * sign, false), speed((0.125 + eps) * -sign, true)});
  }
}

TEST_CASE("G040 joint velocities after a row: between the shares of both, and the slack") {
  for (const double sign : {1.0, -1.0}) {
    const auto at_speed = [sign](TrackedRig& rig) { rig.velocities[arm_1] = 0.4 * sign; };
    const ChunkBuilder steady =
        ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, Row(4, 0.5 * sign));
    check_cases(steady, 1, at_speed,
                {speed(0.125 * sign, false), speed((0.125 - eps) * sign, true),
                 speed(0.625 * sign, false), speed((0.625 + eps) * sign, true)});
    const ChunkBuilder faster =
        ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.5 * sign, 1.0 * sign});
    check_cases(faster, 1, at_speed,
                {speed(0.125 * sign, false), speed((0.125 - eps) * sign, true),
                 speed(1.125 * sign, false), speed((1.125 + eps) * sign, true)});
    const ChunkBuilder back =
        ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.25 * sign, -0.25 * sign});
    check_cases(back, 1, [](TrackedRig&) {},
                {speed(0.375 * sign, false), speed((0.375 + eps) * sign, true),
                 speed(-0.375 * sign, false), speed((0.375 + eps) * -sign, true)});
  }
}

TEST_CASE("G040 after a hold in which the joint still moved, that speed is as good as standstill") {
  for (const bool lockstep : {true, false}) {
    for (const double after : {-0.5, (-0.5 - eps)}) {
      TrackedRig rig(lockstep, narrow);
      rig.velocities[arm_1] = -0.375;
      rig.hold();
      rig.begin(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.0, 0.0}));
      rig.velocities[arm_1] = after;
      rig.act();
      CHECK(rig.stopped() == (after < -0.5));
    }
  }
}

TEST_CASE("G040 a joint that the row before left alone starts from where it was") {
  ChunkBuilder both;
  Row first(joint_count, 0.0), second(joint_count, 0.0);
  first[arm_1] = second[arm_1] = second[arm_2] = 0.5;
  both.add(arm, Mode::joint_velocity, {first, second}, {arm_1, arm_2});
  for (const bool lockstep : {true, false}) {
    TrackedRig rig(lockstep, narrow);
    rig.begin(both);
    rig.velocities[arm_1] = 0.5;
    rig.act();
    rig.velocities[arm_2] = -slack;
    rig.act();
    CHECK_FALSE(rig.stopped());
  }
}

TEST_CASE("G040 a body twist: the base's displacement along its own axes") {
  const auto moved = [](double x, double y, double yaw, bool stops) {
    return Case{[=](TrackedRig& rig) {
                  rig.positions[base_x] += 0.05 * x;
                  rig.positions[base_y] += 0.05 * y;
                  rig.positions[base_yaw] += 0.05 * yaw;
                },
                stops};
  };
  Row told{0.5, 0, 0, 0, 0, 0.75};
  const ChunkBuilder command =
      ChunkBuilder().add(base, Mode::body_twist, Rows(4, told), {}, "base_link");
  // The first row: from standstill to all of it.
  check_cases(command, 0, nothing,
              {moved(0.625 - eps, 0, 0, false), moved(0.625 + eps, 0, 0, true),
               moved(-0.125 + eps, 0, 0, false), moved(-0.125 - eps, 0, 0, true),
               moved(0.3, 0.125 - eps, 0, false), moved(0.3, 0.125 + eps, 0, true),
               moved(0, 0, 0.875 - eps, false), moved(0, 0, 0.875 + eps, true)});
  // Steady: at least half of it. The base has turned to the left by a right angle.
  for (const bool lockstep : {true, false}) {
    for (const double along : {0.125 + eps, 0.125 - eps}) {
      TrackedRig rig(lockstep, narrow);
      for (int i = 0; i < 4; ++i) {
        rig.positions[base_yaw] += std::numbers::pi / 8;
        rig.hold();
      }
      rig.begin(ChunkBuilder().along(base, Mode::body_twist, 0, Row(4, 0.5)));
      rig.positions[base_y] += 0.02;
      rig.act();
      rig.positions[base_y] += 0.05 * along;
      rig.act();
      CHECK(rig.stopped() == (along < 0.125));
    }
  }
}

TEST_CASE("G040 a base that turns in place is one whose origin stays, not its yaw axis") {
  for (const bool lockstep : {true, false}) {
    for (const bool origin_stays : {true, false}) {
      TrackedRig rig(lockstep, [](Limits& limits) {
        narrow(limits);
        limits.base.yaw_axis = {-0.4, 0.2};
      });
      rig.begin(ChunkBuilder().along(base, Mode::body_twist, 5, Row(4, 0.75)));
      for (int i = 0; i < 4 && !rig.stopped(); ++i) {
        // The axis is 0.4 m behind the origin and 0.2 m to its left: it goes around the origin.
        const double yaw = rig.positions[base_yaw] += 0.0375;
        if (origin_stays) {
          rig.positions[base_x] = -0.4 * std::cos(yaw) - 0.2 * std::sin(yaw) + 0.4;
          rig.positions[base_y] = -0.4 * std::sin(yaw) + 0.2 * std::cos(yaw) - 0.2;
        }
        rig.act();
      }
      CHECK(rig.stopped() == !origin_stays);
    }
  }
}

TEST_CASE("G040 the turn of a base that is told past half a turn is a small one") {
  TrackedRig rig(true, narrow);
  rig.begin(ChunkBuilder().along(base, Mode::body_twist, 5, Row(4, 0.5)));
  rig.act();
  REQUIRE_FALSE(rig.stopped());
  rig.positions[base_yaw] = 0.025 - 2 * std::numbers::pi;
  rig.act();
  CHECK_FALSE(rig.stopped());
}

TEST_CASE("G040 a part that held, and modes without a tracking model, are not judged") {
  for (const bool lockstep : {true, false}) {
    TrackedRig held(lockstep, narrow);
    held.begin(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, Row(4, 0.25)));
    held.velocities[arm_1] = 1.4;
    held.positions[arm_1] = -0.4;
    held.hold();
    CHECK_FALSE(held.stopped());

    ChunkBuilder others;
    others.scalar(gripper, Mode::gripper_position, Row(4, 0.06));
    others.scalar(composite, Mode::composite_mode, Row(4, 1.0));
    TrackedRig rig(lockstep, narrow);
    rig.begin(others);
    rig.positions[gripper_joint] = 0.0;
    rig.act();
    CHECK_FALSE(rig.stopped());
  }
}

TEST_CASE("G040 where a state was lost, targets are judged and motions are not") {
  TrackedRig motion(false, narrow);
  motion.begin(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, Row(6, 0.5)));
  motion.act();
  motion.pass(1);
  motion.velocities[arm_1] = -1.0;
  motion.next_tick_of({row_of(motion.safe, 2), no_row, no_row, no_row});
  CHECK_FALSE(motion.stopped());
  motion.velocities[arm_1] = -1.0;
  motion.next_tick_of({row_of(motion.safe, 3), no_row, no_row, no_row});
  CHECK(motion.stopped());

  TrackedRig target(false, narrow);
  target.begin(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, Row(6, 0.125)));
  target.act();
  target.pass(1);
  target.positions[arm_1] = -0.125;
  target.next_tick_of({row_of(target.safe, 2), no_row, no_row, no_row});
  CHECK(target.stopped());
}

TEST_CASE(
    "G040 the stop names part, joint, value, limit and source, ends the claim and is counted") {
  TrackedRig rig(true, narrow);
  rig.begin(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, Row(4, 0.25)));
  rig.positions[arm_1] = -0.25;
  rig.act();
  CHECK(rig.lease().grants.empty());
  CHECK(rig.lease().stop_ids.size() == 1);
  CHECK(rig.cause() == "stopped: G040 arm arm_1: 0.5 rad, limit 0.125 rad (tracking_limits)");
  CHECK(rig.counter("G040") == 1);
}

TEST_CASE("G040 a limit that is no number allows no motion, and a vast one any") {
  const auto stops = [](double tracking, double lower, double upper) {
    TrackedRig rig(true, [&](Limits& limits) {
      JointModeLimits& mode = limits.parts[arm].modes.joint_velocity;
      mode.tracking[arm_1] = tracking;
      mode.gain = {lower, upper};
    });
    rig.begin(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, Row(4, 0.5)));
    rig.act();
    return rig.stopped();
  };
  CHECK_FALSE(stops(slack, 0.5, 1.0));
  CHECK(stops(not_a_number, 0.5, 1.0));
  CHECK_FALSE(stops(infinite, 0.5, 1.0));
}

TEST_CASE("G040 what is measured as no number stops as G011 before it is compared") {
  for (const double odd : {not_a_number, infinite, -infinite}) {
    TrackedRig rig(true, narrow);
    rig.begin(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, Row(4, 0.5)));
    rig.velocities[arm_1] = odd;
    rig.act();
    CHECK(rig.cause().starts_with("stopped: G011 arm_1: "));
  }
}
