// Limits of what is measured and predicted: gain, tracking, effort, sensors, the protocol's own.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "boundary.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

std::string fault_in(Limits limits, const std::function<void(Limits&)>& spoil) {
  spoil(limits);
  return std::string(check_limits(limits).view());
}

std::string fault_after(const std::function<void(Limits&)>& spoil) {
  return fault_in(test_limits(), spoil);
}

struct Number {
  const char* key;
  std::function<double&(Limits&)> in;
};

const std::vector<Number>& positive_numbers() {
  static const std::vector<Number> numbers{
      {"joints.arm_2.contact_limit",
       [](Limits& l) -> double& { return l.joints[arm_2].contact_limit; }},
      {"joints.base_x.encoder_step",
       [](Limits& l) -> double& { return l.joints[base_x].encoder_step; }},
      {"joints.arm_1.dead_band", [](Limits& l) -> double& { return l.joints[arm_1].dead_band; }},
      {"parts.arm.singularity_limit",
       [](Limits& l) -> double& { return l.parts[arm].singularity_limit; }},
      {"parts.arm.modes.joint_position.tracking of arm_2",
       [](Limits& l) -> double& { return l.parts[arm].modes.joint_position.tracking[arm_2]; }},
      {"parts.base.modes.joint_velocity.tracking of base_yaw",
       [](Limits& l) -> double& { return l.parts[base].modes.joint_velocity.tracking[base_yaw]; }},
      {"parts.arm.modes.cartesian_pose.linear_tracking",
       [](Limits& l) -> double& { return l.parts[arm].modes.cartesian_pose.linear_tracking; }},
      {"parts.arm.modes.cartesian_pose.angular_tracking",
       [](Limits& l) -> double& { return l.parts[arm].modes.cartesian_pose.angular_tracking; }},
      {"parts.arm.modes.cartesian_delta.linear_tracking",
       [](Limits& l) -> double& { return l.parts[arm].modes.cartesian_delta.linear_tracking; }},
      {"parts.arm.modes.cartesian_twist.angular_tracking",
       [](Limits& l) -> double& { return l.parts[arm].modes.cartesian_twist.angular_tracking; }},
      {"parts.base.modes.body_twist.linear_tracking",
       [](Limits& l) -> double& { return l.parts[base].modes.body_twist.linear_tracking; }}};
  return numbers;
}

}  // namespace

TEST_CASE("a joint's lag is a finite number of at least 0") {
  const auto after = [](double lag) {
    return fault_after([lag](Limits& l) { l.joints[arm_1].stop_lag = lag; });
  };
  CHECK(after(0.0).empty());
  CHECK(after(0.06).empty());
  for (const double lag : {-1e-9, unset, std::numeric_limits<double>::infinity()})
    CHECK(after(lag).starts_with(
        "joints.arm_1.stop_lag: expected a finite number of at least 0, got "));
}

TEST_CASE("what is measured and tracked has limits, finite and above 0") {
  for (const Number& number : positive_numbers())
    for (const double bad : {unset, endless, -endless, 0.0, -1.0})
      CHECK(fault_after([&](Limits& l) {
              number.in(l) = bad;
            }).starts_with(std::string(number.key) + ": expected a finite number above 0, got "));
  const auto finger = [](double value) {
    return fault_in(two_arms::limits(), [=](Limits& l) {
      l.parts[two_arms::hand].modes.dex_hand_joint.tracking[two_arms::finger_2] = value;
    });
  };
  CHECK(finger(0.5).empty());
  CHECK(finger(unset).starts_with("parts.right_hand.modes.dex_hand_joint.tracking of finger_2"));
}

TEST_CASE("a part whose tool no mode moves has no singularity to keep away from") {
  CHECK(fault_after([](Limits& l) { l.parts[base].singularity_limit = unset; }) == "");
  CHECK(fault_after([](Limits& l) { l.parts[gripper].singularity_limit = unset; }) == "");
  // One such mode is enough.
  const auto only = [](auto mode) {
    return fault_after([mode](Limits& l) {
      PartLimits& part = l.parts[arm];
      part.singularity_limit = unset;
      part.modes.cartesian_pose.supported = false;
      part.modes.cartesian_delta.supported = false;
      part.modes.cartesian_twist.supported = false;
      (part.modes.*mode).supported = true;
    });
  };
  CHECK(only(&ModeLimits::joint_position) == "");
  CHECK_FALSE(only(&ModeLimits::cartesian_pose).empty());
  CHECK_FALSE(only(&ModeLimits::cartesian_delta).empty());
  CHECK_FALSE(only(&ModeLimits::cartesian_twist).empty());
}

TEST_CASE("a gripper is told openings that its joint has") {
  const auto fault = [](double lower, double upper) {
    return fault_after([=](Limits& l) {
      l.parts[gripper].modes.gripper_position.lower = lower;
      l.parts[gripper].modes.gripper_position.upper = upper;
    });
  };
  CHECK(fault(0.0, 0.08).empty());
  CHECK(fault(0.01, 0.07).empty());
  CHECK(fault(0.0, 0.081) ==
        "parts.gripper.modes.gripper_position: expected lower and upper inside the bounds of "
        "gripper_joint, 0 and 0.08, got 0 and 0.081");
  CHECK_FALSE(fault(-0.001, 0.08).empty());
}

TEST_CASE("a gripper's joint has no limit of speed: nothing tells it how fast") {
  CHECK(fault_after([](Limits& l) { l.joints[gripper_joint].velocity_limit = 0.1; }) ==
        "joints.gripper_joint.velocity_limit, acceleration_limit: expected null, a gripper is not "
        "told how fast, got 0.1 and nan");
  CHECK_FALSE(
      fault_after([](Limits& l) { l.joints[gripper_joint].acceleration_limit = 1.0; }).empty());
  const auto with_targets = [](double velocity) {
    return fault_after([=](Limits& l) {
      l.parts[gripper].modes.joint_position = joint_mode({gripper_joint}, 0.1);
      l.joints[gripper_joint].velocity_limit = velocity;
      l.joints[gripper_joint].acceleration_limit = 1.0;
    });
  };
  CHECK(with_targets(0.1) == "");
  CHECK_FALSE(with_targets(unset).empty());
}

TEST_CASE("a gain lies between 0 and 1.5, its lower end first") {
  const auto fault = [](double lower, double upper) {
    return fault_after(
        [=](Limits& l) { l.parts[base].modes.joint_velocity.gain = {lower, upper}; });
  };
  CHECK(fault(0.0, 1e-9).empty());
  CHECK(fault(0.0, 1.5).empty());
  CHECK(fault(1.5, 1.5).empty());
  CHECK(fault(0.9, 0.8) ==
        "parts.base.modes.joint_velocity.gain: expected 0 <= lower <= upper <= 1.5 and upper "
        "above 0, got 0.9 and 0.8");
  for (const double lower : {unset, -endless, -1e-9})
    CHECK(fault(lower, 1.0).starts_with("parts.base.modes.joint_velocity.gain"));
  for (const double upper : {unset, endless, 0.0, std::nextafter(1.5, 2.0)})
    CHECK(fault(0.0, upper).starts_with("parts.base.modes.joint_velocity.gain"));
  CHECK(fault_after([](Limits& l) {
          l.parts[arm].modes.cartesian_delta.gain.upper = 2.0;
        }).starts_with("parts.arm.modes.cartesian_delta.gain"));
  CHECK(fault_after([](Limits& l) {
          l.parts[base].modes.body_twist.gain = {};
        }).starts_with("parts.base.modes.body_twist.gain"));
}

TEST_CASE("beside a composite switch the gain of a tool motion is 1 at most") {
  const auto fault = [](double upper, bool switches) {
    return fault_after([=](Limits& l) {
      if (!switches) l.parts[composite].modes.composite_mode = {};
      l.parts[arm].modes.cartesian_delta.gain = {0.5, upper};
      l.parts[base].modes.body_twist.gain = {0.0, 1.5};
    });
  };
  CHECK(fault(1.0, true) == "");
  CHECK(fault(just_above(1.0), true)
            .starts_with("parts.arm.modes.cartesian_delta.gain: expected at most 1, as the robot "
                         "has a composite switch, got "));
  CHECK(fault(just_above(1.0), false) == "");
}

TEST_CASE("a part with a composite switch has no other mode") {
  CHECK(fault_after([](Limits& l) {
          l.parts[arm].modes.composite_mode = l.parts[composite].modes.composite_mode;
        }).starts_with("parts.arm.modes: expected composite_mode alone, got joint_position"));
}

TEST_CASE("only joint velocities have a gain among the joint modes") {
  CHECK(fault_after([](Limits& l) { l.parts[arm].modes.joint_position.gain = {}; }) == "");
}

TEST_CASE("a gripper's slip is above 0, or endless where losing an object is no stop") {
  const auto fault = [](double slip) {
    return fault_after(
        [=](Limits& l) { l.parts[gripper].modes.gripper_position.slip_limit = slip; });
  };
  CHECK(fault(1e-9).empty());
  CHECK(fault(endless).empty());
  CHECK(
      fault(0.0) ==
      "parts.gripper.modes.gripper_position.slip_limit: expected a number above 0 or null, got 0");
  for (const double bad : {unset, -endless, -1e-9}) CHECK_FALSE(fault(bad).empty());
  CHECK(fault_after(
            [](Limits& l) { l.parts[composite].modes.composite_mode.slip_limit = unset; }) == "");
}

TEST_CASE("the protocol's numbers of tracking, stopping and the gate's own step have ranges") {
  struct Range {
    const char* name;
    std::uint32_t ProtocolLimits::*field;
    std::uint32_t highest;
  };
  for (const Range& range :
       {Range{"stuck_ticks", &ProtocolLimits::stuck_ticks, 1000},
        Range{"stop_ramp_ms", &ProtocolLimits::stop_ramp_ms, 60'000},
        Range{"step_deadline_us", &ProtocolLimits::step_deadline_us, 1'000'000}}) {
    const auto fault = [&](std::uint32_t value) {
      return fault_after([&](Limits& l) {
        l.protocol.state_timeout_ms = 10'000;
        l.protocol.*range.field = value;
      });
    };
    CHECK(fault(1).empty());
    CHECK(fault(range.highest).empty());
    for (const std::uint32_t bad : {0U, range.highest + 1})
      CHECK(fault(bad).starts_with(std::string("protocol.") + range.name + ": expected 1 to "));
  }
}

TEST_CASE("the gate's own deadline has to end before the states are too old") {
  const auto fault = [](std::uint32_t deadline_us, std::uint32_t timeout_ms) {
    return fault_after([=](Limits& l) {
      l.protocol.step_deadline_us = deadline_us;
      l.protocol.state_timeout_ms = timeout_ms;
    });
  };
  CHECK(fault(249'999, 250).empty());
  CHECK(fault(250'000, 250) ==
        "protocol.step_deadline_us: expected less than state_timeout_ms, 250000 us, got 250000");
  CHECK_FALSE(fault(100'000, 100).empty());
  CHECK_FALSE(fault(1'000'000, 250).empty());
}

TEST_CASE("a second person is waited for by an hour at most, or not at all") {
  const auto fault = [](std::uint32_t seconds) {
    return fault_after([=](Limits& l) { l.protocol.second_person_s = seconds; });
  };
  CHECK(fault(0).empty());
  CHECK(fault(3600).empty());
  CHECK(fault(3601) == "protocol.second_person_s: expected 0 to 3600, got 3601");
}
