// How many configurations one judgement asks for: few where all is clear, and never
// without end. The free arm slides along a rod that runs above its tool, at a distance that each
// test says.

#include <doctest/doctest.h>

#include "core/chunk/judgement.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

// A rod along x and a ball at the tool, both of 10 mm: `margin` beyond the clearance of 1 mm.
Limits beside_rod(double margin) {
  Limits limits = free_arm::limits();
  const double z = 0.5 + 0.021 + margin;
  limits.collision.capsules[0] = {0, {-8, 0, z}, {8, 0, z}, 0.01};
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.01};
  return limits;
}

std::size_t configurations(const Limits& limits, Mode mode, const Row& values) {
  const Judgement judged = free_arm::judge(limits, one_joint(mode, slide_x, values).chunk);
  CHECK(judged.evidence.ok());
  return judged.configurations;
}

}  // namespace

TEST_CASE("configurations: one a row where nothing is near, none where nothing could be") {
  CHECK(configurations(free_arm::limits(), Mode::joint_position, {0.07, 0.14, 0.21}) == 3);
  Limits empty = free_arm::limits();
  empty.collision.pairs.clear();
  empty.workspace.volumes.clear();
  CHECK(configurations(empty, Mode::joint_position, {0.07, 0.14, 0.21}) == 0);
}

TEST_CASE("configurations: what is clear at both ends together is clear between them") {
  // 4 mm are less than half of any way above 10 mm: of 70 mm each eighth is looked at.
  CHECK(configurations(beside_rod(0.004), Mode::joint_position, {0.07}) == 8);
  // 20 mm: the end, the middle, and a quarter, because nobody has looked at the start.
  CHECK(configurations(beside_rod(0.02), Mode::joint_position, {0.07}) == 3);
  CHECK(configurations(beside_rod(0.02), Mode::joint_position, {0.07, 0.14}) == 3 + 2);
  // 36 mm at both ends are more than the 70 mm between them.
  CHECK(configurations(beside_rod(0.036), Mode::joint_position, {0.07, 0.14}) == 2 + 1);
}

TEST_CASE("G030 a judgement that has looked 512 times goes no further") {
  Limits limits = beside_rod(0.0001);
  limits.joints[slide_x].velocity_limit = 8.0;
  limits.parts[arm].modes.joint_velocity.step_limit[slide_x] = 16.0;
  Row velocities;
  for (int row = 0; row < 8; ++row) velocities.push_back(row % 2 == 0 ? 8.0 : -8.0);
  // 0.4 m to and fro: the end of each row and 63 places on the way there.
  CHECK(configurations(limits, Mode::joint_velocity, velocities) == 512);
  limits.parts[arm].modes.joint_velocity.gain = {1.0 - 1e-7, 1.0};  // three times as many
  const ChunkBuilder chunk = one_joint(Mode::joint_velocity, slide_x, velocities);
  const Judgement cut = free_arm::judge(limits, chunk.chunk);
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.row_count == 2);
  CHECK(cut.configurations == 512);
  CHECK(cut.evidence.code == 30);
  CHECK(cut.evidence.row == 2);
  CHECK(cut.evidence.axis == "queries");
  CHECK(cut.evidence.value == 512.0);
  CHECK(cut.evidence.limit == 512.0);
}

TEST_CASE("configurations: at a base where each row leads; the way to rest is clear") {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_velocity.gain = {1.0, 1.0};
  limits.collision.pairs.clear();
  limits.workspace.volumes.clear();
  const ClaimLimits claim = whole_robot(limits);
  const auto chunk = ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {0.1, 0.1, 0.1});
  const Judgement judged =
      judge_path(RobotModel(limits), claim, state_at_rest(), chunk.chunk, 0, 3, {}, {});
  CHECK(judged.evidence.ok());
  CHECK(judged.configurations == 3);
}

TEST_CASE("G030 wherever the looks run out, none is taken beyond, and that row is at fault") {
  Limits limits = test_limits();  // with volumes, pairs and zones, and shares between
  limits.parts[base].modes.joint_velocity.gain = {0.5, 1.0};
  limits.base.zones = {};
  Zone wall{"wall", true, {}};  // beside all of its way, so that it is looked at between rows
  for (const Corner& corner : {Corner{-5.0, 0.52}, Corner{5.0, 0.52}, Corner{5.0, 5.0}})
    (void)wall.corners.push_back(corner);
  (void)limits.base.zones.push_back(wall);
  const ClaimLimits claim = whole_robot(limits);
  const RobotModel model(limits);
  const auto chunk = ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {1.0, 1.0});
  const auto judged = [&](std::size_t queries) {
    return judge_path(shared_room(), model, claim, state_at_rest(), chunk.chunk,
                      JudgedRows::all(0, 2, queries), {}, {});
  };
  const Judgement whole = judged(max_queries);
  CHECK(whole.evidence.ok());
  std::size_t rows = 0;
  for (std::size_t queries = 0; queries < whole.configurations; ++queries) {
    CAPTURE(queries);
    const Judgement cut = judged(queries);
    CHECK(cut.configurations == queries);
    CHECK(cut.evidence.code == 30);
    CHECK(cut.evidence.axis == "queries");
    CHECK(cut.evidence.limit == static_cast<double>(queries));
    CHECK(cut.row_count >= rows);
    rows = cut.row_count;
  }
  CHECK(rows == 1);
  CHECK(judged(whole.configurations).evidence.ok());
}
