// What nothing tells anything, and what is measured of it: it brakes, after its lag.

#include <doctest/doctest.h>

#include "free_arm.hpp"
#include "predicted.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("what nothing tells anything comes to rest, in the first row or, where it holds, later") {
  Limits limits = two_arms::limits();
  limits.joints[two_arms::right_1].acceleration_limit = 5.0;
  limits.joints[two_arms::right_1].stop_lag = 0.1;
  ChunkBuilder own, other;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1, {0.1, 0.1, 0.1});
  two_arms::command(other, two_arms::right, Mode::joint_position, two_arms::right_1, {0.02});
  MeasuredState state = two_arms::at_rest();
  state.velocities[two_arms::right_1] = 0.5;
  const double at_rest = 0.1 * 0.5 + 0.5 * 0.5 / 10.0;
  const auto right = [](const Prediction& of, std::size_t branch) {
    return std::pair(of.branch(branch).now[two_arms::right_1],
                     of.branch(branch).speed[two_arms::right_1]);
  };
  Predicted alone(limits, state, own.chunk);
  CHECK(alone.all.branch_count() == 2);
  CHECK(alone.all.lagging() == only(two_arms::right_1));
  (void)alone.after_a_row();
  CHECK(right(alone.all, 0).first == doctest::Approx(at_rest));
  CHECK(right(alone.all, 0).second == 0.0);
  CHECK(right(alone.all, 1) == std::pair(0.0, 0.5));
  (void)alone.after_a_row();
  for (const std::size_t branch : {0U, 1U}) {
    CHECK(right(alone.all, branch).first == doctest::Approx(at_rest));
    CHECK(right(alone.all, branch).second == 0.0);
  }
  // A claim whose only row acts beside the first: from the second on it has come to rest.
  const Companion companion{{}, &other.chunk, 0, 1};
  Predicted beside(limits, state, own.chunk, {}, Companions(&companion, 1));
  (void)beside.after_a_row();
  CHECK(right(beside.all, 0) == std::pair(0.02, 0.5));
  (void)beside.after_a_row();
  CHECK(right(beside.all, 0).first == doctest::Approx(0.02 + at_rest));
  CHECK(right(beside.all, 1).first == doctest::Approx(at_rest));
}

namespace {

// Two balls of 0.05 m at the tools, kept 0.25 m apart: their centres stay 0.35 m apart. At rest
// they are 0.6 m apart, the right one 0.447 m from the left where that is told to be in its third
// row, and 0.304 m where it comes to rest.
Limits balls() {
  Limits limits = two_arms::limits();
  limits.joints[two_arms::right_1].acceleration_limit = 0.5;
  limits.joints[two_arms::right_1].stop_lag = 0.1;
  limits.collision.capsules[0] = {2, {0, 0, 0}, {0, 0, 0}, 0.05};
  limits.collision.capsules[1] = {4, {0, 0, 0}, {0, 0, 0}, 0.05};
  limits.collision.clearance = 0.25;
  return limits;
}

Judgement beside(const MeasuredState& state, Companions companions) {
  const Limits limits = balls();
  ChunkBuilder own;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1,
                    {-0.1, -0.2, -0.3});
  return judge_path(RobotModel(limits), whole_robot(limits), state, own.chunk, 0, 3, {},
                    companions);
}

}  // namespace

TEST_CASE("G032 what only its positions show to move is seen to come to rest") {
  MeasuredState state = two_arms::at_rest();
  state.travel_speeds[two_arms::right_1] = 0.5;
  CHECK(beside(state, {}).evidence.code == 32);
  state.travel_speeds[two_arms::right_1] = -0.5;  // away from it
  CHECK(beside(state, {}).evidence.ok());
}

TEST_CASE(
    "G032 a later row may not meet what comes to rest beside it, coasting or after its rows") {
  MeasuredState state = two_arms::at_rest();
  CHECK(beside(state, {}).evidence.ok());
  state.velocities[two_arms::right_1] = 0.5;
  CHECK(beside(state, {}).evidence.code == 32);
  CHECK(beside(state, {}).row_count == 2);
  // The same, of another claim whose only row acts beside the first.
  ChunkBuilder other;
  two_arms::command(other, two_arms::right, Mode::joint_position, two_arms::right_1, {0.002});
  const Companion companion{{}, &other.chunk, 0, 1};
  CHECK(beside(state, Companions(&companion, 1)).evidence.code == 32);
  CHECK(beside(state, Companions(&companion, 1)).row_count == 2);
}

namespace {

// From `from` to `to` in one row, beside a right arm that is measured at `at` and moves at `speed`.
Judgement past(const Limits& limits, double from, double to, double at, double speed) {
  ChunkBuilder own;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1, {to});
  MeasuredState state = two_arms::at_rest();
  state.positions[two_arms::left_1] = from;
  state.positions[two_arms::right_1] = at;
  state.velocities[two_arms::right_1] = speed;
  return judge_path(RobotModel(limits), whole_robot(limits), state, own.chunk, 0, 1, {}, {});
}

}  // namespace

TEST_CASE("G032 what moves out of the way of a stop may stop at once") {
  Limits limits = balls();
  limits.joints[two_arms::left_1].acceleration_limit = 5.0;
  // At 1.5 rad/s the left arm comes to rest 0.225 rad behind its row: 0.32 m from where the right
  // one is, 0.46 m from where that comes to rest.
  CHECK(past(limits, -0.3, -0.4, 0.0, 0.0).evidence.code == 32);
  CHECK(past(limits, -0.3, -0.4, 0.0, -0.5).evidence.code == 32);
  CHECK(past(limits, -0.3, -0.4, -0.3, 0.0).evidence.ok());
}

TEST_CASE("G032 what passes where a stop ends may stop there") {
  Limits limits = balls();
  limits.collision.clearance = 0.05;
  limits.joints[two_arms::left_1].acceleration_limit = 1.0;
  limits.joints[two_arms::right_1].acceleration_limit = 10.0;
  // The tools' circles meet at -0.64 and 0.64 rad. The left arm comes to rest there after 1.1 s,
  // the right one goes from 1 to 0.25 rad in 0.4 s.
  CHECK(past(limits, 0.015, -0.04, 1.0, 0.0).evidence.ok());
  CHECK(past(limits, 0.015, -0.04, 0.25, 0.0).evidence.ok());
  CHECK(past(limits, 0.015, -0.04, 1.0, -3.0).evidence.code == 32);
}

TEST_CASE("G032 of two parts that brake one may stop at once: at its target, for example") {
  Limits limits = balls();
  for (const std::size_t j : {two_arms::left_1, two_arms::right_1}) {
    limits.joints[j].acceleration_limit = 5.0;
    limits.joints[j].stop_lag = 0.0;
  }
  // The left arm follows the right one. Both come to rest 0.225 rad behind their rows, 0.44 m
  // apart; 0.34 m apart where the right one stays at its target.
  ChunkBuilder own;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1, {-0.5});
  two_arms::command(own, two_arms::right, Mode::joint_position, two_arms::right_1, {-0.1});
  MeasuredState state = two_arms::at_rest();
  state.positions[two_arms::left_1] = -0.4;
  const auto judged = [&](std::size_t certified_end) {
    return judge_path(shared_room(), RobotModel(limits), whole_robot(limits), state, own.chunk,
                      {0, 1, certified_end}, {}, {});
  };
  CHECK(judged(1).evidence.code == 32);
  CHECK(judged(0).evidence.ok());  // a forecast: it is certified before it acts
}

TEST_CASE("what only its positions show to move may stand where it is, whatever rows come") {
  Limits limits = two_arms::limits();
  JointLimits& right = limits.joints[two_arms::right_1];
  right.acceleration_limit = 5.0;
  ChunkBuilder own;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1, {0.1, 0.1, 0.1});
  const auto stands = [&](double velocity, double travel_speed) {
    MeasuredState state = two_arms::at_rest();
    state.velocities[two_arms::right_1] = velocity;
    state.travel_speeds[two_arms::right_1] = travel_speed;
    Predicted predicted(limits, state, own.chunk);
    REQUIRE(predicted.all.branch_count() == 2);
    (void)predicted.after_a_row();
    (void)predicted.after_a_row();
    CHECK(predicted.all.branch(0).now[two_arms::right_1] != 0.0);
    return predicted.all.branch(1).now[two_arms::right_1] == 0.0;
  };
  for (const double way : {1.0, -1.0}) {
    CHECK(stands(0.0, 0.5 * way));
    CHECK_FALSE(stands(0.5 * way, 0.5 * way));
    CHECK_FALSE(stands(right.standstill_velocity * way, 0.5 * way));
  }
}

TEST_CASE("in the tick that runs a joint holds that another claim's only row commands next") {
  const Limits limits = two_arms::limits();
  ChunkBuilder own, other;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1, {0.1, 0.1});
  two_arms::command(other, two_arms::right, Mode::joint_position, two_arms::right_1, {0.02});
  MeasuredState state = two_arms::at_rest();
  state.velocities[two_arms::right_1] = 0.5;
  PartMemories memories;
  const RowBefore running{nullptr, 0, false, &memories};
  const Companion companion{{}, &other.chunk, 0, 1};
  Predicted beside(limits, state, own.chunk, running, Companions(&companion, 1));
  CHECK(beside.all.start_off()[two_arms::right_1] == doctest::Approx(0.0125));
  CHECK(beside.all.is_start_off());
  beside.all.only_forecast();
  CHECK_FALSE(beside.all.is_start_off());
  Predicted alone(limits, state, own.chunk, running);
  CHECK_FALSE(alone.all.is_start_off());
}

TEST_CASE("a first target is reached as much faster or slower as a held tick leaves open") {
  // Half way between 0 and 10 mm when it begins: 0.4 m/s to 25 mm, give or take 0.1.
  for (const double way : {1.0, -1.0}) {
    MeasuredState state = free_arm::at_rest();
    state.velocities[free_arm::slide_x] = 0.2 * way;
    PartMemories memories;
    const ChunkBuilder chunk =
        free_arm::one_joint(Mode::joint_position, free_arm::slide_x, {0.025 * way});
    Predicted predicted(free_arm::limits(), state, chunk.chunk, {nullptr, 0, false, &memories});
    const Branch& branch = predicted.after_a_row();
    CHECK(branch.speed[free_arm::slide_x] == doctest::Approx(0.5 * way));
    CHECK(branch.slowed().speed[free_arm::slide_x] == doctest::Approx(0.3 * way));
    CHECK(predicted.all.turn_off() == 0.0);  // there is no base
  }
}

TEST_CASE("the targets of the row before, if it had any, of whichever joint") {
  const ChunkBuilder chunk = free_arm::one_joint(Mode::joint_position, 0, {0.01});
  Predicted first(free_arm::limits(), free_arm::at_rest(), chunk.chunk);
  CHECK_FALSE(first.all.last_targets().has_value());
  Predicted next(free_arm::limits(), free_arm::at_rest(), chunk.chunk, {&chunk.chunk, 0, true});
  REQUIRE(next.all.last_targets().has_value());
  CHECK((*next.all.last_targets())[0] == 0.01);
}
