// Rows that repeat the row before are not predicted again: which rows those are, and that a chunk
// of them is judged as if each had been.

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>

#include "core/chunk/judge_rows.hpp"
#include "core/trajectory/prediction.hpp"
#include "free_arm.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

// After each row but the last: whether the next repeats it. One letter a row, y or n.
std::string repeats(const Limits& limits, const ActionChunk& chunk, const MeasuredState& state,
                    const Companion* companion = nullptr) {
  const PathPlan plan(limits);
  const ClaimLimits claim = whole_robot(limits);
  Prediction prediction(plan, claim, state, chunk, 0, {},
                        Companions(companion, companion == nullptr ? 0 : 1));
  std::string found;
  for (std::size_t row = 0; row + 1 < chunk.horizon; ++row) {
    CHECK(prediction.advance().ok());
    CHECK(prediction.row() == row);
    found += prediction.next_repeats() ? 'y' : 'n';
  }
  return found;
}

std::string of_speeds(const Row& speeds, Gain gain = {1.0, 1.0}) {
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.joint_velocity.gain = gain;
  return repeats(limits, one_joint(Mode::joint_velocity, slide_x, speeds).chunk, at_rest());
}

Row six(double first, double last) { return {first, 0, 0, 0, 0, last}; }

}  // namespace

TEST_CASE("a row repeats the one before from the third on, where that led nowhere") {
  CHECK(of_speeds({0, 0, 0, 0, 0}) == "nyyy");
  CHECK(of_speeds({0, 0, 0, 0.1, 0, 0, 0}) == "nynnyy");
  CHECK(of_speeds({0.1, 0.1, 0.1, 0.1}) == "nnn");
  CHECK(of_speeds({0.1, 0.1, 0, 0}) == "nny");
  CHECK(of_speeds({0, 0, -0.0, 0}) == "nnn");  // which are other bits
}

TEST_CASE("a row repeats the one before only if all it tells does: the last number, every part") {
  Limits limits = free_arm::limits();
  const auto deltas = [&](const Row& last) {
    const auto chunk = ChunkBuilder().add(arm, Mode::cartesian_delta,
                                          {six(0, 0), six(0, 0), last, last}, {}, "base_link");
    return repeats(limits, chunk.chunk, at_rest());
  };
  CHECK(deltas(six(0, 0)) == "nyy");
  CHECK(deltas(six(0, 0.01)) == "nnn");
  CHECK(deltas(six(0.01, 0)) == "nnn");
  const auto arms = [](const Row& left, const Row& right) {
    ChunkBuilder chunk;
    two_arms::command(chunk, two_arms::left, Mode::joint_position, two_arms::left_1, left);
    two_arms::command(chunk, two_arms::right, Mode::joint_position, two_arms::right_1, right);
    return repeats(two_arms::limits(), chunk.chunk, two_arms::at_rest());
  };
  CHECK(arms({0.1, 0.1, 0.1, 0.1}, {0.2, 0.2, 0.2, 0.2}) == "nyy");
  CHECK(arms({0.1, 0.1, 0.2, 0.2}, {0.2, 0.2, 0.2, 0.2}) == "nnn");
  CHECK(arms({0.1, 0.1, 0.1, 0.1}, {0.2, 0.2, 0.1, 0.1}) == "nnn");
}

TEST_CASE("a row that moves a joint at one end of the gain only leads somewhere") {
  CHECK(of_speeds({0.1, 0.1, 0.1, 0.1}, {0.0, 0.0}) == "nyy");
  CHECK(of_speeds({0.1, 0.1, 0.1, 0.1}, {0.0, 1.0}) == "nnn");
  CHECK(of_speeds({0.1, 0.1, 0.1, 0.1}, {-1.0, 0.0}) == "nnn");
}

TEST_CASE(
    "the first row at rest rounds what shares leave open: the next is another one, by 1e-17") {
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.joint_velocity.gain = {0.25, 1.0};
  const auto from = [&](double start, const Row& speeds) {
    MeasuredState state = at_rest();
    state.positions[slide_x] = start;
    return repeats(limits, one_joint(Mode::joint_velocity, slide_x, speeds).chunk, state);
  };
  CHECK(from(0.0, {0.9, 0.3, 0, 0, 0}) == "nnny");
  CHECK(from(0.0, {-0.9, -0.3, 0, 0, 0}) == "nnny");
  CHECK(from(-0.09, {0.9, 0.3, 0, 0, 0}) == "nnyy");
}

TEST_CASE("a joint that is nowhere has not come back") {
  MeasuredState state = at_rest();
  state.positions[slide_x] = not_a_number;
  const Limits limits = free_arm::limits();
  const PathPlan plan(limits);
  const ClaimLimits claim = whole_robot(limits);
  const ChunkBuilder chunk = one_joint(Mode::joint_velocity, slide_x, {0, 0, 0});
  Prediction prediction(plan, claim, state, chunk.chunk, 0, {}, {});
  for (int row = 0; row < 2; ++row) {
    CHECK(prediction.advance().code == 30);
    CHECK_FALSE(prediction.next_repeats());
  }
}

TEST_CASE("beside other rows: they have to repeat as well, and not to end") {
  ChunkBuilder own, other;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1,
                    {0.1, 0.1, 0.1, 0.1, 0.1, 0.1});
  two_arms::command(other, two_arms::right, Mode::joint_position, two_arms::right_1,
                    {0.3, 0.2, 0.2, 0.2, 0.2, 0.1, 0.1});
  const auto beside = [&](const Companion& companion) {
    return repeats(two_arms::limits(), own.chunk, two_arms::at_rest(), &companion);
  };
  CHECK(beside({}) == "nyyyy");
  CHECK(beside({{}, &other.chunk, 1, 7}) == "nyynn");
  CHECK(beside({{}, &other.chunk, 0, 7}) == "nnyyn");
  CHECK(beside({{}, &other.chunk, 1, 4}) == "nynyy");  // it holds from its fourth row on
  CHECK(beside({{}, &other.chunk, 1, 3}) == "nnyyy");
  CHECK(beside({{}, &other.chunk, 1, 1}) == "nyyyy");
}

TEST_CASE("a row that repeats is counted, and the one after it goes on from there") {
  const Limits limits = free_arm::limits();
  const PathPlan plan(limits);
  const ClaimLimits claim = whole_robot(limits);
  const ChunkBuilder chunk = one_joint(Mode::joint_velocity, slide_x, {0, 0, 0, 1.0});
  const MeasuredState state = at_rest();
  Prediction prediction(plan, claim, state, chunk.chunk, 0, {}, {});
  CHECK(prediction.advance().ok());
  CHECK(prediction.advance().ok());
  prediction.repeat();
  CHECK(prediction.row() == 2);
  CHECK_FALSE(prediction.next_repeats());
  CHECK(prediction.advance().ok());
  CHECK(prediction.row() == 3);
  CHECK(prediction.branch(0).before[slide_x] == 0.0);
  CHECK(prediction.branch(0).now[slide_x] == 0.05);
}

TEST_CASE("G031 a chunk that waits and then goes where it may not: cut at the row that does") {
  Limits limits = free_arm::limits();
  limits.workspace.volumes[0].upper[0] = 0.76;
  const Judgement judged = free_arm::judge(
      limits, one_joint(Mode::joint_position, slide_x, {0, 0, 0, 0, 0.05, 0.05, 0.05, 0.1}).chunk);
  CHECK(judged.row_count == 7);
  CHECK(judged.looks == 8 + 1);  // one on the way of 50 mm, which leaves 10 mm
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
  const PathPlan plan(limits);
  const Judgement judged =
      judge_path(plan, whole_robot(limits), state, own.chunk, 0, 8, {}, Companions(&companion, 1));
  CHECK(judged.row_count == 7);
  CHECK(judged.evidence.code == 32);
}

TEST_CASE("G030 rows that repeat count as many looks as if each had been looked at") {
  Limits limits = free_arm::limits();
  limits.collision.capsules[0] = {0, {-8, 0, 0.5211}, {8, 0, 0.5211}, 0.01};  // 0.1 mm beyond
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.01};
  limits.joints[slide_x].velocity_limit = 16.0;
  limits.parts[arm].modes.joint_velocity.step_limit[slide_x] = 32.0;
  limits.parts[arm].modes.joint_velocity.gain = {0.999, 1.0};
  // 0.512 m: its end and 63 places on the way there, at both ends of the gain; then half and a
  // quarter of it. 4,064 looks so far, and two for each of the others.
  Row speeds;
  for (int row = 0; row < 31; ++row) speeds.push_back(row % 2 == 0 ? 10.24 : -10.24);
  speeds.push_back(-5.12);
  speeds.push_back(-2.56);
  speeds.resize(64, 0.0);
  const Judgement judged =
      free_arm::judge(limits, one_joint(Mode::joint_velocity, slide_x, speeds).chunk);
  CHECK(judged.row_count == 33 + 16);
  CHECK(judged.looks == 4096);
  CHECK(judged.evidence.code == 30);
  CHECK(judged.evidence.row == 49);
  CHECK(judged.evidence.axis == "looks");
}

TEST_CASE("a tool that is told to stay keeps its joints, bit by bit; not in the first row") {
  const Limits limits = free_arm::limits();
  const PathPlan plan(limits);
  const ClaimLimits claim = whole_robot(limits);
  const auto chunk =
      ChunkBuilder().add(arm, Mode::cartesian_delta, {six(0, 0), six(0, 0)}, {}, "base_link");
  std::size_t counts = 0;  // joints that rounding moves the way that they are measured to move
  for (const double turned : {0.3, 0.5, 0.7, 0.9, -0.3, -0.5, -0.7, -0.9}) {
    MeasuredState state = at_rest();
    state.velocities.fill(0.5);
    state.positions[turn_z] = turned;
    state.positions[turn_y] = 0.4;
    state.positions[turn_x] = 0.2;
    Prediction prediction(plan, claim, state, chunk.chunk, 0, {}, {});
    const Branch& branch = prediction.branch(0);
    CHECK(prediction.advance().ok());
    for (std::size_t j = 0; j < state.count; ++j) counts += branch.speed[j] == 0.5 ? 1U : 0U;
    CHECK(prediction.advance().ok());
    CHECK(std::memcmp(branch.now.data(), branch.before.data(), 6 * sizeof(double)) == 0);
    for (std::size_t j = 0; j < state.count; ++j) CHECK(branch.speed[j] == 0.0);
  }
  CHECK(counts > 0);
}
