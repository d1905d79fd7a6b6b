// What a base carries, whoever is told what: it drifts from where it is predicted while the base
// moves. The test robot's tool is at (0.7, 0, 0.5); at 1.5 m/s of its base it drifts by 0.1 m and
// capsules come nearer by 0.05 m.

#include <doctest/doctest.h>

#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double eps = 1e-9;

Limits carried(bool keep_out, std::array<double, 3> lower, std::array<double, 3> upper) {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_velocity.gain = {1.0, 1.0};
  limits.base.tool_drift = 0.1;
  limits.base.clearance_drift = 0.05;
  (void)limits.workspace.volumes.push_back({"shelf", keep_out, lower, upper});
  return limits;
}

Limits until(double x) { return carried(false, {-1, -1, 0}, {x, 1, 1}); }

ChunkBuilder driven(const Row& speeds) {
  return ChunkBuilder().joint(base, Mode::joint_velocity, base_x, speeds);
}

Judgement judged(const Limits& limits, const ChunkBuilder& chunk,
                 const MeasuredState& state = state_at_rest()) {
  return judge_rows(limits, whole_robot(limits), state, chunk.chunk, 0, {});
}

MeasuredState moving(double speed) {
  MeasuredState state = state_at_rest();
  state.velocities[base_x] = speed;
  return state;
}

// A ball on the tool, and a post that it is 0.2 m away from.
Limits with_post() {
  Limits limits = carried(false, {-1, -1, 0}, {1, 1, 1});
  limits.collision.capsules[0] = {0, {1.0, 0, 0.5}, {1.0, 0, 0.5}, 0.05};
  limits.collision.capsules[1] = {4, {0, 0, 0}, {0, 0, 0}, 0.05};
  return limits;
}

}  // namespace

TEST_CASE("G031 a base that drives: a tool it carries keeps its drift from the edge") {
  CHECK(judged(until(0.75 + eps), driven({0.75})).evidence.ok());
  const Limits near = until(0.75 - eps);  // evidence points into it
  const Judgement refused = judged(near, driven({0.75}));
  CHECK(refused.evidence.code == 31);
  CHECK(refused.evidence.part == "arm");
  CHECK(refused.evidence.axis == "tool x / shelf");
  CHECK(refused.evidence.value == doctest::Approx(0.7));
  CHECK(refused.evidence.limit == doctest::Approx(0.7));
  CHECK(judged(until(0.8 + eps), driven({1.5})).evidence.ok());
  CHECK(judged(until(0.8 - eps), driven({-1.5})).evidence.code == 31);
  CHECK(judged(carried(false, {0.65 - eps, -1, 0}, {1, 1, 1}), driven({0.75})).evidence.ok());
  CHECK(judged(carried(false, {0.65 + eps, -1, 0}, {1, 1, 1}), driven({0.75})).evidence.code == 31);
  CHECK(judged(until(not_a_number), driven({0.75})).evidence.code == 31);
  Limits unknown = until(0.9);
  unknown.base.tool_drift = not_a_number;
  CHECK(judged(unknown, driven({0.75})).evidence.code == 31);
}

TEST_CASE("G031 what a base carries keeps its drift from what it is to stay out of") {
  const auto shelf = [](double x) { return carried(true, {x, -1, 0}, {2, 1, 1}); };
  CHECK(judged(shelf(0.75 + eps), driven({0.75})).evidence.ok());
  CHECK(judged(shelf(0.75 - eps), driven({0.75})).evidence.code == 31);
  Limits ball = shelf(0.85 + eps);
  ball.collision.capsules[1] = {4, {0, 0, 0}, {0, 0, 0}, 0.1};
  CHECK(judged(ball, driven({0.75})).evidence.ok());
  Limits near = shelf(0.85 - eps);
  near.collision.capsules[1] = ball.collision.capsules[1];
  CHECK(judged(near, driven({0.75})).evidence.code == 31);
}

TEST_CASE("G031 a base that drives: a tool that is outside is no reason to leave it there") {
  CHECK(judged(until(0.65), driven({0.001})).evidence.code == 31);
  CHECK(judged(until(0.65), driven({0.0})).evidence.ok());  // it stands
  CHECK(judged(until(0.7 + eps), driven({0.0, 0.1})).row_count == 1);
  Limits still = until(0.65);
  still.base.tool_drift = 0.0;  // a robot whose arm does not feel its base
  CHECK(judged(still, driven({0.75})).evidence.ok());
}

TEST_CASE("G031 a base that moved when the state was measured counts, whatever is told") {
  for (const double speed : {0.75, -0.75}) {
    CHECK(judged(until(0.75 + eps), driven({0.0}), moving(speed)).evidence.ok());
    CHECK(judged(until(0.75 - eps), driven({0.0}), moving(speed)).evidence.code == 31);
    ChunkBuilder arm_only;
    arm_only.joint(arm, Mode::joint_position, arm_1, {0.0});
    CHECK(judged(until(0.75 + eps), arm_only, moving(speed)).evidence.ok());
    CHECK(judged(until(0.75 - eps), arm_only, moving(speed)).evidence.code == 31);
  }
}

TEST_CASE("G032 a base that drives: capsules it carries keep the clearance and their drift") {
  Limits limits = with_post();  // half the speed: 0.025 m nearer
  limits.collision.clearance = 0.175 - eps;
  CHECK(judged(limits, driven({0.75})).evidence.ok());
  limits.collision.clearance = 0.175 + eps;
  const Judgement refused = judged(limits, driven({0.75}));
  CHECK(refused.evidence.code == 32);
  CHECK(refused.evidence.part == "arm");
  CHECK(judged(limits, driven({0.0})).evidence.ok());
  limits.collision.clearance = 0.3;  // too near already
  CHECK(judged(limits, driven({0.75})).evidence.code == 32);
  CHECK(judged(limits, driven({0.0})).evidence.ok());
}

TEST_CASE(
    "G031 a base that still drives drifts what it carries until all rests, whatever is told") {
  // 0.1 m at 1.5 m/s. The base drives when the tick that runs begins; then it is told 0, and the
  // tool goes from 0.669 m to 0.7 m in the last row.
  MeasuredState state = moving(1.5);
  state.positions[arm_1] = 0.3;
  for (const double told : {1.5, 0.0}) {
    for (const std::size_t rows : {1U, 3U}) {
      CAPTURE(told);
      CAPTURE(rows);
      ChunkBuilder acts = driven({told}), next = driven(Row(rows, 0.0));
      acts.joint(arm, Mode::joint_position, arm_1, {0.3});
      Row targets(rows, 0.3);
      targets.back() = 0.0;
      next.joint(arm, Mode::joint_position, arm_1, targets);
      const RowBefore before{&acts.chunk, 0, false, nullptr};
      const auto judged = [&](double x) {
        const Limits limits = until(x);
        const Judgement found = judge_path(RobotModel(limits), whole_robot(limits), state,
                                           next.chunk, 0, rows, before, {});
        return std::pair(found.row_count, found.evidence.code);
      };
      CHECK(judged(0.8 + eps) == std::pair<std::size_t, std::uint32_t>(rows, 0));
      CHECK(judged(0.8 - eps) == std::pair<std::size_t, std::uint32_t>(rows - 1, 31));
    }
  }
}
