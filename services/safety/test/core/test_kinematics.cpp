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

void check_position(const Pose& pose, double x, double y, double z) {
  CHECK((pose.position - Eigen::Vector3d(x, y, z)).norm() < 1e-12);
}

}  // namespace

TEST_CASE("the tool of the test robot is where it is drawn") {
  const Kinematics tree = test_tree();
  check_position(link_pose(tree, at(0, 0, 0), root, tool), 0.7, 0.0, 0.5);
  check_position(link_pose(tree, at(0.1, 0, 0), root, tool), 0.7, 0.0, 0.6);
  check_position(link_pose(tree, at(0, half_pi, 0), root, tool), 0.0, 0.7, 0.5);
  check_position(link_pose(tree, at(0, 0, half_pi), root, tool), 0.4, 0.0, 0.2);
  const Pose turned = link_pose(tree, at(0, half_pi, 0), root, tool);
  const Eigen::Quaterniond about_z(Eigen::AngleAxisd(half_pi, Eigen::Vector3d::UnitZ()));
  CHECK(angle_between(turned.rotation, about_z) < 1e-12);
}

TEST_CASE("a pose is told in any frame of the tree") {
  const Kinematics tree = test_tree();
  check_position(link_pose(tree, at(0.2, 0.7, -0.3), lower, tool), 0.3, 0.0, 0.0);
  check_position(link_pose(tree, at(0.2, 0.0, half_pi), tool, root), 0.4, 0.0, -0.4);
  check_position(link_pose(tree, at(0.2, 0.7, 0.3), tool, tool), 0.0, 0.0, 0.0);
}

TEST_CASE("a twist is the change of the pose") {
  const Kinematics tree = test_tree();
  const double dt = 1e-6;
  for (int i = 0; i < 50; ++i) {
    MeasuredState state = at(0.1 * std::sin(i), 2.0 * std::sin(3.0 * i), 2.0 * std::cos(i));
    state.velocities[torso] = 0.3 * std::cos(2.0 * i);
    state.velocities[arm_1] = std::sin(5.0 * i);
    state.velocities[arm_2] = std::cos(7.0 * i);
    MeasuredState later = state;
    for (std::size_t j = 0; j < measured_count; ++j) later.positions[j] += dt * state.velocities[j];
    const Pose now = link_pose(tree, state, root, tool);
    const Pose then = link_pose(tree, later, root, tool);
    const Twist twist = link_twist(tree, state, root, tool);
    CHECK(((then.position - now.position) / dt - twist.linear).norm() < 1e-5);
    CHECK(std::abs(angle_between(now.rotation, then.rotation) / dt - twist.angular.norm()) < 1e-5);
    const Pose T_root_lower = link_pose(tree, state, root, lower);
    const Twist turned = link_twist(tree, state, lower, tool);
    CHECK((T_root_lower.rotation * turned.linear - twist.linear).norm() < 1e-12);
    CHECK((T_root_lower.rotation * turned.angular - twist.angular).norm() < 1e-12);
  }
}

TEST_CASE("the angle between rotations knows no sign of a quaternion, and no number but NaN") {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, 3).normalized()));
  const Eigen::Quaterniond same(-q.w(), -q.x(), -q.y(), -q.z());
  CHECK(angle_between(q, same) < 1e-15);
  CHECK(angle_between(q, Eigen::Quaterniond::Identity()) == doctest::Approx(2.5));
  CHECK(angle_between(Eigen::Quaterniond(0, 1, 0, 0), Eigen::Quaterniond::Identity()) ==
        doctest::Approx(std::acos(-1.0)));
  CHECK(std::isnan(
      angle_between(Eigen::Quaterniond(1, not_a_number, 0, 0), Eigen::Quaterniond::Identity())));
  CHECK(std::isnan(
      angle_between(Eigen::Quaterniond(not_a_number, 0, 0, 0), Eigen::Quaterniond::Identity())));
}

TEST_CASE("what is measured as no number, or is no link, is nowhere") {
  const Kinematics tree = test_tree();
  for (const double bad : {not_a_number, infinite}) {
    CHECK(std::isnan(link_pose(tree, at(0, bad, 0), root, tool).position.norm()));
    CHECK_FALSE(std::isfinite(link_pose(tree, at(bad, 0, 0), root, tool).position.norm()));
  }
  CHECK(tree.find("wrist") == no_link);
  CHECK(tree.find("base_link") == root);
  for (const std::size_t bad : {no_link, std::size_t{5}}) {
    CHECK(std::isnan(link_pose(tree, at(0, 0, 0), root, bad).position.norm()));
    CHECK(std::isnan(link_pose(tree, at(0, 0, 0), bad, tool).position.norm()));
    CHECK(std::isnan(link_pose(tree, at(0, 0, 0), bad, tool).rotation.norm()));
    CHECK(std::isnan(link_twist(tree, at(0, 0, 0), root, bad).linear.norm()));
    CHECK(std::isnan(link_twist(tree, at(0, 0, 0), bad, tool).angular.norm()));
  }
}

TEST_CASE("a joint slides along its axis as its own frame is turned") {
  const double half = std::sqrt(0.5);
  Link root_link;
  root_link.name = "base_link";
  Link rail = link("rail", 0, LinkMotion::slide, arm_1, {1, 0, 0}, {0.5, 0, 0});
  rail.rotation_xyzw = {0.0, 0.0, half, half};  // a quarter about z
  const Kinematics tree = tree_of({root_link, rail});
  check_position(link_pose(tree, at(0, 0.25, 0), 0, 1), 0.5, 0.25, 0.0);
  Link tilted = rail;
  tilted.rotation_xyzw = {half, 0.0, 0.0, half};  // a quarter about x
  tilted.axis = {0, 1, 0};
  check_position(link_pose(tree_of({root_link, tilted}), at(0, 0.25, 0), 0, 1), 0.5, 0.0, 0.25);
}

namespace {

Eigen::Quaterniond about(const Eigen::Vector3d& axis, double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
}

}  // namespace

TEST_CASE("a rotation is told along the axes of its frame, whichever way both are turned") {
  // The column turns about z and the wrist about y: seen from the column, that alone is left.
  MeasuredState state = free_arm::at_rest();
  state.positions[free_arm::turn_z] = 0.7;
  state.positions[free_arm::turn_y] = 0.4;
  const Kinematics tree = free_arm::tree();
  const auto seen_from = [&](std::size_t frame) {
    return link_pose(tree, state, frame, free_arm::tool_link).rotation;
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
  const Twist twist = link_twist(free_arm::tree(), state, 0, free_arm::tool_link);
  CHECK((twist.angular - Eigen::Vector3d(-0.5, 0.0, 0.0)).norm() < 1e-12);
  CHECK((twist.linear - Eigen::Vector3d(0.0, 0.25, 0.0)).norm() < 1e-12);
}

TEST_CASE("a pose moves along the axes that the motion is told in, before its own rotation") {
  const auto x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
             z = Eigen::Vector3d::UnitZ();
  const Pose pose{{1.0, 2.0, 3.0}, about(y, 0.3)};
  const Pose after = moved(pose, about(z, half_pi), Twist{{0.5, 0.0, 0.0}, {0.0, 0.25, 0.0}});
  CHECK((after.position - Eigen::Vector3d(1.0, 2.5, 3.0)).norm() < 1e-12);
  CHECK(angle_between(after.rotation, about(x, -0.25) * about(y, 0.3)) < 1e-7);
}
