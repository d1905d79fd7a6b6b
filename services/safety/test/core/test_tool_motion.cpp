// The tool's Jacobian by itself: its smallest singular value, and what is clearly more.
#include <doctest/doctest.h>

#include <cmath>

#include "free_arm.hpp"
#include "path/tool_motion.hpp"
#include "path/ways.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

/// Columns along the axes, one after the other, of these lengths.
ToolJacobian along_axes(std::initializer_list<double> lengths) {
  ToolJacobian jacobian;
  for (const double length : lengths) {
    Motion6& column = jacobian.columns[jacobian.count];
    column.setZero();
    column[static_cast<Eigen::Index>(jacobian.count++)] = length;
  }
  return jacobian;
}

}  // namespace

TEST_CASE("G033 the smallest singular value of joints that move along the axes is the shortest") {
  CHECK(smallest_singular_value(along_axes({0.5, 2, 1, 1, 1, 1})) == doctest::Approx(0.5));
  CHECK(smallest_singular_value(along_axes({2, 4, 1, 0.25, 3, 1})) == doctest::Approx(0.25));
  CHECK(smallest_singular_value(along_axes({2, 0.25})) == doctest::Approx(0.25));  // of two
  CHECK(smallest_singular_value(along_axes({8})) == doctest::Approx(8.0));
}

TEST_CASE("G033 joints that move nothing have none, of no number it is none") {
  CHECK(smallest_singular_value(along_axes({0, 0, 0, 0, 0, 0})) == 0.0);
  CHECK(smallest_singular_value(along_axes({0, 0})) == 0.0);
  CHECK_FALSE(smallest_singular_value(along_axes({1, not_a_number})) >= 0.0);
  CHECK_FALSE(is_clearly_regular(along_axes({1, not_a_number, 1, 1, 1, 1}), 0.1));
}

TEST_CASE("G033 what is clearly regular is above the limit, and close to it nothing is clear") {
  const ToolJacobian half = along_axes({0.5, 2, 1, 1, 1, 1});
  CHECK(is_clearly_regular(half, 0.49));
  CHECK_FALSE(is_clearly_regular(half, 0.5));
  CHECK_FALSE(is_clearly_regular(half, 0.51));
  CHECK_FALSE(is_clearly_regular(half, not_a_number));
  CHECK(is_clearly_regular(along_axes({0.5, 2}), 0.49));
  CHECK_FALSE(is_clearly_regular(along_axes({0.5, 2}), 0.5));
}

TEST_CASE("the pose of a link that there is not is none") {
  const Limits limits = free_arm::limits();
  const PathPlan plan(limits);
  FramePoses poses;
  poses.place(plan, Joints{});
  CHECK(link_pose(plan, "nowhere", poses).position.array().isNaN().all());
  CHECK(link_pose(plan, "nowhere", poses).rotation.array().isNaN().all());
  CHECK((link_pose(plan, "tool", poses).position - Eigen::Vector3d(0.7, 0, 0.5)).norm() < 1e-15);
}

TEST_CASE("the share of a way that a margin covers") {
  CHECK(free_share(0.25, 1.0) == 0.25);
  CHECK(free_share(1.0, 1.0) == 1.0);
  CHECK(free_share(2.0, 1.0) == 1.0);
  CHECK(free_share(0.0, 1.0) == 0.0);
  CHECK(free_share(-1.0, 1.0) == 0.0);
  CHECK(free_share(0.0, 0.0) == 1.0);  // nothing moves
  CHECK(free_share(not_a_number, 1.0) == 0.0);
  CHECK(free_share(1.0, not_a_number) == 0.0);
}

TEST_CASE("G033 five columns or fewer are measured by themselves, six and more by their rows") {
  CHECK(smallest_singular_value(along_axes({2, 0.25, 1, 1, 1})) == doctest::Approx(0.25));
  ToolJacobian seven = along_axes({2, 0.25, 1, 1, 1, 1});
  seven.columns[seven.count++] = Motion6::Unit(1);  // makes up for the short one
  CHECK(smallest_singular_value(seven) == doctest::Approx(1.0));
}

TEST_CASE("G033 clearly regular: nearly to the limit, but by more than rounding can close") {
  CHECK(is_clearly_regular(along_axes({0.5, 2, 1, 1, 1, 1}), 0.499999));
  // Beside numbers of 1e6, what is left of 4e-6 may be rounding.
  const ToolJacobian large = along_axes({0.002, 1e3, 1e3, 1e3, 1e3, 1e3});
  CHECK_FALSE(is_clearly_regular(large, 1e-9));
  CHECK(is_clearly_regular(along_axes({0.003, 1e3, 1e3, 1e3, 1e3, 1e3}), 1e-9));
}

namespace {

// Whether the free arm's tool gets as far along x as it is told, within its steps.
Evidence reach_along_x(double distance, Joints& joints) {
  const Limits limits = free_arm::limits();
  const PathPlan plan(limits);
  FramePoses poses;
  poses.place(plan, joints);
  const FramePose target{Eigen::Matrix3d::Identity(), {0.7 + distance, 0.0, 0.5}};
  Joints straight;
  return reach_pose(plan, plan.tools[arm], target, poses, joints, straight);
}

}  // namespace

TEST_CASE("G030 a pose is reached in fifty steps of half a metre or less, or not at all") {
  for (const double way : {1.0, -1.0}) {
    // 48 whole steps, one of 0.4 m, one of what the damping left of that.
    Joints joints{};
    CHECK(reach_along_x(24.4 * way, joints).ok());
    CHECK(joints[free_arm::slide_x] == doctest::Approx(24.4 * way));
    // 49 whole steps and one of 0.1 m, which leaves 40 um.
    joints = Joints{};
    const Evidence fault = reach_along_x(24.6 * way, joints);
    CHECK(fault.code == 30);
    CHECK(fault.axis == "tool position");
    CHECK(fault.value == doctest::Approx(4e-5).epsilon(0.01));
  }
}

TEST_CASE("a pose is reached up to and including a micrometre: nothing moves for less") {
  const Limits limits = free_arm::limits();
  const PathPlan plan(limits);
  const auto moved = [&](double aside) {
    Joints joints{}, straight;
    FramePoses poses;
    poses.place(plan, joints);
    const FramePose target{Eigen::Matrix3d::Identity(), {0.7, aside, 0.5}};
    CHECK(reach_pose(plan, plan.tools[arm], target, poses, joints, straight).ok());
    return joints != Joints{};
  };
  CHECK_FALSE(moved(1e-6));
  CHECK(moved(just_above(1e-6)));
}
