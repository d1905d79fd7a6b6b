// The questions that a gate asks its own core at boot: all shipped robots answer them, and limits
// that went wrong after they were loaded do not.

#include "process/self_test.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <limits>
#include <memory>
#include <string>

#include "config/config_loader.hpp"
#include "core/test_robot.hpp"
#include "process/refusal.hpp"

using namespace fairlead;

namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

std::string shipped(const std::string& robot) {
  return FAIRLEAD_ROBOTS_DIR "/" + robot + "/gate.sim.json";
}

// What the gate says of its limits after `harm` was done to them; "" if it finds no fault.
template <class Harm>
std::string complaint(std::unique_ptr<Limits> limits, const Harm& harm) {
  harm(*limits);
  try {
    self_test(*limits);
  } catch (const StartFailed& failed) {
    return failed.what();
  }
  return "";
}

template <class Harm>
std::string of_panda_mobile(const Harm& harm) {
  return complaint(load_limits(shipped("panda_mobile")), harm);
}

// The same of a small robot whose arm has every mode of one.
template <class Harm>
std::string of_test_robot(const Harm& harm) {
  return complaint(std::make_unique<Limits>(test::test_limits()), harm);
}

}  // namespace

TEST_CASE("every shipped gate file knows its answers") {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(FAIRLEAD_ROBOTS_DIR)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("gate.", 0) != 0 || entry.path().extension() != ".json") continue;
    CAPTURE(entry.path().string());
    // The smallest robot that ships, so101, has 23.
    CHECK(self_test(*load_limits(entry.path().string())) > 20);
    ++files;
  }
  CHECK(files >= 4);
}

TEST_CASE("the robot of the tests knows its answers") {
  CHECK(of_panda_mobile([](Limits&) {}) == "");
  CHECK(of_test_robot([](Limits&) {}) == "");
}

TEST_CASE("a limit of a shipped robot that grew beyond all sense is found by part and mode") {
  CHECK(of_panda_mobile(
            [](Limits& limits) { limits.parts[0].modes.cartesian_delta.linear_limit = 1e9; }) ==
        "self-test: part arm, mode cartesian_delta: 999999, number 0: expected G020, got G021");
  CHECK(of_panda_mobile([](Limits& limits) {
          limits.parts[0].modes.cartesian_delta.angular_limit = endless;
        }) ==
        "self-test: part arm, mode cartesian_delta: 999999, number 3: expected G020, got G021");
  CHECK(
      of_panda_mobile([](Limits& limits) { limits.parts[1].modes.gripper_position.upper = 1e9; }) ==
      "self-test: part gripper, mode gripper_position: 999999, number 0: expected G020, got G021");
  CHECK(of_panda_mobile([](Limits& limits) { limits.joints[2].velocity_limit = endless; }) ==
        "self-test: part base, mode joint_velocity: 999999, number 2: expected G020, got G021");
  CHECK(of_panda_mobile(
            [](Limits& limits) { limits.parts[2].modes.joint_velocity.step_limit[1] = endless; }) ==
        "self-test: part base, mode joint_velocity: 0 where 999999 is measured, number 1: expected "
        "G021, got G031");
}

TEST_CASE("so it is in the modes that no shipped robot has") {
  CHECK(of_test_robot([](Limits& limits) {
          limits.parts[test::arm].modes.cartesian_pose.upper[1] = endless;
        }) ==
        "self-test: part arm, mode cartesian_pose: 999999, number 0: expected G020, got G008");
  CHECK(of_test_robot([](Limits& limits) {
          limits.parts[test::composite].modes.composite_mode.lower = -endless;
        }) ==
        "self-test: part composite, mode composite_mode: -999999, number 0: expected G020, got a "
        "release");
  CHECK(of_test_robot([](Limits& limits) {
          limits.joints[test::arm_2].bounded = false;
          limits.parts[test::arm].modes.joint_position.step_limit[test::arm_2] = endless;
        }) ==
        "self-test: part arm, mode joint_position: 999999, number 4: expected G021, got G030");
}

TEST_CASE("bounds that left the numbers a robot can have are found") {
  CHECK(of_test_robot([](Limits& limits) { limits.joints[test::arm_1].bounds.upper = 1e9; }) ==
        "self-test: part arm, mode joint_position: 999999, number 3: expected G020, got G021");
  CHECK(of_test_robot([](Limits& limits) { limits.joints[test::arm_1].bounds.lower = unset; }) ==
        "self-test: part arm, mode joint_position: 999999, number 4: expected G020, got G008");
}

TEST_CASE("protocol limits that went wrong are found") {
  CHECK(of_test_robot([](Limits& limits) { limits.protocol.horizon_max = 0; }) ==
        "self-test: part arm, mode joint_position: NaN, number 3: expected G008, got G007");
}
