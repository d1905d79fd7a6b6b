// G030: rows that lead to no configuration that could be predicted, and the prediction itself.

#include <doctest/doctest.h>

#include <cmath>

#include "core/kinematics/forward_kinematics.hpp"
#include "core/trajectory/prediction.hpp"
#include "free_arm.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

// Where the rows of a chunk take the free arm, by the upper end of the gain.
Joints after(const Limits& limits, const ActionChunk& chunk, MeasuredState state = at_rest(),
             const RowBefore& before = {}) {
  const RobotModel model(limits);
  const ClaimLimits claim = whole_robot(limits);
  Prediction prediction(model, claim, state, chunk, 0, before, {});
  for (std::size_t row = 0; row < chunk.horizon; ++row) CHECK(prediction.advance().ok());
  return prediction.branch(prediction.branch_count() - 1).now;
}

Limits half_gain() {
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.joint_velocity.gain = {0.25, 0.5};
  limits.parts[arm].modes.cartesian_delta.gain = {0.25, 0.5};
  limits.parts[arm].modes.cartesian_twist.gain = {0.25, 0.5};
  return limits;
}

}  // namespace

TEST_CASE("G030 a pose that no configuration reaches is refused, the numbers told") {
  Limits limits = free_arm::limits();
  limits.parts[arm].joints.erase_at(1);  // without its slide along x
  limits.joints[slide_x].part = 9;
  const ChunkBuilder chunk = ChunkBuilder().poses(arm, {{0.74, 0, 0.5, 0, 0, 0, 1}});
  const Judgement refused = free_arm::judge(limits, chunk.chunk);
  CHECK(refused.outcome == Outcome::refused);
  CHECK(refused.evidence.code == 30);
  CHECK(refused.evidence.part == "arm");
  CHECK(refused.evidence.axis == "tool position");
  CHECK(refused.evidence.value == doctest::Approx(0.04).epsilon(0.1));
  CHECK(refused.evidence.limit == 1e-6);
  CHECK(refused.evidence.unit == "m");
  limits = free_arm::limits();
  limits.parts[arm].joints.erase_at(5);  // without its turn about x
  const Row turned{0.7, 0, 0.5, std::sin(0.1), 0, 0, std::cos(0.1)};
  const Judgement rotation = free_arm::judge(limits, ChunkBuilder().poses(arm, {turned}).chunk);
  CHECK(rotation.evidence.code == 30);
  CHECK(rotation.evidence.axis == "tool rotation");
  CHECK(rotation.evidence.unit == "rad");
}

TEST_CASE("a pose is reached, and held") {
  const Row pose{0.72, 0.01, 0.48, 0.0, std::sin(0.1), 0.0, std::cos(0.1)};
  const ChunkBuilder chunk = ChunkBuilder().poses(arm, {pose, pose});
  Limits fast = free_arm::limits();
  fast.joints[turn_y].velocity_limit = vast;
  const Joints joints = after(fast, chunk.chunk);
  const RobotModel model(fast);
  const Pose tool = link_pose(model, {model, joints}, 0, tool_link);
  CHECK((tool.position - Eigen::Vector3d(0.72, 0.01, 0.48)).norm() < 1.1e-6);
  const Eigen::AngleAxisd turned(0.2, Eigen::Vector3d::UnitY());
  CHECK((tool.rotation - turned.toRotationMatrix()).norm() < 1.6e-6);  // by 1.1e-6 rad at most
}

TEST_CASE("velocities and deltas happen by the share that the gain says") {
  const ChunkBuilder velocity = one_joint(Mode::joint_velocity, slide_y, {1.0, 1.0, -0.5});
  CHECK(after(half_gain(), velocity.chunk)[slide_y] == doctest::Approx(0.0375));
  CHECK(after(free_arm::limits(), velocity.chunk)[slide_y] == doctest::Approx(0.075));
  const auto delta = ChunkBuilder().along(arm, Mode::cartesian_delta, 2, {0.04, 0.04});
  CHECK(after(half_gain(), delta.chunk)[slide_z] == doctest::Approx(0.04).epsilon(1e-3));
  const auto twist = ChunkBuilder().along(arm, Mode::cartesian_twist, 4, {0.8});
  CHECK(after(half_gain(), twist.chunk)[turn_y] == doctest::Approx(0.02).epsilon(1e-3));
  MeasuredState state = at_rest();
  state.positions[turn_z] = std::acos(0.0);  // along the base's x, not the arm's
  const Joints turned = after(
      free_arm::limits(), ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.04}).chunk, state);
  CHECK(turned[slide_y] + 0.7 * (turned[turn_z] - std::acos(0.0)) ==
        doctest::Approx(-0.04).epsilon(1e-2));
}

TEST_CASE("what nothing commands stays") {
  MeasuredState state = at_rest();
  state.positions[slide_x] = 0.3;
  state.positions[slide_y] = 0.1;
  const ChunkBuilder target = one_joint(Mode::joint_position, slide_x, {0.3, 0.3});
  const Joints joints = after(free_arm::limits(), target.chunk, state);
  CHECK(joints[slide_x] == 0.3);
  CHECK(joints[slide_y] == 0.1);
}

TEST_CASE("G030 a gain that is no number predicts nothing") {
  for (const Gain bad : {Gain{unset, 1.0}, Gain{0.0, unset}, Gain{}, Gain{0.0, infinite}}) {
    Limits limits = free_arm::limits();
    limits.parts[arm].modes.joint_velocity.gain = bad;
    limits.parts[arm].modes.cartesian_delta.gain = bad;
    const auto velocity = one_joint(Mode::joint_velocity, slide_x, {0.1});
    CHECK(free_arm::judge(limits, velocity.chunk).evidence.code == 30);
    const auto delta = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.01});
    CHECK(free_arm::judge(limits, delta.chunk).evidence.code == 30);
  }
}

TEST_CASE("what other claims have released moves as well, until their rows end") {
  Limits limits = two_arms::limits();
  // The tools are 0.6 m apart, with a ball of 0.1 m on each.
  limits.collision.capsules[0] = {2, {0, 0, 0}, {0, 0, 0}, 0.1};
  limits.collision.capsules[1] = {4, {0, 0, 0}, {0, 0, 0}, 0.1};
  limits.collision.clearance = 0.15;
  limits.workspace = wide_workspace();
  const RobotModel model(limits);
  const ClaimLimits claim = whole_robot(limits);
  ChunkBuilder right_in, left_in;
  two_arms::command(right_in, two_arms::right, Mode::joint_position, two_arms::right_1,
                    {0.2, 0.25, 0.25, 0.25});
  two_arms::command(left_in, two_arms::left, Mode::joint_position, two_arms::left_1,
                    {0.0, -0.1, -0.2, -0.25});
  const auto rows = [&](const Companion& companion) {
    return judge_path(model, claim, two_arms::at_rest(), left_in.chunk, 0, 4, {},
                      Companions(&companion, 1))
        .row_count;
  };
  // 0.6 - 0.5 (sin 0.25 + sin 0.25) = 0.353 and 0.6 - 0.5 (sin 0.25 + sin 0.2) = 0.377 apart, less
  // the balls: 0.153 and 0.177.
  CHECK(rows(Companion{}) == 4);
  CHECK(rows(Companion{{}, &right_in.chunk, 0, 4}) == 4);
  limits.collision.clearance = 0.16;
  const RobotModel tighter(limits);
  const auto tighter_rows = [&](const Companion& companion) {
    return judge_path(tighter, claim, two_arms::at_rest(), left_in.chunk, 0, 4, {},
                      Companions(&companion, 1));
  };
  CHECK(tighter_rows(Companion{}).row_count == 4);
  const Judgement cut = tighter_rows(Companion{{}, &right_in.chunk, 0, 4});
  CHECK(cut.row_count == 3);
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.evidence.code == 32);
  CHECK(cut.evidence.part == "left_arm");
  CHECK(tighter_rows(Companion{{}, &right_in.chunk, 0, 1}).row_count == 4);  // it holds at 0.2
  // Realtime: the companion's row of the tick before has not been measured yet.
  RowBefore acts{&right_in.chunk, 1};
  acts.measured = false;
  const Companion late{acts, nullptr, 0, 0};
  RowBefore own;
  own.measured = false;
  CHECK(judge_path(tighter, claim, two_arms::at_rest(), left_in.chunk, 0, 4, own,
                   Companions(&late, 1))
            .row_count == 3);
}

namespace {

// The tools are 0.6 m apart across, each moved by its arm's turn; a ball of 0.1 m on each.
Limits two_balls(double clearance, double gain_lower) {
  Limits limits = two_arms::limits();
  limits.collision.capsules[0] = {2, {0, 0, 0}, {0, 0, 0}, 0.1};
  limits.collision.capsules[1] = {4, {0, 0, 0}, {0, 0, 0}, 0.1};
  limits.collision.clearance = clearance;
  for (const std::uint8_t part : {two_arms::left, two_arms::right}) {
    const std::size_t joint = part == two_arms::left ? two_arms::left_1 : two_arms::right_1;
    limits.parts[part].modes.joint_velocity = joint_mode({joint}, 4.0);
    limits.parts[part].modes.joint_velocity.gain = {gain_lower, 1.0};
  }
  return limits;
}

Row speeds(double left, double right) { return {left, right, 0.0, 0.0}; }

}  // namespace

TEST_CASE("one arm behind the other, told the same: they may differ in the share that happens") {
  // At 2 rad/s a row is 0.1 rad: both turn the same way and keep their 0.6 m, by equal shares. If
  // only the right one turns towards the left, 0.6 - 0.5 sin 0.1 is 0.550 m: 0.350 without balls.
  ChunkBuilder same;
  same.add(two_arms::left, Mode::joint_velocity, {speeds(2, 0)}, {two_arms::left_1});
  same.add(two_arms::right, Mode::joint_velocity, {speeds(0, 2)}, {two_arms::right_1});
  const auto code = [&](const Limits& limits) {
    const RobotModel model(limits);
    return judge_path(model, whole_robot(limits), two_arms::at_rest(), same.chunk, 0, 1, {}, {})
        .evidence.code;
  };
  CHECK(code(two_balls(0.34, 0.0)) == 0);
  CHECK(code(two_balls(0.36, 0.0)) == 32);
  CHECK(code(two_balls(0.36, 1.0)) == 0);  // all of it happens, for certain
  CHECK(code(two_balls(0.374, 0.5)) == 0);
  CHECK(code(two_balls(0.376, 0.5)) == 32);
}

TEST_CASE("what another claim has released may not happen: then its parts are in the way") {
  // Both are told to turn left by 0.1 rad; the left arm may be stopped where it is.
  const Limits limits = two_balls(0.36, 1.0);
  const RobotModel model(limits);
  ChunkBuilder own, other;
  own.add(two_arms::right, Mode::joint_velocity, {speeds(0, 2)}, {two_arms::right_1});
  other.add(two_arms::left, Mode::joint_velocity, {speeds(2, 0)}, {two_arms::left_1});
  const auto code = [&](const Companion& companion) {
    return judge_path(model, whole_robot(limits), two_arms::at_rest(), own.chunk, 0, 1, {},
                      Companions(&companion, 1))
        .evidence.code;
  };
  CHECK(code(Companion{{}, &other.chunk, 0, 1}) == 32);
  ChunkBuilder both = own;
  both.add(two_arms::left, Mode::joint_velocity, {speeds(2, 0)}, {two_arms::left_1});
  CHECK(judge_path(model, whole_robot(limits), two_arms::at_rest(), both.chunk, 0, 1, {}, {})
            .evidence.ok());
}

TEST_CASE("another claim's pose that nothing reaches keeps its other arm from no motion") {
  const Limits limits = two_balls(0.01, 1.0);
  const RobotModel model(limits);
  const ClaimLimits claim = whole_robot(limits);
  ChunkBuilder own, other;
  two_arms::command(own, two_arms::hand, Mode::dex_hand_joint, two_arms::finger_1, {0.0});
  other.poses(two_arms::left, {{3.0, 0.3, 0.0, 0.0, 0.0, 0.0, 1.0}});
  // The right arm's tool, 0.5 m from its joint, is turned by 0.2 rad.
  other.poses(two_arms::right, {{0.5 * std::cos(0.2), -0.3 + 0.5 * std::sin(0.2), 0.0, 0.0, 0.0,
                                 std::sin(0.1), std::cos(0.1)}});
  const Companion companion{{}, &other.chunk, 0, 1};
  const MeasuredState state = two_arms::at_rest();
  Prediction prediction(model, claim, state, own.chunk, 0, {}, Companions(&companion, 1));
  CHECK(prediction.advance().ok());
  CHECK(prediction.branch(0).now[two_arms::right_1] == doctest::Approx(0.2).epsilon(1e-5));
}

TEST_CASE("G030 more than three parts with a gain at once are not predicted") {
  Limits limits = two_balls(0.01, 0.5);
  const auto joint_part = [&](std::uint8_t index, const char* name, std::size_t joint) {
    PartLimits item = part(name, {joint});
    item.modes.joint_velocity = joint_mode({joint}, 4.0);
    item.modes.joint_velocity.gain = {0.5, 1.0};
    widen(item);
    limits.joints[joint].part = index;
    return item;
  };
  limits.parts[two_arms::hand] = joint_part(2, "one", two_arms::finger_1);
  (void)limits.parts.push_back(joint_part(3, "two", two_arms::finger_2));
  ChunkBuilder chunk;
  const auto code = [&] {
    const RobotModel model(limits);
    MeasuredState state = two_arms::at_rest();
    (void)state.acted.resize(4);
    return judge_path(model, whole_robot(limits), state, chunk.chunk, 0, 1, {}, {}).evidence.code;
  };
  for (std::uint8_t i = 0; i < 3; ++i) {
    Row row(4, 0.0);
    row[i] = 0.1;
    chunk.add(i, Mode::joint_velocity, {row}, {i});
  }
  CHECK(code() == 0);
  chunk.add(3, Mode::joint_velocity, {{0, 0, 0, 0.1}}, {3});
  CHECK(code() == 30);
}

TEST_CASE("judge_path judges only the rows that it is asked for") {
  Limits limits = free_arm::limits();
  limits.joints[slide_x].acceleration_limit = 5.0;
  limits.joints[slide_x].bounds.upper = 0.12;
  const RobotModel model(limits);
  const ClaimLimits claim = whole_robot(limits);
  const ChunkBuilder chunk = one_joint(Mode::joint_position, slide_x, {0.5, 0.01, 0.02, 0.2, 0.0});
  const auto judged = [&](std::size_t first, std::size_t end) {
    return judge_path(model, claim, at_rest(), chunk.chunk, first, end, {}, {});
  };
  CHECK(judged(1, 3).outcome == Outcome::released);
  CHECK(judged(1, 3).row_count == 2);
  CHECK(judged(1, 5).outcome == Outcome::truncated);
  CHECK(judged(1, 5).evidence.row == 3);
  CHECK(judged(0, 5).outcome == Outcome::refused);
  CHECK(judged(0, 5).evidence.code == 24);
}

TEST_CASE("a pose that acted and is out of reach by now says nothing about where the arm goes") {
  Limits limits = free_arm::limits();
  limits.parts[arm].joints.erase_at(1);  // without its slide along x
  limits.joints[slide_x].part = 9;
  limits.joints[slide_y].acceleration_limit = 5.0;
  const ChunkBuilder acted = ChunkBuilder().poses(arm, {{0.9, 0.4, 0.5, 0, 0, 0, 1}});
  const ChunkBuilder next = one_joint(Mode::joint_position, slide_y, {0.05});
  const RobotModel model(limits);
  const ClaimLimits claim = whole_robot(limits);
  const RowBefore before{&acted.chunk, 0};
  const MeasuredState rest = at_rest();
  Prediction prediction(model, claim, rest, next.chunk, 0, before, {});
  CHECK(prediction.advance().ok());
  CHECK(prediction.branch(0).speed[slide_y] == doctest::Approx(1.0));  // from what is measured
}
