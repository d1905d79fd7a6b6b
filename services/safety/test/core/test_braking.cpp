// G024: where braking ends, a bounded joint is inside its bounds. A period is 0.05 s, so a change
// of 0.05 m is 1 m/s; at 5 m/s2 it takes 0.1 m to brake from that.

#include <doctest/doctest.h>

#include "core/chunk/judgement.hpp"
#include "free_arm.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr double eps = 1e-9;

Limits braking_at(double deceleration, double lower, double upper) {
  Limits limits = free_arm::limits();
  limits.joints[slide_x].acceleration_limit = deceleration;
  limits.joints[slide_x].bounds.lower = lower;
  limits.joints[slide_x].bounds.upper = upper;
  return limits;
}

Judgement targets(const Limits& limits, const Row& values, double measured = 0.0) {
  MeasuredState state = at_rest();
  state.positions[slide_x] = measured;
  return free_arm::judge(limits, one_joint(Mode::joint_position, slide_x, values).chunk, state);
}

}  // namespace

TEST_CASE("G024 a target: the row's change over the period, and the way it takes to brake") {
  CHECK(targets(braking_at(5.0, -2.0, 0.15 + eps), {0.05}).evidence.ok());
  const Limits near = braking_at(5.0, -2.0, 0.15 - eps);  // evidence points into it
  const Judgement refused = targets(near, {0.05});
  CHECK(refused.outcome == Outcome::refused);
  CHECK(refused.evidence.code == 24);
  CHECK(refused.evidence.axis == "slide_x");
  CHECK(refused.evidence.part == "arm");
  CHECK(refused.evidence.row == 0);
  CHECK(refused.evidence.value == doctest::Approx(0.15));
  CHECK(refused.evidence.limit == 0.15 - eps);
  CHECK(refused.evidence.unit == "m");
  CHECK(refused.evidence.margin == doctest::Approx(-eps).epsilon(1e-3));
  CHECK(refused.evidence.limit_source == "test joint");
  CHECK(targets(braking_at(5.0, -0.15 - eps, 2.0), {-0.05}).evidence.ok());
  CHECK(targets(braking_at(5.0, -0.15 + eps, 2.0), {-0.05}).evidence.code == 24);
}

TEST_CASE("G024 cuts where braking would end too far; each row counts from the one before it") {
  const Judgement cut = targets(braking_at(5.0, -2.0, 0.21), {0.05, 0.1, 0.15});
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.row_count == 2);
  CHECK(cut.evidence.code == 24);
  CHECK(cut.evidence.row == 2);
  // The last step is half as long: from 0.5 m/s it takes 25 mm.
  CHECK(targets(braking_at(5.0, -2.0, 0.15 + eps), {0.05, 0.1, 0.125}).evidence.row == 1);
  CHECK(targets(braking_at(5.0, -2.0, 0.2 + eps), {0.05, 0.1, 0.125}).evidence.ok());
}

TEST_CASE("G024 only motion towards a bound counts") {
  const Limits limits = braking_at(5.0, -2.0, 0.1);
  CHECK(targets(limits, {0.1}, 0.1).evidence.ok());         // at the bound, standing
  CHECK(targets(limits, {0.06, 0.02}, 0.1).evidence.ok());  // away from it
  CHECK(targets(limits, {0.1}, 0.09).evidence.code == 24);
}

TEST_CASE("G024 velocities: the share that the gain says, and the limit of the joint") {
  Limits limits = braking_at(5.0, -2.0, 0.2);
  const auto code = [&](double velocity) {
    return free_arm::judge(limits, one_joint(Mode::joint_velocity, slide_x, {velocity}).chunk)
        .evidence.code;
  };
  CHECK(code(1.0) == 0);  // 0.05 m and then 0.1
  limits.joints[slide_x].bounds.upper = 0.15 - eps;
  CHECK(code(1.0) == 24);
  limits.parts[arm].modes.joint_velocity.gain = {0.0, 0.5};  // at most 0.025 m and then 0.025
  limits.joints[slide_x].bounds.upper = 0.05 + eps;
  CHECK(code(1.0) == 0);
  limits.joints[slide_x].bounds.upper = 0.05 - eps;
  CHECK(code(1.0) == 24);
  limits.parts[arm].modes.joint_velocity.gain = {1.0, unset};
  CHECK(code(1.0) == 30);
  limits.parts[arm].modes.joint_velocity.gain = {1.0, 1.0};
  limits.joints[slide_x].bounds.upper = 2.0;
  CHECK(code(1.0) == 0);
  limits.joints[slide_x].acceleration_limit = not_a_number;
  CHECK(code(1.0) == 24);
}

TEST_CASE("G024 no joint is faster than its limit, whatever a target asks for") {
  Limits limits = braking_at(5.0, -2.0, 0.25 + 0.225 + eps);  // 1.5 m/s takes 0.225 m
  CHECK(targets(limits, {0.25}).evidence.ok());               // 5 m/s by its change
  limits.joints[slide_x].bounds.upper = 0.25 + 0.225 - eps;
  CHECK(targets(limits, {0.25}).evidence.code == 24);
}

TEST_CASE("G024 a target counts from the target before it, not from what lags behind") {
  const Limits limits = braking_at(5.0, -2.0, 0.2);
  MeasuredState state = at_rest();
  state.positions[slide_x] = 0.05;
  const ChunkBuilder before = one_joint(Mode::joint_position, slide_x, {0.1});
  const ChunkBuilder next = one_joint(Mode::joint_position, slide_x, {0.125});
  // From 0.1: 0.5 m/s, 25 mm. From what is measured: 1.5 m/s, 0.225 m.
  CHECK(free_arm::judge(limits, next.chunk, state, RowBefore{&before.chunk, 0}).evidence.ok());
  CHECK(free_arm::judge(limits, next.chunk, state).evidence.code == 24);
}

TEST_CASE("G024 realtime: the row that acts already is gone through first") {
  const Limits limits = braking_at(5.0, -2.0, 0.2 + eps);
  const ChunkBuilder before = one_joint(Mode::joint_velocity, slide_x, {1.0});
  const ChunkBuilder next = one_joint(Mode::joint_velocity, slide_x, {1.0});
  RowBefore acts{&before.chunk, 0};
  acts.measured = false;  // 0.05 m of it, 0.05 of the next row, 0.1 to brake
  CHECK(free_arm::judge(limits, next.chunk, at_rest(), acts).evidence.ok());
  Limits tighter = limits;
  tighter.joints[slide_x].bounds.upper = 0.2 - eps;
  CHECK(free_arm::judge(tighter, next.chunk, at_rest(), acts).evidence.code == 24);
  acts.measured = true;
  CHECK(free_arm::judge(tighter, next.chunk, at_rest(), acts).evidence.ok());
}

TEST_CASE("G024 a delta brakes like the joints that it moves") {
  Limits limits = braking_at(5.0, -2.0, 0.3);
  const auto judged = [&](double by) {
    return free_arm::judge(limits, ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {by}).chunk);
  };
  CHECK(judged(0.05).evidence.ok());
  limits.joints[slide_x].bounds.upper = 0.14;
  CHECK(judged(0.05).evidence.code == 24);
  CHECK(judged(0.05).evidence.axis == "slide_x");
}

TEST_CASE("G024 in the first row a joint may be as fast as it is measured") {
  const Limits limits = braking_at(5.0, -2.0, 0.15);
  const auto code = [&](double target, double measured, bool velocity_stuck = false) {
    MeasuredState state = at_rest();
    (velocity_stuck ? state.travel_speeds : state.velocities)[slide_x] = measured;
    return free_arm::judge(limits, one_joint(Mode::joint_position, slide_x, {target}).chunk, state)
        .evidence.code;
  };
  // 0.2 m/s: 0.01 m, and 4 mm to brake; from 1.2 m/s it takes 0.144 m.
  CHECK(code(0.01, 0.0) == 0);
  CHECK(code(0.01, 1.1) == 0);
  CHECK(code(0.01, 1.2) == 24);
  CHECK(code(-0.01, 1.2) == 0);
  CHECK(code(0.01, 1.1, true) == 0);
  CHECK(code(0.01, 1.2, true) == 24);
}

TEST_CASE("G024 what is measured may go on through the first row, whatever a velocity says") {
  const auto code = [](const Limits& limits, const Row& velocities, double measured) {
    MeasuredState state = at_rest();
    state.velocities[slide_x] = measured;
    return free_arm::judge(limits, one_joint(Mode::joint_velocity, slide_x, velocities).chunk,
                           state)
        .evidence;
  };
  // From 1 m/s: 0.05 m in the tick, and 0.1 m to brake.
  const Limits enough = braking_at(5.0, -0.15 - eps, 0.15 + eps);
  const Limits less = braking_at(5.0, -0.15 + eps, 0.15 - eps);
  for (const double told : {0.0, 0.2, -0.2}) {
    CHECK(code(enough, {told, told}, 1.0).ok());
    CHECK(code(enough, {told, told}, -1.0).ok());
    CHECK(code(less, {told, told}, 1.0).code == 24);
    CHECK(code(less, {told, told}, -1.0).code == 24);
    CHECK(code(less, {told, told}, 1.0).row == 0);
    CHECK(code(less, {told, told}, 0.0).ok());
  }
  CHECK(code(less, {0.0}, 1.0).value == doctest::Approx(0.15));
}

TEST_CASE("G024 a joint told a velocity goes on for its lag; one told a target does not") {
  Limits limits = braking_at(5.0, -2.0, 0.27 + eps);
  limits.joints[slide_x].stop_lag = 0.12;
  const auto code = [&](Mode mode, double value) {
    return free_arm::judge(limits, one_joint(mode, slide_x, {value}).chunk).evidence.code;
  };
  CHECK(code(Mode::joint_velocity, 1.0) == 0);  // 0.05 m, 0.12 m, 0.1 m to brake
  limits.joints[slide_x].bounds.upper = 0.27 - eps;
  CHECK(code(Mode::joint_velocity, 1.0) == 24);
  limits.joints[slide_x].bounds.upper = 0.15 + eps;
  CHECK(code(Mode::joint_position, 0.05) == 0);
  limits.joints[slide_x].stop_lag = not_a_number;
  CHECK(code(Mode::joint_velocity, 1.0) == 24);
}

TEST_CASE("G024 a pose is approached from the pose before it, not from where the arm lags") {
  const auto code = [](const RowBefore& before) {
    const Limits limits = braking_at(5.0, -2.0, 0.05);
    const ChunkBuilder now = ChunkBuilder().poses(arm, {{0.74, 0, 0.5, 0, 0, 0, 1}});
    return judge_path(RobotModel(limits), whole_robot(limits), at_rest(), now.chunk, 0, 1, before,
                      {})
        .evidence.code;
  };
  // From what is measured it is 0.04 m in a tick, 0.8 m/s and 0.064 m to brake.
  CHECK(code({}) == 24);
  const ChunkBuilder last = ChunkBuilder().poses(arm, {{0.73, 0, 0.5, 0, 0, 0, 1}});
  CHECK(code(RowBefore{&last.chunk, 0}) == 0);  // 0.2 m/s and 4 mm
}

TEST_CASE("what other claims tell a joint counts from the target before, too") {
  // The right arm lags 0.1 rad behind; from there it would be 2 rad/s and brake into the left one.
  Limits limits = two_arms::limits();
  limits.collision.capsules[0] = {2, {0, 0, 0}, {0, 0, 0}, 0.1};
  limits.collision.capsules[1] = {4, {0, 0, 0}, {0, 0, 0}, 0.1};
  limits.collision.clearance = 0.3;
  limits.joints[two_arms::right_1].velocity_limit = 2.5;
  limits.joints[two_arms::right_1].acceleration_limit = 8.0;  // 2 rad/s: 0.25 rad
  ChunkBuilder own, last, next;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1, {0.0});
  two_arms::command(last, two_arms::right, Mode::joint_position, two_arms::right_1, {0.1});
  two_arms::command(next, two_arms::right, Mode::joint_position, two_arms::right_1, {0.1});
  const RobotModel model(limits);
  const auto code = [&](const RowBefore& before) {
    const Companion other{before, &next.chunk, 0, 1};
    return judge_path(model, whole_robot(limits), two_arms::at_rest(), own.chunk, 0, 1, {},
                      Companions(&other, 1))
        .evidence.code;
  };
  // 0.6 - 0.5 sin 0.1 - 0.2 leaves 0.35; where braking ends, 0.6 - 0.5 sin 0.35 - 0.2 is 0.23.
  CHECK(code(RowBefore{&last.chunk, 0}) == 0);
  CHECK(code({}) == 32);
}

TEST_CASE("G024 realtime: what is measured goes on, whatever the row that acts already says") {
  const auto code = [](const Limits& limits, double acting, double measured) {
    MeasuredState state = at_rest();
    state.velocities[slide_x] = measured;
    const ChunkBuilder before = one_joint(Mode::joint_velocity, slide_x, {acting});
    const ChunkBuilder next = one_joint(Mode::joint_velocity, slide_x, {0.0});
    RowBefore acts{&before.chunk, 0};
    acts.measured = false;
    return free_arm::judge(limits, next.chunk, state, acts).evidence.code;
  };
  // From 1 m/s: 0.05 m in the tick, and 0.1 m to brake.
  const Limits enough = braking_at(5.0, -0.15 - eps, 0.15 + eps);
  const Limits less = braking_at(5.0, -0.15 + eps, 0.15 - eps);
  for (const double acting : {0.0, 0.2, -0.2}) {
    CHECK(code(enough, acting, 1.0) == 0);
    CHECK(code(enough, acting, -1.0) == 0);
    CHECK(code(less, acting, 1.0) == 24);
    CHECK(code(less, acting, -1.0) == 24);
  }
  CHECK(code(less, 0.5, 0.0) == 0);  // 0.025 m, as far again, and 0.025 m to brake
}

TEST_CASE("G024 a target beyond a bound is at fault, also on the way back from one further out") {
  const auto code = [](double measured, double target) {
    MeasuredState state = at_rest();
    state.positions[slide_x] = measured;
    const ChunkBuilder last =
        one_joint(Mode::joint_position, slide_x, {std::copysign(0.12, target)});
    const Limits limits = braking_at(1e18, -0.1, 0.1);
    return judge_path(RobotModel(limits), whole_robot(limits), state,
                      one_joint(Mode::joint_position, slide_x, {target}).chunk, 0, 1,
                      RowBefore{&last.chunk, 0}, {})
        .evidence.code;
  };
  for (const double side : {1.0, -1.0}) {
    CHECK(code(side * 0.09, side * 0.11) == 24);
    CHECK(code(side * 0.1, side * 0.11) == 24);
    CHECK(code(side * 0.09, side * 0.1) == 0);
    CHECK(code(side * 0.115, side * 0.11) == 0);  // beyond it already
  }
}
