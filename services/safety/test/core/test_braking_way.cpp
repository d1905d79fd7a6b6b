// Where joints are while they brake. Two slides brake at 5 m/s2: from 1 m/s in 0.2 s and 0.1 m,
// from -0.5 m/s in 0.1 s and 25 mm.

#include <doctest/doctest.h>

#include "core/trajectory/braking.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr JointSet six = 0b111111;  // of either robot: all that it commands

Limits slides() {
  Limits limits = free_arm::limits();
  for (const std::uint8_t j : {free_arm::slide_x, free_arm::slide_y, free_arm::slide_z})
    limits.joints[j].acceleration_limit = 5.0;
  return limits;
}

Branch going() {
  Branch branch;
  branch.now = branch.speed = Joints{};
  branch.now[free_arm::slide_x] = 0.5;
  branch.speed[free_arm::slide_x] = 1.0;
  branch.speed[free_arm::slide_y] = -0.5;
  return branch;
}

Joints place(const Braking& braking, double share) {
  Joints joints{};
  braking.at(share, joints);
  return joints;
}

}  // namespace

TEST_CASE("each joint brakes at its own deceleration, and waits for the others where it stands") {
  const Limits limits = slides();
  const RobotModel model(limits);
  const Branch branch = going();
  const Braking braking(model, branch, six, 0);
  const auto check = [&](double share, double x, double y) {
    CHECK(place(braking, share)[free_arm::slide_x] == doctest::Approx(x));
    CHECK(place(braking, share)[free_arm::slide_y] == doctest::Approx(y));
  };
  check(0.0, 0.5, 0.0);
  check(0.25, 0.54375, -0.01875);  // 0.05 s: 0.05 - 0.00625 and -0.025 + 0.00625
  check(0.5, 0.575, -0.025);       // 0.1 s: 0.1 - 0.025
  check(1.0, 0.6, -0.025);
  CHECK(braking.end()[free_arm::slide_x] == doctest::Approx(0.6));
  CHECK(braking.end()[free_arm::slide_y] == doctest::Approx(-0.025));
}

TEST_CASE("a joint that lags goes on at its speed first, one that stands has nothing to wait for") {
  Limits limits = slides();
  limits.joints[free_arm::slide_x].stop_lag = 0.1;
  limits.joints[free_arm::slide_z].stop_lag = 60.0;
  const RobotModel model(limits);
  const Branch branch = going();
  const Braking braking(model, branch, six, only(free_arm::slide_x) | only(free_arm::slide_z));
  const auto x = [&](double share) { return place(braking, share)[free_arm::slide_x]; };
  CHECK(x(1.0 / 6.0) == doctest::Approx(0.55));  // 0.05 s of 0.3
  CHECK(x(0.5) == doctest::Approx(0.64375));     // 0.1 s of lag, then 0.05 - 0.00625
  CHECK(x(1.0) == doctest::Approx(0.7));
  CHECK(braking.end()[free_arm::slide_x] == doctest::Approx(0.7));
}

TEST_CASE("a base brakes after its reaction, and what nothing commands stays where it is") {
  Limits limits = test_limits();  // reacts within 0.1 s
  limits.joints[base_x].acceleration_limit = 5.0;
  const RobotModel model(limits);
  Branch branch;
  branch.now = branch.speed = Joints{};
  branch.speed[base_x] = -1.0;
  branch.speed[torso] = 0.25;
  const Braking braking(model, branch, six, 0);
  CHECK(place(braking, 0.5)[base_x] == doctest::Approx(-0.14375));  // 0.15 s of 0.3
  CHECK(braking.end()[base_x] == doctest::Approx(-0.2));
  CHECK(place(braking, 0.5)[torso] == 0.0);
  CHECK(braking.end()[torso] == 0.0);
}

TEST_CASE("a joint that does not move for the chunk stays, however fast it is said to be") {
  const Limits limits = slides();
  const RobotModel model(limits);
  const Branch branch = going();
  const Braking braking(model, branch, only(free_arm::slide_y), 0);
  CHECK(braking.end()[free_arm::slide_x] == 0.5);
  CHECK(place(braking, 0.5)[free_arm::slide_x] == 0.5);
  CHECK(place(braking, 0.5)[free_arm::slide_y] == doctest::Approx(-0.01875));  // 0.05 s of 0.1
}
