// The unit of a verdict's numbers follows from its code, its mode and what it is about.

#include "decisions/unit.hpp"

#include <doctest/doctest.h>

#include <string>

#include "core/test_robot.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

std::string unit(std::uint32_t code, Mode mode, const char* axis, const char* rule = "") {
  static const Limits limits = test_limits();
  Verdict verdict;
  verdict.code = code;
  verdict.part = "gripper";  // of an opening its joint's unit
  verdict.axis = axis;
  verdict.limit_source = rule;
  return unit_of(limits, verdict, static_cast<std::uint8_t>(mode));
}

}  // namespace

TEST_CASE("unit: a joint's limit is told as its mode tells it") {
  CHECK(unit(20, Mode::joint_position, "arm_1") == "rad");
  CHECK(unit(22, Mode::dex_hand_joint, "arm_1") == "rad");
  CHECK(unit(20, Mode::joint_velocity, "arm_1") == "rad/s");
  CHECK(unit(20, Mode::joint_velocity, "base_x") == "m/s");
}

TEST_CASE("unit: motions of tool and base, openings and places") {
  CHECK(unit(20, Mode::cartesian_delta, "linear") == "m");
  CHECK(unit(22, Mode::cartesian_delta, "angular") == "rad");
  CHECK(unit(20, Mode::cartesian_twist, "linear") == "m/s");
  CHECK(unit(21, Mode::body_twist, "angular") == "rad/s");
  CHECK(unit(21, Mode::cartesian_pose, "angular") == "rad");
  CHECK(unit(20, Mode::cartesian_pose, "z") == "m");
  CHECK(unit(20, Mode::cartesian_pose, "quaternion norm") == "");
  CHECK(unit(20, Mode::gripper_position, "opening") == "m");
  CHECK(unit(20, Mode::gripper_binary, "closed") == "");
  CHECK(unit(20, Mode::composite_mode, "composite") == "");
}

TEST_CASE("unit: a joint that is outside its bounds is told where it is, a velocity how fast") {
  const char* only_back = "outside its bounds: only towards them";
  const char* measured = "measured outside bounds + tolerance: only rows that reduce it";
  CHECK(unit(11, Mode::joint_position, "arm_1", only_back) == "rad");
  CHECK(unit(11, Mode::joint_velocity, "arm_1", only_back) == "rad/s");
  CHECK(unit(11, Mode::joint_velocity, "arm_1", measured) == "rad");
  CHECK(unit(11, Mode::joint_position, "base_x", measured) == "m");
}

TEST_CASE("unit: a rule about standing still is about speed in every mode") {
  CHECK(unit(21, Mode::body_twist, "base_x", "a first twist of this part: from standstill") ==
        "m/s");
}

TEST_CASE("unit: what is braked, seen and felt of a joint") {
  CHECK(unit(24, Mode::joint_velocity, "arm_1") == "rad");
  CHECK(unit(24, Mode::joint_velocity, "base_x") == "m");
  CHECK(unit(25, Mode::joint_position, "arm_1") == "rad/s");
  CHECK(unit(40, Mode::joint_position, "arm_1") == "rad");
  CHECK(unit(40, Mode::joint_velocity, "arm_1") == "rad/s");
  CHECK(unit(41, Mode::joint_velocity, "arm_1") == "rad");
  CHECK(unit(42, Mode::joint_position, "arm_1") == "N m");
  CHECK(unit(42, Mode::gripper_position, "gripper_joint") == "N");
}

TEST_CASE("unit: places and distances that rows lead to") {
  CHECK(unit(30, Mode::cartesian_pose, "tool position") == "m");
  CHECK(unit(30, Mode::cartesian_pose, "tool rotation") == "rad");
  CHECK(unit(31, Mode::cartesian_delta, "x") == "m");
  CHECK(unit(32, Mode::joint_velocity, "hand and column") == "m");
  CHECK(unit(33, Mode::cartesian_delta, "singular value") == "");
  CHECK(unit(34, Mode::joint_velocity, "hall") == "m");
}

TEST_CASE("unit: counts, ticks and names have none") {
  CHECK(unit(10, Mode::joint_position, "chunks") == "");
  CHECK(unit(9, Mode::joint_position, "arm_1") == "");
  CHECK(unit(8, Mode::joint_position, "joint_position") == "");
}
