// The quick look over joint rows: certain means that the careful look finds nothing, and a row at
// its limit is still certain. What it cannot know is doubtful, never certain.

#include <doctest/doctest.h>

#include <limits>

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "core/quick_look.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double nan_number = std::numeric_limits<double>::quiet_NaN();
constexpr double endless = std::numeric_limits<double>::infinity();

// How many rows of one joint the quick look finds certain.
std::size_t certain(Mode mode, std::uint8_t joint, const Row& values,
                    const MeasuredState& state = state_at_rest(),
                    const Limits& limits = test_limits()) {
  const std::uint8_t part = joint >= arm_1 ? arm : base;
  const ChunkBuilder chunk = ChunkBuilder().joint(part, mode, joint, values);
  return first_doubtful_row(limits, limits.parts[part].modes, state, chunk.chunk.parts[0], 0,
                            values.size());
}

}  // namespace

TEST_CASE("quick look: a target at its bounds is certain, one beyond them is not") {
  const auto one = [](double value) { return certain(Mode::joint_position, arm_1, {value}); };
  CHECK(one(2.0) == 1);
  CHECK(one(2.0 + 1e-9) == 0);
  CHECK(one(-2.0) == 1);
  CHECK(one(-2.0 - 1e-9) == 0);
  for (const double value : {nan_number, endless, -endless}) CHECK(one(value) == 0);
}

TEST_CASE("quick look: a change by a whole step is certain, a larger one is not") {
  const auto two = [](double first, double second) {
    return certain(Mode::joint_position, arm_1, {first, second});
  };
  CHECK(two(0.0, 0.25) == 2);
  CHECK(two(0.0, 0.25 + 1e-9) == 1);
  CHECK(two(0.25, 0.0) == 2);
  CHECK(two(0.25 + 1e-9, 0.0) == 1);
  CHECK(two(0.0, nan_number) == 1);
  CHECK(two(nan_number, 0.0) == 0);
}

TEST_CASE("quick look: rows are certain up to the first doubtful one") {
  CHECK(certain(Mode::joint_position, arm_1, {1.8, 1.9, 2.1, 1.9}) == 2);
  CHECK(certain(Mode::joint_position, arm_1, {1.8, 1.9, 2.0, 1.9}) == 4);
}

TEST_CASE("quick look: velocities and torques have the joint's own limits") {
  CHECK(certain(Mode::joint_velocity, arm_1, {1.5, -0.5}) == 1);  // the step is 0.5
  CHECK(certain(Mode::joint_velocity, arm_1, {1.5, 1.0}) == 2);
  CHECK(certain(Mode::joint_velocity, arm_1, {-1.5}) == 1);
  CHECK(certain(Mode::joint_velocity, arm_1, {-1.5 - 1e-9}) == 0);
  CHECK(certain(Mode::joint_torque, arm_1, {80.0, 70.0}) == 2);
  CHECK(certain(Mode::joint_torque, arm_1, {80.0 + 1e-9}) == 0);
}

TEST_CASE("quick look: the claim's tighter limit counts") {
  Limits limits = test_limits();
  limits.parts[arm].modes.joint_velocity.claimed_limit = 0.75;
  const auto one = [&limits](double value) {
    return certain(Mode::joint_velocity, arm_1, {value}, state_at_rest(), limits);
  };
  CHECK(one(0.75) == 1);
  CHECK(one(0.75 + 1e-9) == 0);
}

TEST_CASE("quick look: a joint without bounds may be told any target") {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_position = joint_mode({base_x, base_y, base_yaw}, 0.25);
  CHECK(certain(Mode::joint_position, base_yaw, {900.0, 900.25}, state_at_rest(), limits) == 2);
}

TEST_CASE("quick look: a limit that was never set makes every row doubtful") {
  Limits limits = test_limits();
  limits.joints[arm_1].bounds.upper = nan_number;
  CHECK(certain(Mode::joint_position, arm_1, {0.0}, state_at_rest(), limits) == 0);
  limits = test_limits();
  limits.parts[arm].modes.joint_position.step_limit[arm_1] = nan_number;
  CHECK(certain(Mode::joint_position, arm_1, {0.0}, state_at_rest(), limits) == 0);
}

TEST_CASE("quick look: a joint outside its bounds makes every row of its part doubtful") {
  MeasuredState state = state_at_rest();
  state.positions[arm_2] = 2.0999;  // within its tolerance of 0.1
  CHECK(certain(Mode::joint_position, arm_1, {0.0, 0.0}, state) == 2);
  state.positions[arm_2] = 2.1001;
  CHECK(certain(Mode::joint_position, arm_1, {0.0, 0.0}, state) == 0);
  CHECK(certain(Mode::joint_velocity, base_x, {0.0, 0.0}, state) == 2);  // another part
}

TEST_CASE("quick look: padding that is not zero is doubtful, and so is every other mode") {
  const Limits limits = test_limits();
  const auto of = [&limits](const ChunkBuilder& chunk) {
    const ActionPart& action = chunk.chunk.parts[0];
    return first_doubtful_row(limits, limits.parts[action.part].modes, state_at_rest(), action, 0,
                              chunk.chunk.horizon);
  };
  Row row(joint_count, 0.0);
  row[base_x] = 1e-9;
  CHECK(of(ChunkBuilder().add(arm, Mode::joint_position, {row}, {arm_1, arm_2})) == 0);
  CHECK(of(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.0, 0.0})) == 0);
  CHECK(of(ChunkBuilder().scalar(composite, Mode::composite_mode, {-1.0})) == 0);
}

TEST_CASE("quick look: rows before the first live one are not looked at") {
  const Limits limits = test_limits();
  const ChunkBuilder chunk =
      ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {9.0, 0.0, 0.1, 9.0});
  CHECK(first_doubtful_row(limits, limits.parts[arm].modes, state_at_rest(), chunk.chunk.parts[0],
                           1, 4) == 3);
}
