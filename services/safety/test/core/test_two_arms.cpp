// A robot with two arms: each is judged by its own tool, joints and limits, and a chunk for both
// is released or refused as one.

#include <doctest/doctest.h>

#include "boundary.hpp"
#include "core/chunk/judgement.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::two_arms;

namespace {

const Limits& robot() {
  static const Limits limits = two_arms::limits();
  return limits;
}

Evidence shape(const ChunkBuilder& builder) {
  return check_shape(robot(), whole_robot(robot()), builder.chunk);
}

Judgement judged(const ChunkBuilder& builder, const MeasuredState& state = at_rest()) {
  CHECK(shape(builder).ok());
  return judge_rows(robot(), whole_robot(robot()), state, builder.chunk, 0, {});
}

Row pose(double y) { return {0.5, y, 0.0, 0.0, 0.0, 0.0, 1.0}; }

}  // namespace

TEST_CASE("the two-armed robot's configuration has no fault") {
  CHECK(check_limits(robot()).empty());
}

TEST_CASE("each arm's pose starts from its own tool") {
  CHECK(judged(ChunkBuilder().poses(left, {pose(0.3)})).evidence.code == 0);
  CHECK(judged(ChunkBuilder().poses(left, {pose(-0.3)})).evidence.code == 21);
  CHECK(judged(ChunkBuilder().poses(right, {pose(-0.3)})).evidence.code == 0);
  CHECK(judged(ChunkBuilder().poses(right, {pose(0.3)})).evidence.code == 21);
  MeasuredState state = at_rest();
  state.positions[left_1] = 1.0;  // the left arm has moved; the right one has not
  CHECK(judged(ChunkBuilder().poses(left, {pose(0.3)}), state).evidence.code == 21);
  CHECK(judged(ChunkBuilder().poses(right, {pose(-0.3)}), state).evidence.code == 0);
}

TEST_CASE("each arm's twist starts from its own tool's velocity") {
  MeasuredState state = at_rest();
  state.velocities[right_1] = 2.0;  // 1 m/s at the right tool, beyond any step from rest
  const auto still = [&state](std::uint8_t part) {
    return judged(ChunkBuilder().along(part, Mode::cartesian_twist, 0, {0.0}), state).evidence.code;
  };
  CHECK(still(left) == 0);
  CHECK(still(right) == 21);
}

TEST_CASE("G009 a chunk for one arm names no joint of the other") {
  ChunkBuilder own;
  CHECK(shape(command(own, left, Mode::joint_position, left_1, {0.0})).ok());
  ChunkBuilder foreign;
  CHECK(shape(command(foreign, left, Mode::joint_position, right_1, {0.0})).code == 9);
  ChunkBuilder finger;
  CHECK(shape(command(finger, hand, Mode::dex_hand_joint, right_1, {0.0})).code == 9);
  // Nor may it hide a number in the other arm's column.
  Row row(two_arms::joint_count, 0.0);
  row[right_1] = 0.1;
  const Evidence hidden = shape(ChunkBuilder().add(left, Mode::joint_position, {row}, {left_1}));
  CHECK(hidden.code == 9);
  CHECK(hidden.axis == "right_1");
}

TEST_CASE("both arms in one chunk: all or nothing, row by row") {
  const auto both = [](const Rows& left_rows, const Rows& right_rows) {
    return judged(ChunkBuilder().poses(left, left_rows).poses(right, right_rows));
  };
  CHECK(both({pose(0.3), pose(0.3)}, {pose(-0.3), pose(-0.3)}).outcome == Outcome::released);
  const Judgement cut = both({pose(0.3), pose(0.3)}, {pose(-0.3), pose(-0.4)});
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.row_count == 1);
  CHECK(cut.evidence.part == "right_arm");
  const Judgement refused = both({pose(0.3), pose(0.3)}, {pose(0.0), pose(-0.3)});
  CHECK(refused.outcome == Outcome::refused);
  CHECK(refused.evidence.part == "right_arm");
}

TEST_CASE("G011 an arm outside its bounds blocks its own chunks, not the other arm's") {
  MeasuredState state = at_rest();
  state.positions[right_1] = 2.2;
  CHECK(judged(ChunkBuilder().poses(left, {pose(0.3)}), state).evidence.code == 0);
  CHECK(judged(ChunkBuilder().poses(right, {pose(-0.3)}), state).evidence.code == 11);
}

TEST_CASE("a tool of the other arm, or of none, is a fault of the configuration") {
  Limits limits = two_arms::limits();
  limits.parts[left].tool = 4;
  CHECK(check_limits(limits).view() ==
        "parts.left_arm.modes.cartesian_pose: tool_frame right_tool does not move with the part");
  limits.parts[left].tool = no_link;
  CHECK(check_limits(limits).view() ==
        "parts.left_arm.modes.cartesian_pose: the part has no tool_frame");
  limits.parts[left].tool = 7;
  CHECK(check_limits(limits).view() == "parts.left_arm.tool_frame: no such link");
}

// --- the hand: 0.125 rad a step, bounds of 2 rad and 0.1 rad of tolerance ---

TEST_CASE("G020 dex hand joint: inside the joint's bounds, ends included") {
  MeasuredState state = at_rest();
  const auto code = [&state](double target) {
    ChunkBuilder chunk;
    return judged(command(chunk, hand, Mode::dex_hand_joint, finger_1, {target}), state)
        .evidence.code;
  };
  state.positions[finger_1] = 1.95;
  for (const double fine : {just_below(2.0), 2.0, 1.9}) CHECK(code(fine) == 0);
  CHECK(code(just_above(2.0)) == 20);
  for (const double bad : {not_a_number, infinite, -infinite}) {
    ChunkBuilder chunk;
    command(chunk, hand, Mode::dex_hand_joint, finger_1, {bad});
    CHECK(judge_rows(robot(), whole_robot(robot()), state, chunk.chunk, 0, {}).evidence.code == 20);
  }
  state.positions[finger_1] = -1.95;
  CHECK(code(-2.0) == 0);
  CHECK(code(just_below(-2.0)) == 20);
}

TEST_CASE("G021 dex hand joint: within a step of what is measured and of what was executed") {
  const auto start = [](double target, const RowBefore& before = {}) {
    ChunkBuilder chunk;
    command(chunk, hand, Mode::dex_hand_joint, finger_1, {target});
    return judge_rows(robot(), whole_robot(robot()), at_rest(), chunk.chunk, 0, before)
        .evidence.code;
  };
  CHECK(start(0.225) == 0);  // step 0.125 + tolerance 0.1
  CHECK(start(just_above(0.225)) == 21);
  CHECK(start(just_below(-0.225)) == 21);
  ChunkBuilder previous;
  command(previous, hand, Mode::dex_hand_joint, finger_1, {0.0});
  CHECK(start(0.125, RowBefore{&previous.chunk, 0}) == 0);
  CHECK(start(just_above(0.125), RowBefore{&previous.chunk, 0}) == 21);
}

TEST_CASE("G022 dex hand joint: the jump from row to row") {
  const auto code = [](const Row& targets) {
    ChunkBuilder chunk;
    return judged(command(chunk, hand, Mode::dex_hand_joint, finger_2, targets)).evidence.code;
  };
  CHECK(code({0.0, 0.125, 0.25}) == 0);
  CHECK(code({0.0, 0.125, just_above(0.25)}) == 22);
}

TEST_CASE("G011 dex hand joint: a finger outside its bounds may only come back") {
  MeasuredState state = at_rest();
  state.positions[finger_1] = 2.2;
  const auto code = [&state](std::uint8_t joint, const Row& targets) {
    ChunkBuilder chunk;
    return judged(command(chunk, hand, Mode::dex_hand_joint, joint, targets), state).evidence.code;
  };
  CHECK(code(finger_1, {2.15, 2.1}) == 0);
  CHECK(code(finger_1, {2.2}) == 11);
  CHECK(code(finger_1, {2.15, 2.18}) == 11);
  CHECK(code(finger_2, {0.0}) == 11);
}
