// gripper_binary: open or closed, nothing between.

#include <doctest/doctest.h>

#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

ChunkBuilder binary(const Row& values) {
  return ChunkBuilder().scalar(gripper, Mode::gripper_binary, values);
}

}  // namespace

TEST_CASE("G020 gripper binary: exactly 0 or 1") {
  const auto code = [](double value) { return judge(binary({value}).chunk).evidence.code; };
  for (const double fine : {0.0, 1.0, -0.0}) CHECK(code(fine) == 0);
  for (const double bad : {just_above(0.0), just_below(0.0), just_below(1.0), just_above(1.0), 0.5,
                           -1.0, not_a_number, infinite, -infinite})
    CHECK(code(bad) == 20);
  const Judgement cut = judge(binary({0.0, 1.0, 0.5, 1.0}).chunk);
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.row_count == 2);
  CHECK(cut.evidence.axis == "closed");
  const auto evidence = [](double value) { return judge(binary({value}).chunk).evidence; };
  CHECK(evidence(0.5).limit == 1.0);
  CHECK(evidence(0.5).margin == -0.5);
  CHECK(evidence(0.25).limit == 0.0);
  CHECK(evidence(-0.25).margin == -0.25);
  CHECK(evidence(1.25).limit == 1.0);
  CHECK(evidence(1.25).margin == -0.25);
}

TEST_CASE("a binary gripper switches at any time, from any opening") {
  MeasuredState state = state_at_rest();
  for (const double opening : {0.0, 0.08, 0.095}) {
    state.positions[gripper_joint] = opening;
    state.velocities[gripper_joint] = 0.1;
    CHECK(judge(binary({1.0, 0.0, 1.0, 0.0}).chunk, state).outcome == Outcome::released);
    ChunkBuilder previous = binary({0.0});
    CHECK(code_after(previous, binary({1.0}), state) == 0);
  }
}

TEST_CASE("G025 from openings to open and closed at standstill only") {
  ChunkBuilder opening = ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.04});
  MeasuredState state = state_at_rest();
  CHECK(code_after(opening, binary({1.0}), state) == 0);
  state.velocities[gripper_joint] = 0.05;
  CHECK(code_after(opening, binary({1.0}), state) == 25);
}
