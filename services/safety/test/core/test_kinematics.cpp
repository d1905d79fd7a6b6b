// Where a link is and how it moves, against numbers worked out by hand and against differences.

#include <doctest/doctest.h>

#include <cmath>

#include "boundary.hpp"
#include "core/kinematics/forward_kinematics.hpp"
#include "core/modes/commanded_motion.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr std::size_t root = 0, lower = 3, tool = 4;
const double half_pi = std::acos(0.0);

MeasuredState at(double torso_height, double first, double second) {
  MeasuredState state = state_at_rest();
  state.positions[torso] = torso_height;
  state.positions[arm_1] = first;
  state.positions[arm_2] = second;
  return state;
}

Eigen::Matrix3d about(const Eigen::Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

// A robot with this tree.
struct Robot {
  explicit Robot(const Limits& robot) : limits(robot) {}
  explicit Robot(const Kinematics& tree) : Robot(with(tree)) {}
  [[nodiscard]] Pose pose(const MeasuredState& state, std::size_t frame, std::size_t link) const {
    return link_pose(model, {model, state.positions}, frame, link);
  }
  [[nodiscard]] Twist twist(const MeasuredState& state, std::size_t frame, std::size_t link,
                            const PartLimits* part = nullptr) const {
    return link_twist(model, state, frame, link, part);
  }
  static Limits with(const Kinematics& tree) {
    Limits limits = test_limits();
    limits.kinematics = tree;
    limits.collision = {};
    return limits;
  }
  Limits limits;
  RobotModel model{limits};
};

double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Pose one{a, Eigen::Vector3d::Zero()}, other{b, Eigen::Vector3d::Zero()};
  return motion_between(one, other).tail<3>().norm();
}

void check_position(const Pose& pose, double x, double y, double z) {
  CHECK((pose.position - Eigen::Vector3d(x, y, z)).norm() < 1e-12);
}

}  // namespace

TEST_CASE("the tool of the test robot is where it is drawn") {
  const Robot robot(test_limits());
  check_position(robot.pose(at(0, 0, 0), root, tool), 0.7, 0.0, 0.5);
  check_position(robot.pose(at(0.1, 0, 0), root, tool), 0.7, 0.0, 0.6);
  check_position(robot.pose(at(0, half_pi, 0), root, tool), 0.0, 0.7, 0.5);
  check_position(robot.pose(at(0, 0, half_pi), root, tool), 0.4, 0.0, 0.2);
  const Pose turned = robot.pose(at(0, half_pi, 0), root, tool);
  CHECK(angle_between(turned.rotation, about(Eigen::Vector3d::UnitZ(), half_pi)) < 1e-12);
}

TEST_CASE("a pose is told in any frame of the tree") {
  const Robot robot(test_limits());
  check_position(robot.pose(at(0.2, 0.7, -0.3), lower, tool), 0.3, 0.0, 0.0);
  check_position(robot.pose(at(0.2, 0.0, half_pi), tool, root), 0.4, 0.0, -0.4);
  check_position(robot.pose(at(0.2, 0.7, 0.3), tool, tool), 0.0, 0.0, 0.0);
}

TEST_CASE("a twist is the change of the pose") {
  const Robot robot(test_limits());
  const double dt = 1e-6;
  for (int i = 0; i < 50; ++i) {
    MeasuredState state = at(0.1 * std::sin(i), 2.0 * std::sin(3.0 * i), 2.0 * std::cos(i));
    state.velocities[torso] = 0.3 * std::cos(2.0 * i);
    state.velocities[arm_1] = std::sin(5.0 * i);
    state.velocities[arm_2] = std::cos(7.0 * i);
    MeasuredState later = state;
    for (std::size_t j = 0; j < measured_count; ++j) later.positions[j] += dt * state.velocities[j];
    const Pose now = robot.pose(state, root, tool);
    const Pose then = robot.pose(later, root, tool);
    const Twist twist = robot.twist(state, root, tool);
    CHECK(((then.position - now.position) / dt - twist.linear).norm() < 1e-5);
    CHECK(std::abs(angle_between(now.rotation, then.rotation) / dt - twist.angular.norm()) < 1e-5);
    const Pose T_root_lower = robot.pose(state, root, lower);
    const Twist turned = robot.twist(state, lower, tool);
    CHECK((T_root_lower.rotation * turned.linear - twist.linear).norm() < 1e-12);
    CHECK((T_root_lower.rotation * turned.angular - twist.angular).norm() < 1e-12);
  }
}

TEST_CASE("a motion turns by half a circle at most, to the last digits, and of no number by none") {
  const Eigen::Matrix3d still = Eigen::Matrix3d::Identity();
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();
  for (const double angle : {1e-12, 1e-6, 0.4, 2.5, 3.141})
    CHECK(angle_between(still, about(axis, angle)) == doctest::Approx(angle).epsilon(1e-9));
  CHECK(angle_between(about(axis, 2.5), about(axis, 2.5)) < 1e-15);
  CHECK(angle_between(still, about(axis, 4.0)) == doctest::Approx(4.0 * half_pi - 4.0));
  CHECK(angle_between(still, about(axis, 2.0 * half_pi)) == doctest::Approx(2.0 * half_pi));
  for (int i = 0; i < 9; ++i) {
    Eigen::Matrix3d bad = about(axis, 0.4);
    bad(i / 3, i % 3) = not_a_number;
    CHECK(std::isnan(angle_between(bad, still)));
    CHECK(std::isnan(angle_between(still, bad)));
  }
}

TEST_CASE("what is measured as no number, or is no link, is nowhere") {
  const Robot robot(test_limits());
  for (const double bad : {not_a_number, infinite}) {
    CHECK(std::isnan(robot.pose(at(0, bad, 0), root, tool).position.norm()));
    CHECK_FALSE(std::isfinite(robot.pose(at(bad, 0, 0), root, tool).position.norm()));
  }
  CHECK(robot.limits.kinematics.find("wrist") == no_link);
  CHECK(robot.limits.kinematics.find("base_link") == root);
  for (const std::size_t bad : {no_link, std::size_t{5}}) {
    CHECK(std::isnan(robot.pose(at(0, 0, 0), root, bad).position.norm()));
    CHECK(std::isnan(robot.pose(at(0, 0, 0), bad, tool).position.norm()));
    CHECK(std::isnan(robot.pose(at(0, 0, 0), bad, tool).rotation.norm()));
    CHECK(std::isnan(robot.twist(at(0, 0, 0), root, bad).linear.norm()));
    CHECK(std::isnan(robot.twist(at(0, 0, 0), bad, tool).angular.norm()));
  }
  // Also where the part's joints slide all that hangs on them, or do not move it at all.
  PartLimits part;
  for (const std::size_t joint : {torso, base_x}) {
    part.joints.clear();
    (void)part.joints.push_back(joint);
    const Twist twist = robot.twist(at(0, not_a_number, 0), root, tool, &part);
    CHECK(twist.linear.array().isNaN().all());
    CHECK(twist.angular.array().isNaN().all());
  }
}

TEST_CASE("a joint slides along its axis as its own frame is turned") {
  const double half = std::sqrt(0.5);
  Link root_link;
  root_link.name = "base_link";
  Link rail = link("rail", 0, LinkMotion::slide, arm_1, {1, 0, 0}, {0.5, 0, 0});
  rail.rotation_xyzw = {0.0, 0.0, half, half};  // a quarter about z
  const Robot robot(tree_of({root_link, rail}));
  check_position(robot.pose(at(0, 0.25, 0), 0, 1), 0.5, 0.25, 0.0);
  Link tilted = rail;
  tilted.rotation_xyzw = {half, 0.0, 0.0, half};  // a quarter about x
  tilted.axis = {0, 1, 0};
  check_position(Robot(tree_of({root_link, tilted})).pose(at(0, 0.25, 0), 0, 1), 0.5, 0.0, 0.25);
}

TEST_CASE("a rotation is told along the axes of its frame, whichever way both are turned") {
  // The column turns about z and the wrist about y: seen from the column, that alone is left.
  MeasuredState state = free_arm::at_rest();
  state.positions[free_arm::turn_z] = 0.7;
  state.positions[free_arm::turn_y] = 0.4;
  const Robot robot(free_arm::limits());
  const auto seen_from = [&](std::size_t frame) {
    return robot.pose(state, frame, free_arm::tool_link).rotation;
  };
  const auto y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  CHECK(angle_between(seen_from(1), about(y, 0.4)) < 1e-7);
  CHECK(angle_between(seen_from(0), about(z, 0.7) * about(y, 0.4)) < 1e-7);
}

TEST_CASE("a twist is turned by every joint between its own and the frame it is told in") {
  MeasuredState state = free_arm::at_rest();
  state.positions[free_arm::turn_z] = half_pi;
  state.velocities[free_arm::turn_y] = 0.5;
  state.velocities[free_arm::slide_x] = 0.25;
  const Twist twist = Robot(free_arm::limits()).twist(state, 0, free_arm::tool_link);
  CHECK((twist.angular - Eigen::Vector3d(-0.5, 0.0, 0.0)).norm() < 1e-12);
  CHECK((twist.linear - Eigen::Vector3d(0.0, 0.25, 0.0)).norm() < 1e-12);
}

TEST_CASE("a pose moves along the root's axes, before its own rotation") {
  const auto x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  Motion6 motion;
  motion << 0.0, 0.5, 0.0, -0.25, 0.0, 0.0;
  const Pose after = moved(Pose{about(y, 0.3), {1.0, 2.0, 3.0}}, motion);
  CHECK((after.position - Eigen::Vector3d(1.0, 2.5, 3.0)).norm() < 1e-12);
  CHECK(angle_between(after.rotation, about(x, -0.25) * about(y, 0.3)) < 1e-12);
}

// A quarter turn about x and then one about z take x to y, y to z and z to x.
TEST_CASE("two motions in one: the second turns what the first has turned") {
  const double quarter = 0.5 * std::numbers::pi;
  Motion6 first, second, both, turn;
  first << 1.0, 2.0, 3.0, quarter, 0.0, 0.0;
  second << 0.5, 0.0, -1.0, 0.0, 0.0, quarter;
  turn.setConstant(2.0 * std::numbers::pi / 3.0 / std::sqrt(3.0));
  both = one_after_other(first, second);
  CHECK(both.head<3>() == Eigen::Vector3d(1.5, 2.0, 2.0));
  CHECK((both - turn).tail<3>().norm() < 1e-9);
  CHECK((one_after_other(second, first) - turn).tail<3>().norm() > 1.0);
  // About one axis the angles add up; exactly, where one of them is none.
  Motion6 more = Motion6::Zero();
  CHECK(one_after_other(first, more) == first);
  CHECK(one_after_other(more, first) == first);
  more << 0.0, 0.0, 0.0, 0.1, 0.7, -0.3;
  Motion6 shift;
  shift << 0.1, 0.2, 0.3, 0.0, 0.0, 0.0;
  CHECK(one_after_other(more, shift) == more + shift);
  CHECK(one_after_other(shift, more) == more + shift);
  more.setZero();
  more[3] = 0.25;
  CHECK(one_after_other(first, more)[3] == doctest::Approx(quarter + 0.25));
}
