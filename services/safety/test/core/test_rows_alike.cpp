// Rows like the row before: a chunk of them waits, and is judged row by row all the same.

#include <doctest/doctest.h>

#include <cmath>

#include "core/chunk/judgement.hpp"
#include "core/trajectory/prediction.hpp"
#include "free_arm.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

Row six(double first, double last) { return {first, 0, 0, 0, 0, last}; }

}  // namespace

TEST_CASE("G031 a chunk that waits and then goes where it may not: cut at the row that does") {
  Limits limits = free_arm::limits();
  limits.workspace.volumes[0].upper[0] = 0.76;
  const Judgement judged = free_arm::judge(
      limits, one_joint(Mode::joint_position, slide_x, {0, 0, 0, 0, 0.05, 0.05, 0.05, 0.1}).chunk);
  CHECK(judged.row_count == 7);
  CHECK(judged.configurations == 8 + 1);  // one on the way of 50 mm, which leaves 10 mm
  CHECK(judged.evidence.code == 31);
  CHECK(judged.evidence.row == 7);
  CHECK(judged.evidence.value == doctest::Approx(0.8));
}

TEST_CASE("G032 another claim's rows that begin to move are met, however long both have waited") {
  Limits limits = two_arms::limits();
  limits.collision.capsules[0] = {2, {0, 0, 0}, {0, 0, 0}, 0.05};
  limits.collision.capsules[1] = {4, {0, 0, 0}, {0, 0, 0}, 0.05};
  MeasuredState state = two_arms::at_rest();
  state.positions[two_arms::left_1] = -0.6;
  ChunkBuilder own, other;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1, Row(8, -0.6));
  // The tools are 0.33 m apart; by 0.6 rad the right one gets to within 0.04 m of the left one.
  two_arms::command(other, two_arms::right, Mode::joint_position, two_arms::right_1,
                    {0, 0, 0, 0, 0, 0, 0.3, 0.6});
  const Companion companion{{}, &other.chunk, 0, 8};
  const RobotModel model(limits);
  const Judgement judged =
      judge_path(model, whole_robot(limits), state, own.chunk, 0, 8, {}, Companions(&companion, 1));
  CHECK(judged.row_count == 7);
  CHECK(judged.evidence.code == 32);
}

TEST_CASE("G030 rows that lead nowhere count their looks, too") {
  Limits limits = free_arm::limits();
  limits.collision.capsules[0] = {0, {-8, 0, 0.5211}, {8, 0, 0.5211}, 0.01};  // 0.1 mm beyond
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.01};
  limits.joints[slide_x].velocity_limit = 16.0;
  limits.parts[arm].modes.joint_velocity.step_limit[slide_x] = 32.0;
  limits.parts[arm].modes.joint_velocity.gain = {1.0 - 1e-7, 1.0};
  // 0.512 m: its end and 63 places on the way there, in the middle and at both ends of the gain;
  // then half of it. 480 looks so far, and three for each of the others.
  Row speeds;
  for (int row = 0; row < 2; ++row) speeds.push_back(row % 2 == 0 ? 10.24 : -10.24);
  speeds.push_back(-5.12);
  speeds.resize(64, 0.0);
  const Judgement judged =
      free_arm::judge(limits, one_joint(Mode::joint_velocity, slide_x, speeds).chunk);
  CHECK(judged.row_count == 3 + 10);
  CHECK(judged.configurations == 512);
  CHECK(judged.evidence.code == 30);
  CHECK(judged.evidence.row == 13);
  CHECK(judged.evidence.axis == "queries");
}

TEST_CASE("a tool that is commanded to stay keeps its joints, also at the end of one's range") {
  Limits limits = free_arm::limits();
  for (const std::size_t slide : {slide_x, slide_y, slide_z}) limits.joints[slide].bounds.lower = 0;
  const auto chunk = ChunkBuilder().add(arm, Mode::cartesian_delta,
                                        {six(0, 0), six(0, 0), six(0, 0)}, {}, "base_link");
  for (const double turned : {0.3, 0.5, 0.7, 0.9, -0.3, -0.5, -0.7, -0.9}) {
    MeasuredState state = at_rest();
    state.positions[turn_z] = turned;
    state.positions[turn_y] = 0.4;
    state.positions[turn_x] = 0.2;
    CHECK(free_arm::judge(limits, chunk.chunk, state).evidence.ok());
    const auto down =
        ChunkBuilder().add(arm, Mode::cartesian_delta, {{0, 0, -1e-6, 0, 0, 0}}, {}, "base_link");
    CHECK(free_arm::judge(limits, down.chunk, state).evidence.code == 24);
  }
}

TEST_CASE("a tool that is commanded to stay does, also beyond a bound and within its tolerance") {
  Limits limits = free_arm::limits();
  limits.joints[turn_y].bounds = {-3.0, 0.0, 0.01};
  const Row still(6, 0.0);
  const auto chunk =
      ChunkBuilder().add(arm, Mode::cartesian_delta, Rows(16, still), {}, "base_link");
  for (int i = 1; i <= 100; ++i) {
    MeasuredState state = at_rest();
    for (const std::size_t j : {turn_z, slide_x, slide_y, slide_z, turn_x})
      state.positions[j] = 0.3 * std::sin(static_cast<double>(i) * static_cast<double>(j + 1));
    state.positions[turn_y] = 0.0005;
    CAPTURE(i);
    CHECK(free_arm::judge(limits, chunk.chunk, state).evidence.ok());
  }
}

TEST_CASE("G030 between the ends of a gain nothing is looked at any more either") {
  Limits limits = free_arm::limits();
  limits.collision.capsules[0] = {0, {-8, 0, 0.5211}, {8, 0, 0.5211}, 0.01};  // 0.1 mm beyond
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.01};
  limits.joints[slide_x].velocity_limit = 16.0;
  limits.parts[arm].modes.joint_velocity.step_limit[slide_x] = 32.0;
  limits.parts[arm].modes.joint_velocity.gain = {1.0 - 1e-7, 1.0};
  // As above: a row of 192 looks, one of 96, twelve of 3; then 64 for each of three branches, of
  // which the last begins after 452.
  Row speeds{10.24, -5.12};
  speeds.resize(14, 0.0);
  speeds.push_back(10.24);
  const Judgement judged =
      free_arm::judge(limits, one_joint(Mode::joint_velocity, slide_x, speeds).chunk);
  CHECK(judged.configurations == 512);
  CHECK(judged.evidence.code == 30);
  CHECK(judged.evidence.row == 14);
  CHECK(judged.evidence.axis == "queries");
}
