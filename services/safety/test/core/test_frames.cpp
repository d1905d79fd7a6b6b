// Where the model's frames are: by hand, and placed again only when they moved.

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "core/kinematics/forward_kinematics.hpp"
#include "free_arm.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

Joints anywhere(std::mt19937& random) {
  Joints joints{};
  for (std::size_t j = 0; j < 6; ++j)
    joints[j] = std::uniform_real_distribution<>(-1.0, 1.0)(random);
  return joints;
}

}  // namespace

TEST_CASE("frames placed again are where they would be if placed for the first time") {
  const Limits limits = free_arm::limits();
  const RobotModel model(limits);
  std::mt19937 random(5);
  Joints joints{};
  FramePoses kept;
  kept.place(model, joints);
  for (int i = 0; i < 500; ++i) {
    const Joints other = anywhere(random);
    for (std::size_t j = 0; j < 6; ++j)
      if (random() % 3 == 0) joints[j] = other[j];
    if (random() % 2 == 0) kept.place_chain(model, model.tools[arm], other);
    kept.place(model, joints);
    const FramePoses copied = kept;
    FramePoses fresh;
    fresh.place(model, joints);
    for (std::size_t f = 0; f < model.frames.size(); ++f) {
      CHECK(copied[f].position == fresh[f].position);
      CHECK(copied[f].rotation == fresh[f].rotation);
    }
  }
}

TEST_CASE(
    "a rail that is mounted turned slides along its own axis, and what it carries is turned") {
  Limits limits = free_arm::limits();
  Link root;
  root.name = "base_link";
  Link rail = link("rail", 0, LinkMotion::slide, slide_x, {1, 0, 0}, {0.5, 0, 0});
  rail.rotation_xyzw = {0.0, 0.0, std::sqrt(0.5), std::sqrt(0.5)};  // a quarter about z
  limits.kinematics = tree_of(
      {root, rail, link("tip", 1, LinkMotion::fixed, max_measured, {1, 0, 0}, {0, 0.2, 0})});
  limits.parts[arm].tool = 2;
  limits.collision = wide_shape(0, 2);
  const RobotModel model(limits);
  Joints joints{};
  joints[slide_x] = 0.25;
  FramePoses poses;
  poses.place(model, joints);
  const Pose tip = pose_at(model.places[2], poses);
  CHECK((tip.position - Eigen::Vector3d(0.3, 0.25, 0.0)).norm() < 1e-12);
  CHECK((tip.rotation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm() < 1e-12);
}

TEST_CASE("a frame whose joint is where it was is not placed again, whatever became of the model") {
  const Limits limits = free_arm::limits();
  RobotModel model(limits);
  Joints joints{};
  FramePoses poses;
  poses.place(model, joints);
  const FramePoses copied = poses;
  for (ModelFrame& frame : model.frames) frame.origin.x() += 1.0;
  for (FramePoses kept : {poses, copied}) {
    kept.place(model, joints);
    CHECK(kept[tool_link].position.x() == doctest::Approx(0.7));
    joints[turn_x] = 0.1;  // moves the last frame only: placed on its parent
    kept.place(model, joints);
    CHECK(kept[tool_link].position.x() == doctest::Approx(1.7));
    CHECK(kept[tool_link - 1].position.x() == doctest::Approx(0.7));
    joints[turn_x] = 0.0;
  }
}

TEST_CASE("a copy knows what hangs on frames that were placed without it") {
  const Limits limits = two_arms::limits();
  const RobotModel model(limits);
  Joints turned{};
  turned[two_arms::right_1] = 0.5;
  FramePoses poses, copy, fresh;
  poses.place(model, Joints{});
  copy = poses;
  poses.place_chain(model, model.tools[two_arms::right], turned);  // not the fingers
  copy = poses;
  copy.place(model, turned);
  fresh.place(model, turned);
  for (std::size_t f = 0; f < model.frames.size(); ++f)
    CHECK(copy[f].position == fresh[f].position);
}
