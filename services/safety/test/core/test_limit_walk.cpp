// Which rows are judged with care after the quick look: of a chunk that it is certain of, none.

#include <doctest/doctest.h>

#include "chunk_builder.hpp"
#include "core/modes/row_limit_check.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// For each row of a chunk whether it is judged with care.
std::vector<bool> with_care(const ChunkBuilder& chunk, std::size_t first_row = 0) {
  const Limits limits = test_limits();
  const PathPlan plan(limits);
  const ClaimLimits claim = whole_robot(limits);
  const MeasuredState state = state_at_rest();
  const RowBefore before;
  const RowLimitCheck walk(plan, claim, state, chunk.chunk, first_row, before);
  std::vector<bool> found;
  for (std::size_t row = first_row; row < chunk.chunk.horizon; ++row)
    found.push_back(walk.needs_check(row));
  return found;
}

using Care = std::vector<bool>;

}  // namespace

TEST_CASE("limit walk: of targets in order no row is judged with care") {
  const auto targets = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, 0.1, 0.2});
  CHECK(with_care(targets) == Care{false, false, false});
  CHECK(with_care(targets, 1) == Care{false, false});
}

TEST_CASE("limit walk: of velocities in order the first row alone is") {
  const auto speeds = ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.0, 0.1, 0.2});
  CHECK(with_care(speeds) == Care{true, false, false});
  CHECK(with_care(speeds, 1) == Care{true, false});
}

TEST_CASE("limit walk: one fault, and every row of every part is") {
  const auto fault = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, 0.1, 2.1});
  CHECK(with_care(fault) == Care{true, true, true});
  ChunkBuilder parts = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, 0.1});
  parts.joint(base, Mode::joint_velocity, base_x, {0.0, 0.1});
  CHECK(with_care(parts) == Care{true, false});
  ChunkBuilder others = ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, 0.1});
  others.scalar(gripper, Mode::gripper_position, {0.04, 0.04});
  CHECK(with_care(others) == Care{true, true});
}
