// What a part's command moves as far as it is predicted, on the test robot and its base.

#include <doctest/doctest.h>

#include "chunk_builder.hpp"
#include "core/modes/commanded_motion.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

JointSet moved(const Limits& limits, const ChunkBuilder& chunk) {
  const RobotModel model(limits);
  return moved_by(model, chunk.chunk.parts[0]);
}

ChunkBuilder base_joint(Mode mode, std::uint8_t joint) {
  return ChunkBuilder().joint(base, mode, joint, {0.5});
}

}  // namespace

TEST_CASE("joint targets are told in two modes and in no other") {
  for (std::uint8_t mode = 0; mode < mode_count; ++mode) {
    const bool target = mode == static_cast<std::uint8_t>(Mode::joint_position) ||
                        mode == static_cast<std::uint8_t>(Mode::dex_hand_joint);
    CHECK(is_target(static_cast<Mode>(mode)) == target);
  }
}

TEST_CASE("a gripper's command moves nothing that is predicted") {
  const Limits limits = test_limits();
  CHECK(moved(limits, ChunkBuilder().scalar(gripper, Mode::gripper_binary, {1.0})) == 0);
  CHECK(moved(limits, ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.05})) == 0);
}

TEST_CASE("a joint mode moves the joints it commands, a mode of the tool all of the part") {
  const Limits limits = test_limits();
  const JointSet both = only(arm_1) | only(arm_2);
  CHECK(moved(limits, ChunkBuilder().joint(arm, Mode::joint_velocity, arm_2, {0.1})) ==
        only(arm_2));
  CHECK(moved(limits, ChunkBuilder().along(arm, Mode::cartesian_twist, 0, {0.1})) == both);
  CHECK(moved(limits, ChunkBuilder().along(base, Mode::body_twist, 0, {0.1})) ==
        (only(base_x) | only(base_y) | only(base_yaw)));
}

TEST_CASE("a slide's velocity told against the yaw moves both slides, and nothing else does") {
  Limits limits = test_limits();
  const JointSet slides = only(base_x) | only(base_y);
  CHECK(moved(limits, base_joint(Mode::joint_velocity, base_x)) == only(base_x));
  limits.base.against_yaw = true;
  CHECK(moved(limits, base_joint(Mode::joint_velocity, base_x)) == slides);
  CHECK(moved(limits, base_joint(Mode::joint_velocity, base_y)) == slides);
  CHECK(moved(limits, base_joint(Mode::joint_velocity, base_yaw)) == only(base_yaw));
  CHECK(moved(limits, base_joint(Mode::joint_position, base_x)) == only(base_x));
  limits.base.present = false;
  CHECK(moved(limits, base_joint(Mode::joint_velocity, base_x)) == only(base_x));
}
