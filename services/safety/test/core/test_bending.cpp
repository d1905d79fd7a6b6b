// G030: how far the way of a row may bend. The free arm turns its tool about z by its base joint
// alone, and the slides have to keep it at (0.7, 0): after a turn by r they are at -0.7 (1 - cos r)
// and -0.7 sin r, where a straight step has them at 0 and -0.7 r. A tick is 0.05 s.

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "fairlead_safety/kinematics.hpp"
#include "free_arm.hpp"
#include "path/prediction.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

double bend_of(double turn) { return 0.7 * (1.0 - std::cos(turn)) / 0.05; }

Limits slow(double limit) {
  Limits limits = free_arm::limits();
  limits.joints[slide_x].velocity_limit = limit;
  return limits;
}

ChunkBuilder turns(const Row& angles) {
  return ChunkBuilder().along(arm, Mode::cartesian_delta, 5, angles);
}

ChunkBuilder turned_pose(double angle) {
  return ChunkBuilder().poses(arm,
                              {{0.7, 0, 0.5, 0, 0, std::sin(0.5 * angle), std::cos(0.5 * angle)}});
}

Judgement path_of(const Limits& limits, const ChunkBuilder& chunk, std::size_t first_row = 0,
                  const RowBefore& before = {}) {
  const PathPlan plan(limits);
  return judge_path(plan, whole_robot(limits), at_rest(), chunk.chunk, first_row,
                    chunk.chunk.horizon, before, {});
}

// The smallest velocity limit of which `times` are not below `value`.
double smallest_limit(double value, double times) {
  double limit = value / times;
  while (times * limit < value) limit = just_above(limit);
  while (times * just_below(limit) >= value) limit = just_below(limit);
  return limit;
}

}  // namespace

TEST_CASE("G030 a way bends by three velocity limits a tick at most, from both sides") {
  const auto twist = ChunkBuilder().along(arm, Mode::cartesian_twist, 5, {8.0});
  for (const ChunkBuilder& chunk : {turns({0.4}), turns({-0.4}), twist, turned_pose(0.4)}) {
    const Limits none = slow(1e-3);  // evidence points into it
    const Evidence told = path_of(none, chunk).evidence;
    CHECK(told.code == 30);
    CHECK(told.part == "arm");
    CHECK(told.axis == "slide_x");
    CHECK(told.value == doctest::Approx(bend_of(0.4)).epsilon(2e-3));  // 1.105 m/s
    CHECK(told.limit == 3e-3);
    CHECK(told.margin < 0.0);
    const double limit = smallest_limit(told.value, 3.0);
    CHECK(path_of(slow(just_above(limit)), chunk).evidence.ok());
    CHECK(path_of(slow(limit), chunk).evidence.ok());
    const Judgement refused = path_of(slow(just_below(limit)), chunk);
    CHECK(refused.outcome == Outcome::refused);
    CHECK(refused.evidence.code == 30);
    CHECK(path_of(slow(not_a_number), chunk).evidence.code == 30);
    CHECK(path_of(slow(infinite), chunk).evidence.ok());
  }
}

TEST_CASE("G030 a bend counts by the share of the row that happens") {
  Limits half = slow(0.3);
  CHECK(path_of(half, turns({0.4})).evidence.code == 30);  // 1.105 m/s against 0.9
  half.parts[arm].modes.cartesian_delta.gain = {0.25, 0.5};
  CHECK(path_of(half, turns({0.4})).evidence.ok());  // 0.28 m/s
}

TEST_CASE("G030 later rows may bend half as far, and are cut there") {
  // 0.3 rad bend by 0.625 m/s, and in the second row, along slides that have turned, by 0.597.
  const Limits some = slow(0.3);  // evidence points into it
  const Judgement cut = path_of(some, turns({0.3, 0.3, 0.3}));
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.row_count == 1);
  CHECK(cut.evidence.code == 30);
  CHECK(cut.evidence.row == 1);
  CHECK(cut.evidence.axis == "slide_x");
  CHECK(cut.evidence.value == doctest::Approx(bend_of(0.3) * std::cos(0.3)).epsilon(0.02));
  CHECK(cut.evidence.limit == 1.5 * 0.3);
  CHECK(path_of(slow(0.3), turns({0.0, 0.3})).row_count == 1);
  CHECK(path_of(slow(0.3), turns({0.0, 0.3}), 1).evidence.ok());  // the first of those to act
  const double limit = smallest_limit(cut.evidence.value, 1.5);
  CHECK(path_of(slow(limit), turns({0.3, 0.3})).evidence.ok());
  CHECK(path_of(slow(just_below(limit)), turns({0.3, 0.3})).row_count == 1);
}

TEST_CASE("G030 joints that are told where to be do not bend") {
  const ChunkBuilder target = one_joint(Mode::joint_position, slide_x, {0.2, -0.2});
  CHECK(path_of(slow(1e-3), target).evidence.ok());
}

TEST_CASE("a pose that acted is where its servo goes, however far the way there bends") {
  // 1.105 m/s is more than three times 0.3: as a row it would be refused.
  Limits limits = slow(0.3);
  limits.joints[slide_x].velocity_limit = 1.2;
  const ChunkBuilder acted = turned_pose(0.4), next = one_joint(Mode::joint_position, slide_x, {0});
  const PathPlan plan(limits);
  const ClaimLimits claim = whole_robot(limits);
  const MeasuredState rest = at_rest();
  const RowBefore before{&acted.chunk, 0};
  Prediction prediction(plan, claim, rest, next.chunk, 0, before, {});
  CHECK(prediction.advance().ok());
  CHECK(prediction.branch(0).speed[slide_x] == doctest::Approx(bend_of(0.4)).epsilon(2e-3));
}

TEST_CASE("long turns and ways at once end where they say") {
  // Three rows of 0.3 rad about one axis that is no joint's, and of 0.09 m: 0.9 rad and 0.27 m.
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 1.0, 1.0).normalized();
  const Eigen::Vector3d way(0.06, 0.06, -0.03);
  Row row(6, 0.0);
  for (int i = 0; i < 3; ++i) {
    row[static_cast<std::size_t>(i)] = way[i];
    row[static_cast<std::size_t>(i + 3)] = 0.3 * axis[i];
  }
  const auto chunk =
      ChunkBuilder().add(arm, Mode::cartesian_delta, {row, row, row}, {}, "base_link");
  Limits limits = free_arm::limits();
  for (JointLimits& joint : limits.joints) joint.velocity_limit = 100.0;
  const PathPlan plan(limits);
  const ClaimLimits claim = whole_robot(limits);
  MeasuredState state = at_rest();
  Prediction prediction(plan, claim, state, chunk.chunk, 0, {}, {});
  for (int i = 0; i < 3; ++i) CHECK(prediction.advance().ok());
  for (std::size_t j = 0; j < 6; ++j) state.positions[j] = prediction.branch(0).now[j];
  const Pose tool = link_pose(free_arm::tree(), state, 0, tool_link);
  const Eigen::Vector3d there = Eigen::Vector3d(0.7, 0.0, 0.5) + 3.0 * way;
  CHECK((tool.position - there).norm() < 2e-4);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.9, axis));
  CHECK(angle_between(tool.rotation, turn) < 2e-4);
}
