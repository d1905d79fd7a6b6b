// The tool's Jacobian by itself: its smallest singular value, and what is clearly more.
#include <doctest/doctest.h>

#include <cmath>

#include "core/kinematics/inverse_kinematics.hpp"
#include "core/trajectory/displacement_bound.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

/// Columns along the axes, one after the other, of these lengths.
ToolJacobian along_axes(std::initializer_list<double> lengths) {
  ToolJacobian jacobian;
  jacobian.columns.setZero(6, static_cast<Eigen::Index>(lengths.size()));
  for (Eigen::Index i = 0; const double length : lengths) {
    jacobian.columns(i, i) = length;
    ++i;
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
  CHECK(smallest_singular_value(along_axes({})) == 0.0);
  CHECK_FALSE(is_clearly_regular(along_axes({}), 0.1));
}

TEST_CASE("G033 nothing is clearly regular of which any number is none, or infinite") {
  for (const ToolJacobian& regular : {along_axes({1, 1, 1, 1, 1, 1}), along_axes({1, 1, 1})}) {
    CHECK(is_clearly_regular(regular, 0.1));
    for (Eigen::Index i = 0; i < regular.columns.size(); ++i)
      for (const double bad : {not_a_number, infinite, -infinite}) {
        ToolJacobian jacobian = regular;
        jacobian.columns.reshaped()[i] = bad;
        CHECK_FALSE(is_clearly_regular(jacobian, 0.1));
        CHECK_FALSE(smallest_singular_value(jacobian) >= 0.1);
      }
  }
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

TEST_CASE("the share of a way that a margin covers") {
  CHECK(clear_fraction(0.25, 1.0) == 0.25);
  CHECK(clear_fraction(1.0, 1.0) == 1.0);
  CHECK(clear_fraction(2.0, 1.0) == 1.0);
  CHECK(clear_fraction(0.0, 1.0) == 0.0);
  CHECK(clear_fraction(-1.0, 1.0) == 0.0);
  CHECK(clear_fraction(0.0, 0.0) == 1.0);  // nothing moves
  CHECK(clear_fraction(not_a_number, 1.0) == 0.0);
  CHECK(clear_fraction(1.0, not_a_number) == 0.0);
}

TEST_CASE("G033 five columns or fewer are measured by themselves, six and more by their rows") {
  CHECK(smallest_singular_value(along_axes({2, 0.25, 1, 1, 1})) == doctest::Approx(0.25));
  ToolJacobian seven = along_axes({2, 0.25, 1, 1, 1, 1});
  seven.columns.conservativeResize(6, 7);
  seven.columns.col(6) = Motion6::Unit(1);  // makes up for the short one
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
  const RobotModel model(limits);
  FramePoses poses;
  poses.place(model, joints);
  const Pose target{Eigen::Matrix3d::Identity(), {0.7 + distance, 0.0, 0.5}};
  Joints first_step;
  return reach_pose(model, model.tools[arm], target, poses, joints, first_step);
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
  const RobotModel model(limits);
  const auto moved = [&](double aside) {
    Joints joints{}, first_step;
    FramePoses poses;
    poses.place(model, joints);
    const Pose target{Eigen::Matrix3d::Identity(), {0.7, aside, 0.5}};
    CHECK(reach_pose(model, model.tools[arm], target, poses, joints, first_step).ok());
    return joints != Joints{};
  };
  CHECK_FALSE(moved(1e-6));
  CHECK(moved(just_above(1e-6)));
}

namespace {

// What one motion does to the free arm's joints, and what its first step alone does.
struct Moved {
  Moved(const Limits& limits, const Motion6& motion) {
    const RobotModel model(limits);
    FramePoses start, end;
    start.place(model, joints);
    end.place(model, joints);
    CHECK(move_tool(model, model.tools[arm], motion, start, end, joints, first_step).ok());
  }
  Joints joints{};
  Joints first_step{};
};

Motion6 along_x(double distance) { return distance * Motion6::Unit(0); }

}  // namespace

TEST_CASE("a motion ends with the first step that moves no joint by more than two millimetres") {
  Limits limits = free_arm::limits();
  limits.kinematics.links[2].translation[0] = 0.0;  // the tool at x = 0, for the last bit of a way
  const auto last = [&](double told) {
    const Moved moved(limits, along_x(told));
    const double step = moved.first_step[free_arm::slide_x];
    CHECK((step <= 2e-3) == (moved.joints == moved.first_step));
    return step;
  };
  // The damping of 0.02 takes 0.0004 off; somewhere near there a step is 2 mm to the last bit.
  double told = 2e-3 * 1.0004 - 4e-17;
  bool exact = false;
  for (int i = 0; i < 200; ++i, told = just_above(told)) exact |= last(told) == 2e-3;
  CHECK(exact);
  CHECK(last(-1.9e-3) == doctest::Approx(-1.9e-3 / 1.0004));
  CHECK(last(3e-3) == doctest::Approx(3e-3 / 1.0004));
}

TEST_CASE("a motion is made in six steps at most, of which each leaves what the damping takes") {
  // Two slides that are parallel but for 28 mrad: across, their singular value is 0.02, the damping
  // itself, so that each step makes half of what is missing.
  Limits limits = free_arm::limits();
  limits.parts[arm].joints.clear();
  for (const std::size_t joint : {free_arm::slide_x, free_arm::slide_y})
    (void)limits.parts[arm].joints.push_back(joint);
  const double half_angle = std::asin(0.02 / std::sqrt(2.0));
  auto& links = limits.kinematics.links;
  links[2].axis = {std::cos(half_angle), std::sin(half_angle), 0.0};
  links[3].axis = {std::cos(half_angle), -std::sin(half_angle), 0.0};
  const Moved moved(limits, 0.1 * Motion6::Unit(1));
  const double aside =
      std::sin(half_angle) * (moved.joints[free_arm::slide_x] - moved.joints[free_arm::slide_y]);
  CHECK(aside == doctest::Approx(0.1 * (1.0 - 1.0 / 64.0)));
}

TEST_CASE("the first step to a pose is all of the straight way, from where the joints are") {
  for (const double way : {0.25, -3.0}) {  // one step, and several
    const Limits limits = free_arm::limits();
    const RobotModel model(limits);
    Joints joints{}, first_step{};
    joints[free_arm::slide_y] = 0.125;
    FramePoses poses;
    poses.place(model, joints);
    const Pose target{Eigen::Matrix3d::Identity(), {0.7 + way, 0.125, 0.5}};
    CHECK(reach_pose(model, model.tools[arm], target, poses, joints, first_step).ok());
    CHECK(first_step[free_arm::slide_x] == doctest::Approx(way).epsilon(1e-3));
    CHECK(first_step[free_arm::slide_y] == doctest::Approx(0.125).epsilon(1e-2));
  }
}
