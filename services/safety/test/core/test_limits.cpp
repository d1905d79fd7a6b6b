// A configuration is fit to judge with, or is refused with the name of the key.

#include <doctest/doctest.h>

#include <functional>
#include <string>

#include "boundary.hpp"
#include "test_robot.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

std::string fault_after(const std::function<void(Limits&)>& spoil) {
  Limits limits = test_limits();
  spoil(limits);
  return std::string(check_limits(limits).view());
}

// Every limit that must be a finite number above 0.
std::vector<double*> positive_limits(Limits& limits) {
  std::vector<double*> all;
  for (JointLimits& item : limits.joints) {
    all.insert(all.end(), {&item.effort_limit, &item.jump_limit, &item.standstill_velocity});
    if (item.part != gripper)  // not told how fast
      all.insert(all.end(), {&item.velocity_limit, &item.acceleration_limit});
  }
  for (PassiveLimits& item : limits.passive_joints) {
    all.push_back(&item.jump_limit);
    all.push_back(&item.standstill_velocity);
  }
  ModeLimits& arm_modes = limits.parts[arm].modes;
  for (CartesianLimits* mode : {&arm_modes.cartesian_delta, &arm_modes.cartesian_twist,
                                &limits.parts[base].modes.body_twist})
    for (double* value : {&mode->linear_limit, &mode->angular_limit, &mode->linear_step_limit,
                          &mode->angular_step_limit})
      all.push_back(value);
  all.push_back(&arm_modes.joint_position.step_limit[arm_2]);
  all.push_back(&arm_modes.joint_velocity.step_limit[arm_1]);
  all.push_back(&arm_modes.cartesian_pose.linear_step_limit);
  all.push_back(&arm_modes.cartesian_pose.angular_step_limit);
  all.push_back(&limits.parts[base].modes.joint_velocity.step_limit[base_yaw]);
  all.push_back(&limits.parts[gripper].modes.gripper_position.step_limit);
  all.push_back(&limits.parts[composite].modes.composite_mode.step_limit);
  return all;
}

}  // namespace

TEST_CASE("the test robot's configuration has no fault") {
  CHECK(check_limits(test_limits()).empty());
}

TEST_CASE("every limit that is missing, not finite, zero or negative is refused") {
  Limits reference = test_limits();
  const std::size_t count = positive_limits(reference).size();
  CHECK(count == 49);
  for (std::size_t i = 0; i < count; ++i)
    for (const double bad : {unset, infinite, -infinite, 0.0, -1.0}) {
      Limits limits = test_limits();
      *positive_limits(limits)[i] = bad;
      const std::string fault(check_limits(limits).view());
      CHECK(fault.find("expected a finite number above 0") != std::string::npos);
    }
}

TEST_CASE("ranges must be finite and not inverted") {
  for (const double bad : {unset, infinite, -infinite, 3.0}) {
    CHECK_FALSE(fault_after([bad](Limits& l) { l.joints[arm_1].bounds.lower = bad; }).empty());
    CHECK_FALSE(fault_after([bad](Limits& l) { l.passive_joints[0].bounds.lower = bad; }).empty());
    CHECK_FALSE(fault_after([bad](Limits& l) {
                  l.parts[gripper].modes.gripper_position.lower = bad;
                }).empty());
  }
  CHECK(fault_after([](Limits& l) { l.joints[arm_1].bounds.upper = -2.0; }) ==
        "joints.arm_1.bounds: expected finite lower < upper, got -2 and -2");
  for (const double bad : {unset, infinite, -0.1})
    CHECK_FALSE(fault_after([bad](Limits& l) { l.joints[arm_1].bounds.tolerance = bad; }).empty());
}

TEST_CASE("names are there, and there once") {
  CHECK(fault_after([](Limits& l) { l.joints[1].name = "base_x"; }) ==
        "joints: base_x is there twice");
  CHECK(fault_after([](Limits& l) { l.parts[1].name = "arm"; }) == "parts: arm is there twice");
  CHECK(fault_after([](Limits& l) { l.joints[1].name.clear(); }) ==
        "joints: a joint without a name");
  CHECK(fault_after([](Limits& l) { l.passive_joints[0].name.clear(); }) ==
        "passive_joints: a joint without a name");
  CHECK(fault_after([](Limits& l) { l.parts[1].name.clear(); }) == "parts: a part without a name");
  CHECK(fault_after([](Limits& l) { l.robot.clear(); }) == "robot, profile: expected names");
  CHECK(fault_after([](Limits& l) { l.robot_hash = Hash{}; }) ==
        "robot_hash: expected the robot's hash, got none");
  CHECK(fault_after([](Limits& l) { l.joints.clear(); }) ==
        "joints, parts: expected at least one of each");
}

TEST_CASE("joints, parts and modes must agree") {
  CHECK(fault_after([](Limits& l) { l.joints[0].part = 9; }) == "joints.base_x.part: no such part");
  CHECK(fault_after([](Limits& l) { l.joints[arm_1].part = gripper; }) ==
        "parts.arm.joints: a joint that is not this part's");
  CHECK(fault_after([](Limits& l) { l.parts[arm].joints[0] = 31; }) ==
        "parts.arm.joints: a joint that is not this part's");
  CHECK(fault_after([](Limits& l) {
          l.parts[base].modes.joint_position = joint_mode({0, 1, 2}, 0.1);
        }) == "parts.base.modes.joint_position: base_x has no bounds to judge positions by");
  CHECK(fault_after([](Limits& l) {
          l.parts[composite].modes = ModeLimits{};
          l.parts[composite].modes.joint_velocity = joint_mode({}, 0.1);
        }) == "parts.composite.modes.joint_velocity: the part has no joints");
  CHECK(fault_after([](Limits& l) {
          l.parts[arm].modes.gripper_position = scalar_mode(0.0, 1.0, 1.0);
        }) == "parts.arm.modes.gripper_position: expected exactly one joint, with bounds");
  CHECK(fault_after([](Limits& l) { l.parts[arm].modes.cartesian_delta.frames.clear(); }) ==
        "parts.arm.modes.cartesian_delta.frames: expected at least one");
}

TEST_CASE("the robot's links are one tree, root first, moved by measured joints") {
  const auto fault = [](auto field, auto value, std::size_t link = 2) {
    return fault_after([=](Limits& l) { l.kinematics.links[link].*field = value; });
  };
  CHECK(fault_after([](Limits& l) { l.kinematics.links.clear(); }) ==
        "kinematics: expected a root");
  CHECK(fault(&Link::name, Name("column")) == "kinematics: column is there twice");
  CHECK(fault(&Link::name, Name()) == "kinematics: a link without a name");
  CHECK(fault(&Link::name, Name(), 0) == "kinematics: a link without a name");
  for (const std::size_t parent : {std::size_t{2}, std::size_t{3}, no_link})
    CHECK(fault(&Link::parent, parent) ==
          "kinematics.upper.parent: expected a link that comes before it");
  CHECK(fault(&Link::joint, measured_count) == "kinematics.upper.joint: no such measured joint");
  CHECK(fault(&Link::joint, max_measured, 4) == "");  // the tool is fixed
  CHECK(fault(&Link::motion, LinkMotion::slide) ==
        "kinematics.upper.kind: not that of joint arm_1");
  CHECK(fault(&Link::joint, gripper_joint) ==
        "kinematics.upper.kind: not that of joint gripper_joint");
  for (const double bad : {unset, infinite, 0.0, 1.0 + 1e-8}) {
    CHECK(fault(&Link::axis, std::array{0.0, 0.0, bad})
              .starts_with("kinematics.upper.axis: expected a unit length, got "));
    CHECK(fault(&Link::rotation_xyzw, std::array{0.0, 0.0, 0.0, bad})
              .starts_with("kinematics.upper.rotation_xyzw: expected a unit length, got "));
  }
  for (const double bad : {unset, infinite, -infinite})
    CHECK(fault(&Link::translation, std::array{0.0, bad, 0.0}) ==
          "kinematics.upper.translation: expected finite numbers");
}

TEST_CASE("a pose needs a box, and a frame that the part does not move") {
  const auto fault = [](const std::function<void(PoseLimits&)>& spoil) {
    return fault_after([&](Limits& l) { spoil(l.parts[arm].modes.cartesian_pose); });
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double bad : {unset, infinite, 1.0, 2.0})
      CHECK(fault([=](PoseLimits& pose) { pose.lower[axis] = bad; })
                .starts_with(std::string("parts.arm.modes.cartesian_pose ") + "xyz"[axis] +
                             ": expected finite lower < upper"));
  CHECK(fault([](PoseLimits& pose) { pose.frames.clear(); }) ==
        "parts.arm.modes.cartesian_pose.frames: expected at least one");
  CHECK(fault([](PoseLimits& pose) { pose.frames[0] = "odom"; }) ==
        "parts.arm.modes.cartesian_pose.frames: odom is no link of the description");
  CHECK(fault([](PoseLimits& pose) { pose.frames[0] = "upper"; }) ==
        "parts.arm.modes.cartesian_pose.frames: upper moves with the part");
  CHECK(fault([](PoseLimits& pose) { pose.frames[0] = "column"; }) == "");  // moved by no arm joint
}

TEST_CASE("the protocol's own limits are within what the gate has room for") {
  const auto fault = [](auto field, auto value) {
    return fault_after([=](Limits& l) { l.protocol.*field = value; });
  };
  CHECK(fault(&ProtocolLimits::horizon_max, 65U) ==
        "protocol.horizon_max: expected 1 to 64, got 65");
  CHECK_FALSE(fault(&ProtocolLimits::horizon_max, 0U).empty());
  CHECK_FALSE(fault(&ProtocolLimits::age_max_ticks, 0U).empty());
  for (const double bad : {unset, infinite, 0.0, 51.0})
    CHECK_FALSE(fault(&ProtocolLimits::chunk_rate_max_hz, bad).empty());
  CHECK_FALSE(fault(&ProtocolLimits::seq_jump_max, std::uint64_t{0}).empty());
  CHECK_FALSE(fault(&ProtocolLimits::state_timeout_ms, 0U).empty());
  CHECK_FALSE(fault(&ProtocolLimits::heartbeat_timeout_realtime_ms, 0U).empty());
  CHECK_FALSE(fault(&ProtocolLimits::heartbeat_timeout_lockstep_ms, 0U).empty());
  CHECK_FALSE(fault(&ProtocolLimits::lease_interval_ms, 5U).empty());
  CHECK_FALSE(fault(&ProtocolLimits::idle_disarm_s, 0U).empty());
  CHECK_FALSE(fault(&ProtocolLimits::stops_to_latch, 0U).empty());
  CHECK_FALSE(fault(&ProtocolLimits::stops_to_latch, 17U).empty());
  CHECK_FALSE(fault(&ProtocolLimits::stop_window_s, 0U).empty());
  CHECK_FALSE(fault(&ProtocolLimits::bad_frames_limit, 17U).empty());
  CHECK_FALSE(fault(&ProtocolLimits::bad_frames_window_ticks, 0U).empty());
  CHECK_FALSE(fault_after([](Limits& l) { l.period_ns = 0; }).empty());
}

TEST_CASE("a binary gripper is one joint with bounds, like one of openings") {
  CHECK(fault_after([](Limits& l) { l.parts[arm].modes.gripper_binary = binary_mode(); }) ==
        "parts.arm.modes.gripper_binary: expected exactly one joint, with bounds");
}

TEST_CASE("the joint of a hand that is only opened or switched needs no speed, any other does") {
  const auto fault = [](auto change) {
    return fault_after([&](Limits& l) {
      ModeLimits& modes = l.parts[gripper].modes;
      modes = ModeLimits{};
      change(modes);
    });
  };
  CHECK(fault([](ModeLimits& m) { m.gripper_binary = binary_mode(); }).empty());
  CHECK(fault([](ModeLimits& m) { m.gripper_position = scalar_mode(0.0, 0.08, 0.05); }).empty());
  CHECK_FALSE(fault([](ModeLimits&) {}).empty());
}

TEST_CASE("every joint is listed once, by the part it says it belongs to") {
  CHECK(fault_after([](Limits& l) { l.parts[arm].joints[1] = arm_1; }) ==
        "parts.arm.joints: arm_1 is there twice");
  CHECK(fault_after([](Limits& l) { (void)l.parts[arm].joints.push_back(arm_1); }) ==
        "parts.arm.joints: arm_1 is there twice");
  CHECK(fault_after([](Limits& l) { l.parts[base].joints.erase_at(2); }) ==
        "joints.base_yaw: base does not list it among its joints");
}

TEST_CASE("names, period and lists at the edge of what a configuration may be") {
  CHECK(fault_after([](Limits& limits) { limits.profile = ""; }) ==
        "robot, profile: expected names");
  CHECK(fault_after([](Limits& limits) { limits.robot = ""; }) == "robot, profile: expected names");
  for (const std::uint64_t good : {1'000'000ULL, 1'000'000'000ULL})
    CHECK(fault_after([good](Limits& limits) { limits.period_ns = good; }).empty());
  for (const std::uint64_t bad : {999'999ULL, 1'000'000'001ULL})
    CHECK(fault_after([bad](Limits& limits) { limits.period_ns = bad; }).find("period_ns") == 0);
  CHECK(fault_after([](Limits& limits) { limits.parts.clear(); }) ==
        "joints, parts: expected at least one of each");
  CHECK(fault_after([](Limits& limits) { limits.joints.clear(); }) ==
        "joints, parts: expected at least one of each");
}

TEST_CASE("a range needs two finite ends, the lower one below") {
  const auto fault = [](double lower, double upper) {
    return fault_after([=](Limits& l) { l.joints[arm_1].bounds = {lower, upper, 0.0}; });
  };
  CHECK(fault(-1.0, 1.0).empty());
  CHECK(fault(-infinite, 1.0).find("joints.arm_1.bounds") == 0);
  CHECK(fault(-1.0, infinite).find("joints.arm_1.bounds") == 0);
  CHECK(fault(1.0, 1.0).find("joints.arm_1.bounds") == 0);
}

TEST_CASE("positions of a joint without bounds: a continuous one may have them, a slide may not") {
  CHECK(fault_after([](Limits& limits) {
          PartLimits& yaw = limits.parts[base];
          yaw.modes.joint_position = joint_mode({base_x, base_y, base_yaw}, 0.1);
          for (const std::size_t j : {base_x, base_y}) {
            limits.joints[j].bounded = true;
            limits.joints[j].bounds = {-1.0, 1.0, 0.0};
          }
        }).empty());
  CHECK(fault_after([](Limits& limits) { limits.joints[gripper_joint].bounded = false; }) ==
        "parts.gripper.modes.gripper_binary: expected exactly one joint, with bounds");
}

TEST_CASE("every number of the protocol has its range, ends included") {
  struct Range {
    const char* name;
    std::function<void(ProtocolLimits&, double)> set;
    double lowest, highest, unit;
  };
  const auto whole = [](auto ProtocolLimits::*field) {
    return [field](ProtocolLimits& limits, double value) {
      limits.*field = static_cast<std::remove_reference_t<decltype(limits.*field)>>(value);
    };
  };
  using P = ProtocolLimits;
  const std::vector<Range> ranges{
      {"horizon_max", whole(&P::horizon_max), 1, 64, 1},
      {"age_max_ticks", whole(&P::age_max_ticks), 1, 1000, 1},
      {"chunk_rate_max_hz", whole(&P::chunk_rate_max_hz), 0.01, 50, 0.001},
      {"seq_jump_max", whole(&P::seq_jump_max), 1, 1e9, 1},
      {"state_timeout_ms", whole(&P::state_timeout_ms), 1, 10'000, 1},
      {"heartbeat_timeout_realtime_ms", whole(&P::heartbeat_timeout_realtime_ms), 50, 10'000, 1},
      {"heartbeat_timeout_lockstep_ms", whole(&P::heartbeat_timeout_lockstep_ms), 50, 60'000, 1},
      {"lease_interval_ms", whole(&P::lease_interval_ms), 6, 1000, 1},
      {"idle_disarm_s", whole(&P::idle_disarm_s), 1, 86'400, 1},
      {"stops_to_latch", whole(&P::stops_to_latch), 1, 16, 1},
      {"stop_window_s", whole(&P::stop_window_s), 1, 86'400, 1},
      {"bad_frames_limit", whole(&P::bad_frames_limit), 1, 16, 1},
      {"bad_frames_window_ticks", whole(&P::bad_frames_window_ticks), 1, 1000, 1}};
  for (const Range& range : ranges) {
    const auto fault = [&range](double value) {
      return fault_after([&](Limits& limits) { range.set(limits.protocol, value); });
    };
    CHECK(fault(range.lowest).empty());
    CHECK(fault(range.highest).empty());
    for (const double outside : {range.lowest - range.unit, range.highest + range.unit})
      CHECK(fault(outside).find(std::string("protocol.") + range.name + ": expected") == 0);
  }
}
