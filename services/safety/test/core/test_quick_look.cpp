// The quick look over joint rows: in order means that the careful look finds nothing, and a row at
// its limit still is. What it cannot know is doubtful.

#include <doctest/doctest.h>

#include <algorithm>

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "core/modes/quick_look.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// The first joints of the robot, and nothing that they move.
Limits robot_of(std::size_t joints) {
  Limits limits = test_limits();
  (void)limits.joints.resize(joints);
  (void)limits.kinematics.links.resize(1);
  limits.collision = CollisionLimits{};
  for (PartLimits& part : limits.parts) part.tool = no_link;
  PartLimits& part = limits.parts[base];
  part.joints.clear();
  for (std::size_t j = 0; j < joints; ++j) (void)part.joints.push_back(j);
  return limits;
}

Certain look(const Limits& limits, const MeasuredState& state, const ActionChunk& chunk,
             std::size_t first = 0, std::size_t end = 64, const RowBefore& before = {}) {
  const ActionPart& action = chunk.parts[0];
  return look_quickly(PathPlan(limits), limits.parts[action.part].modes, state, action, first,
                      std::min<std::size_t>(end, chunk.horizon), before);
}

// Of a robot that is measured where the first row of a joint's targets sends it.
MeasuredState state_at(std::uint8_t joint, double position) {
  MeasuredState state = state_at_rest();
  state.positions[joint] = position;
  return state;
}

// Whether the quick look finds rows of one joint in order, which begin where it is measured.
bool certain(Mode mode, std::uint8_t joint, const Row& values,
             const Limits& limits = test_limits()) {
  const std::uint8_t part = joint >= arm_1 ? arm : base;
  const MeasuredState state =
      mode == Mode::joint_position ? state_at(joint, values[0]) : state_at_rest();
  return look(limits, state, ChunkBuilder().joint(part, mode, joint, values).chunk) !=
         Certain::nothing;
}

}  // namespace

TEST_CASE("quick look: a target at its bounds is certain, one beyond them is not") {
  const auto one = [](double value) { return certain(Mode::joint_position, arm_1, {value}); };
  CHECK(one(2.0));
  CHECK_FALSE(one(2.0 + 1e-9));
  CHECK(one(-2.0));
  CHECK_FALSE(one(-2.0 - 1e-9));
  for (const double value : {not_a_number, infinite, -infinite}) CHECK_FALSE(one(value));
}

TEST_CASE("quick look: a change by a whole step is certain, a larger one is not") {
  const auto two = [](double first, double second) {
    return certain(Mode::joint_position, arm_1, {first, second});
  };
  CHECK(two(0.0, 0.25));
  CHECK_FALSE(two(0.0, 0.25 + 1e-9));
  CHECK(two(0.25, 0.0));
  CHECK_FALSE(two(0.25 + 1e-9, 0.0));
  CHECK_FALSE(two(0.0, not_a_number));
  CHECK_FALSE(two(not_a_number, 0.0));
}

TEST_CASE("quick look: one row at fault makes all of them doubtful, wherever it is") {
  for (std::size_t bad = 0; bad < 4; ++bad)
    for (const double value : {2.05, not_a_number, infinite, -infinite}) {
      Row rows{1.9, 1.9, 1.9, 1.9};
      CHECK(certain(Mode::joint_position, arm_1, rows));
      rows[bad] = value;
      CHECK_FALSE(certain(Mode::joint_position, arm_1, rows));
    }
}

TEST_CASE("quick look: every joint of the row is looked at, of whatever number") {
  for (std::size_t joints = 2; joints <= 12; ++joints) {
    Limits limits = robot_of(joints);
    for (std::size_t j = 0; j < joints; ++j) {
      limits.joints[j].bounded = true;
      limits.joints[j].bounds = {-2.0, 2.0, 0.1};
      limits.parts[base].modes.joint_position.step_limit[j] = 0.25;
    }
    const PathPlan plan(limits);
    const auto finds = [&](const Rows& rows, const MeasuredState& state) {
      ChunkBuilder chunk = ChunkBuilder().add(base, Mode::joint_position, rows);
      for (std::size_t j = 0; j < joints; ++j)
        (void)chunk.chunk.parts[0].active.push_back(static_cast<std::uint8_t>(j));
      return look_quickly(plan, limits.parts[base].modes, state, chunk.chunk.parts[0], 0,
                          rows.size(), RowBefore{});
    };
    const Row rest(joints, 0.0);
    for (std::size_t j = 0; j < joints; ++j) {
      Row row = rest;
      row[j] = 2.0;
      CHECK(finds({row}, state_at(static_cast<std::uint8_t>(j), 2.0)) == Certain::starts);
      row[j] = just_above(2.0);
      CHECK(finds({row}, state_at(static_cast<std::uint8_t>(j), 2.0)) == Certain::nothing);
      row[j] = -2.0;
      CHECK(finds({row}, state_at(static_cast<std::uint8_t>(j), -2.0)) == Certain::starts);
      row[j] = 0.25;
      CHECK(finds({rest, row}, state_at_rest()) == Certain::starts);
      row[j] = just_above(0.25);
      CHECK(finds({rest, row}, state_at_rest()) == Certain::nothing);
    }
  }
}

TEST_CASE("quick look: velocities have the joint's own limits") {
  CHECK_FALSE(certain(Mode::joint_velocity, arm_1, {1.5, 0.9}));  // the step is 0.5
  CHECK(certain(Mode::joint_velocity, arm_1, {1.5, 1.0}));
  CHECK(certain(Mode::joint_velocity, arm_1, {-1.5}));
  CHECK_FALSE(certain(Mode::joint_velocity, arm_1, {-1.5 - 1e-9}));
}

TEST_CASE("quick look: the claim's tighter limit counts") {
  Limits limits = test_limits();
  limits.parts[arm].modes.joint_velocity.claimed_limit = 0.75;
  const auto one = [&limits](double value) {
    return certain(Mode::joint_velocity, arm_1, {value}, limits);
  };
  CHECK(one(0.75));
  CHECK_FALSE(one(0.75 + 1e-9));
}

TEST_CASE("quick look: a joint without bounds may be told any target") {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_position = joint_mode({base_x, base_y, base_yaw}, 0.25);
  CHECK(certain(Mode::joint_position, base_yaw, {900.0, 900.25}, limits));
}

TEST_CASE("quick look: a limit that was never set makes every row doubtful") {
  Limits limits = test_limits();
  limits.joints[arm_1].bounds.upper = not_a_number;
  CHECK_FALSE(certain(Mode::joint_position, arm_1, {0.0}, limits));
  limits = test_limits();
  limits.parts[arm].modes.joint_position.step_limit[arm_1] = not_a_number;
  CHECK_FALSE(certain(Mode::joint_position, arm_1, {0.0}, limits));
}

TEST_CASE("quick look: a joint outside its bounds makes every row of its part doubtful") {
  const ChunkBuilder targets = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, 0.0});
  const ChunkBuilder wheels = ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {0.0, 0.0});
  const auto found = [](const ChunkBuilder& chunk, double position) {
    return look(test_limits(), state_at(arm_2, position), chunk.chunk);
  };
  CHECK(found(targets, 2.0999) == Certain::starts);  // within its tolerance of 0.1
  CHECK(found(targets, 2.1001) == Certain::nothing);
  CHECK(found(wheels, 2.1001) == Certain::in_order);  // another part
}

TEST_CASE("quick look: padding that is not zero is doubtful, and so is every other mode") {
  const Limits limits = test_limits();
  const auto of = [&limits](const ChunkBuilder& chunk) {
    return look(limits, state_at_rest(), chunk.chunk) != Certain::nothing;
  };
  Row row(joint_count, 0.0);
  row[base_x] = 1e-9;
  CHECK_FALSE(of(ChunkBuilder().add(arm, Mode::joint_position, {row}, {arm_1, arm_2})));
  CHECK_FALSE(of(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.0, 0.0})));
  CHECK_FALSE(of(ChunkBuilder().scalar(composite, Mode::composite_mode, {-1.0})));
}

TEST_CASE(
    "quick look: rows before the first live one are not looked at, and none is not in order") {
  const Limits limits = test_limits();
  const ChunkBuilder chunk =
      ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {9.0, 0.0, 0.1, 9.0});
  const auto in_order = [&](std::size_t first, std::size_t end) {
    return look(limits, state_at_rest(), chunk.chunk, first, end) != Certain::nothing;
  };
  CHECK(in_order(1, 3));
  CHECK_FALSE(in_order(0, 3));
  CHECK_FALSE(in_order(1, 4));
  CHECK_FALSE(in_order(1, 1));
  CHECK_FALSE(in_order(3, 3));
}

TEST_CASE("quick look: two targets of a joint without bounds that are no place are no change") {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_position = joint_mode({base_x, base_y, base_yaw}, 0.25);
  CHECK_FALSE(certain(Mode::joint_position, base_yaw, {infinite, infinite}, limits));
}

TEST_CASE("quick look: rows that command every joint of the robot have no padding") {
  Limits limits = test_limits();
  JointModeLimits& mode = limits.parts[base].modes.joint_velocity;
  for (std::size_t j = 0; j < joint_count; ++j) {
    mode.step_limit[j] = 0.5;
    limits.joints[j].velocity_limit = 1.5;
  }
  const auto in_order = [&](double last) {
    Row row(joint_count, 1.5);
    row[joint_count - 1] = last;
    const ChunkBuilder chunk =
        ChunkBuilder().add(base, Mode::joint_velocity, {row, row}, {0, 1, 2, 3, 4, 5});
    return look(limits, state_at_rest(), chunk.chunk) != Certain::nothing;
  };
  CHECK(in_order(-1.5));
  CHECK_FALSE(in_order(just_below(-1.5)));
}

TEST_CASE("quick look: a robot of one joint is looked at number by number") {
  const Limits limits = robot_of(1);
  const ChunkBuilder chunk = ChunkBuilder().add(base, Mode::joint_velocity, {{0.0}}, {base_x});
  CHECK(look(limits, state_at_rest(), chunk.chunk) == Certain::nothing);
}

TEST_CASE("quick look: a robot of two joints is looked at") {
  const Limits limits = robot_of(2);
  const auto in_order = [&limits](double x, double y) {
    const ChunkBuilder chunk =
        ChunkBuilder().add(base, Mode::joint_velocity, {{x, y}}, {base_x, base_y});
    return look(limits, state_at_rest(), chunk.chunk) != Certain::nothing;
  };
  CHECK(in_order(1.5, -1.5));
  CHECK_FALSE(in_order(just_above(1.5), 0.0));
  CHECK_FALSE(in_order(0.0, just_above(1.5)));
}

TEST_CASE(
    "quick look: targets start a step away from the measured joint at most, or are doubtful") {
  const auto found = [](double first, const MeasuredState& state) {
    return look(test_limits(), state,
                ChunkBuilder().joint(arm, Mode::joint_position, arm_2, {first}).chunk);
  };
  CHECK(found(0.25, state_at_rest()) == Certain::starts);
  CHECK(found(just_above(0.25), state_at_rest()) == Certain::nothing);
  CHECK(found(-0.25, state_at_rest()) == Certain::starts);
  CHECK(found(just_below(-0.25), state_at_rest()) == Certain::nothing);
  CHECK(found(0.0, state_at(arm_1, 1.0)) == Certain::starts);  // the row does not command it
}

TEST_CASE("quick look: where rows that are no targets start is never certain") {
  const ChunkBuilder chunk = ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.0});
  CHECK(look(test_limits(), state_at_rest(), chunk.chunk) == Certain::in_order);
}

TEST_CASE("quick look: a target starts from the row that acts before as well") {
  const auto found = [](const ChunkBuilder& acted, std::size_t row) {
    const ChunkBuilder chunk = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.1, 0.1});
    const RowBefore before{&acted.chunk, row};
    return look(test_limits(), state_at_rest(), chunk.chunk, 0, 2, before);
  };
  const auto targets = [](std::uint8_t joint, const Row& values) {
    return ChunkBuilder().joint(arm, Mode::joint_position, joint, values);
  };
  CHECK(found(targets(arm_1, {9.0, 0.0, 9.0}), 1) == Certain::starts);
  CHECK(found(targets(arm_1, {0.35}), 0) == Certain::starts);
  CHECK(found(targets(arm_1, {0.36}), 0) == Certain::in_order);
  CHECK(found(targets(arm_1, {not_a_number}), 0) == Certain::in_order);
  CHECK(found(targets(arm_2, {0.1}), 0) == Certain::in_order);  // another joint
  CHECK(found(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.1}), 0) ==
        Certain::in_order);
  ChunkBuilder other_frame = targets(arm_1, {0.1});
  other_frame.chunk.parts[0].frame_id = "elsewhere";
  CHECK(found(other_frame, 0) == Certain::in_order);
  // A row for another part says nothing.
  CHECK(found(ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {0.5}), 0) ==
        Certain::starts);
}

TEST_CASE("quick look: what the part did last has to be of the same mode") {
  const ChunkBuilder chunk = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0});
  const ChunkBuilder wheels = ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {0.5});
  const auto found = [&](const PartMemory& memory, const ActionChunk* acts) {
    PartMemories memories;
    memories[arm] = memory;
    return look(test_limits(), state_at_rest(), chunk.chunk, 0, 1,
                RowBefore{acts, 0, true, &memories});
  };
  PartMemory same, moves, rested, framed;
  same.note(chunk.chunk.parts[0]);
  moves.note(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.0}).chunk.parts[0]);
  rested.acted_modes = PartMemory::mode_bit(static_cast<std::uint8_t>(Mode::joint_velocity));
  framed.note(chunk.chunk.parts[0]);
  framed.frame_id = "elsewhere";
  for (const ActionChunk* acts : {static_cast<const ActionChunk*>(nullptr), &wheels.chunk}) {
    CHECK(found(PartMemory{}, acts) == Certain::starts);
    CHECK(found(same, acts) == Certain::starts);
    CHECK(found(moves, acts) == Certain::in_order);
    CHECK(found(rested, acts) == Certain::in_order);
    CHECK(found(framed, acts) == Certain::in_order);
    same.acted_modes = PartMemory::mode_bit(static_cast<std::uint8_t>(Mode::joint_position));
    CHECK(found(same, acts) == Certain::starts);
  }
}
