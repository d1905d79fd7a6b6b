// The tool's Jacobian by itself, and what motions of the tool make of the joints.
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
  Moved(const Limits& limits, const Motion6& motion, std::array<double, 2> slides = {}) {
    const RobotModel model(limits);
    joints[free_arm::slide_x] = slides[0];
    joints[free_arm::slide_y] = slides[1];
    FramePoses start, end;
    start.place(model, joints);
    end.place(model, joints);
    fault = move_tool(model, model.tools[arm], motion, start, end, joints, first_step);
  }
  Joints joints{};
  Joints first_step{};
  Evidence fault;
};

Motion6 along_x(double distance) { return distance * Motion6::Unit(0); }

// Two slides that are parallel but for twice this angle: across, their singular value is the sine
// of it times the root of 2.
Limits nearly_parallel(double half_angle) {
  Limits limits = free_arm::limits();
  limits.parts[arm].joints.clear();
  for (const std::size_t joint : {free_arm::slide_x, free_arm::slide_y})
    (void)limits.parts[arm].joints.push_back(joint);
  auto& links = limits.kinematics.links;
  links[2].axis = {std::cos(half_angle), std::sin(half_angle), 0.0};
  links[3].axis = {std::cos(half_angle), -std::sin(half_angle), 0.0};
  return limits;
}

}  // namespace

TEST_CASE("a motion ends with the step that moves no joint by more than two millimetres") {
  // Steps of a slide leave a 2500th, which the damping of 0.02 takes, but for the last, which is
  // hardly damped.
  const auto missed = [](double told) {
    const Moved moved(free_arm::limits(), along_x(told));
    CHECK(moved.fault.ok());
    CHECK(moved.first_step[free_arm::slide_x] == doctest::Approx(told).epsilon(1e-6));
    return std::abs(told - moved.joints[free_arm::slide_x]);
  };
  CHECK(missed(1.99e-3) <= 1.99e-3 * 1.1e-8);  // one
  CHECK(missed(-1.99e-3) <= 1.99e-3 * 1.1e-8);
  CHECK(missed(3e-3) <= 3e-3 / 2500 * 1.1e-8);           // and one
  CHECK(missed(100.0) <= 100.0 / 2500 / 2500 * 1.1e-8);  // 40 mm are left of the first
}

TEST_CASE("a motion of none moves nothing, not by rounding either") {
  const Moved moved(free_arm::limits(), Motion6::Zero(), {0.1, 0.2});
  CHECK(moved.fault.ok());
  CHECK(moved.joints[free_arm::slide_x] == 0.1);
  CHECK(moved.joints[free_arm::slide_y] == 0.2);
}

TEST_CASE("G030 a motion whose steps have not ended after twelve") {
  // Of the slides each step leaves half, and so on, at a singular value of the damping itself.
  const double half_angle = std::asin(0.02 / std::sqrt(2.0));
  const Limits limits = nearly_parallel(half_angle);
  const auto moved = [&](double aside) { return Moved(limits, aside * Motion6::Unit(1)); };
  const auto aside = [&](const Moved& made) {
    return std::sin(half_angle) * (made.joints[free_arm::slide_x] - made.joints[free_arm::slide_y]);
  };
  // To be within 2 mm of the slides, 57 um of the tool, is the last step's: eleven halve 0.115 m.
  const double most = 2e-3 * 0.02 * std::sqrt(2.0) * 2048;
  const Moved ended = moved(most * 0.999), refused = moved(most * 1.001);
  CHECK(ended.fault.ok());
  CHECK(aside(ended) == doctest::Approx(most * 0.999));
  CHECK(refused.fault.code == 30);
  CHECK(refused.fault.axis == "tool search");
  CHECK(refused.fault.value == 13.0);
  CHECK(refused.fault.limit == 12.0);
  CHECK(aside(refused) == doctest::Approx(most * 1.001 * (1.0 - 1.0 / 4096)));
}

TEST_CASE("a small step is not the last one if the damping took most of it") {
  // A singular value of a tenth of the damping: a step makes a hundredth of the motion.
  const double half_angle = std::asin(0.002 / std::sqrt(2.0));
  const Limits limits = nearly_parallel(half_angle);
  const Moved moved(limits, 5e-6 * Motion6::Unit(1));  // 1.8 mm of each slide, 18 um at first
  CHECK(moved.fault.ok());
  CHECK(moved.joints[free_arm::slide_x] == doctest::Approx(1.77e-3).epsilon(0.01));
  const Moved refused(limits, 2e-4 * Motion6::Unit(1));  // 71 mm, 0.7 at first
  CHECK(refused.fault.code == 30);
}

namespace {

// A tool 0.7 m from an axis that it turns about, and slides along x and y that go with it.
Evidence turned(double by, bool as_pose) {
  Limits limits = free_arm::limits();
  Joints joints{}, first_step;
  FramePoses poses, end;
  limits.parts[arm].joints.clear();
  for (const std::size_t joint : {free_arm::slide_x, free_arm::slide_y, free_arm::turn_z})
    (void)limits.parts[arm].joints.push_back(joint);
  const RobotModel model(limits);
  const ModelTool& tool = model.tools[arm];
  poses.place(model, joints);
  end.place(model, joints);
  const Motion6 motion = by * Motion6::Unit(5);
  const Pose target = moved(pose_at(tool.place, poses), motion);
  const Evidence evidence = as_pose
                                ? reach_pose(model, tool, target, poses, joints, first_step)
                                : move_tool(model, tool, motion, poses, end, joints, first_step);
  CHECK(first_step[free_arm::slide_y] == doctest::Approx(-0.7 * by).epsilon(1e-4));
  CHECK(joints[free_arm::slide_y] == doctest::Approx(-0.7 * std::sin(by)).epsilon(1e-3));
  return evidence;
}

}  // namespace

TEST_CASE("G030 where the joints end is near to where the straight way leads") {
  // The tool stays and turns: slide_x makes 0.7 (1 - cos) m, of which the straight way knows
  // nothing. It knows 0.7 m for each radian of slide_y: 0.2 of that, and 2 mm, are reached at
  for (const bool as_pose : {false, true}) {
    CAPTURE(as_pose);
    for (const double way : {1.0, -1.0}) {
      CHECK(turned(way * 0.41, as_pose).ok());
      const Evidence fault = turned(way * 0.43, as_pose);
      CHECK(fault.code == 30);
      CHECK(fault.unit == "m");
      CHECK(fault.value == doctest::Approx(0.7 * (1.0 - std::cos(0.43))).epsilon(1e-3));
      CHECK(fault.limit == doctest::Approx(0.2 * 0.7 * 0.43 + 0.002).epsilon(1e-3));
    }
  }
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
