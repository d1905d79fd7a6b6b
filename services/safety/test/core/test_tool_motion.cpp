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
