// G020, G021, G022 and the part of G011 that judges rows: which rows of a chunk are released.

#include <doctest/doctest.h>

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "fairlead_safety/judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

Judgement judge(const ActionChunk& chunk, const MeasuredState& state = state_at_rest(),
                const RowBefore& before = {}, std::size_t first_row = 0) {
  static const Limits limits = test_limits();
  static const ClaimLimits claim = whole_robot(limits);
  return judge_rows(limits, claim, state, chunk, first_row, before);
}

// A single row that follows `previous`, so that only its own limits can refuse it.
std::uint32_t code_after(ChunkBuilder& previous, const ChunkBuilder& next,
                         const MeasuredState& state = state_at_rest()) {
  return judge(next.chunk, state, RowBefore{&previous.chunk, 0}).evidence.code;
}

}  // namespace

TEST_CASE("G020 joint position: inside the joint's bounds, ends included") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = 1.9;
  const auto code = [&state](double target) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {target}).chunk, state)
        .evidence.code;
  };
  CHECK(code(just_below(2.0)) == 0);
  CHECK(code(2.0) == 0);
  CHECK(code(just_above(2.0)) == 20);
  state.positions[arm_1] = -1.9;
  CHECK(code(-2.0) == 0);
  CHECK(code(just_below(-2.0)) == 20);
  for (const double bad : {not_a_number, infinite, -infinite}) CHECK(code(bad) == 20);
}

TEST_CASE("G020 joint velocity: up to the joint's limit in both directions") {
  ChunkBuilder previous;
  previous.joint(base, Mode::joint_velocity, base_x, {0.0});
  const auto code = [&previous](double velocity) {
    return code_after(previous,
                      ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {velocity}));
  };
  for (const double fine : {1.5, -1.5, just_below(1.5), 0.0}) CHECK(code(fine) == 0);
  for (const double bad : {just_above(1.5), just_below(-1.5), not_a_number, infinite, -infinite})
    CHECK(code(bad) == 20);
}

TEST_CASE("G020 cartesian delta: the norm counts, not the axes") {
  const auto code = [](const Row& row) {
    return judge(ChunkBuilder().add(arm, Mode::cartesian_delta, {row}, {}, "base_link").chunk)
        .evidence.code;
  };
  CHECK(code({0.1, 0, 0, 0, 0, 0}) == 0);
  CHECK(code({just_above(0.1), 0, 0, 0, 0, 0}) == 20);
  CHECK(code({0, 0, 0, 0.5, 0, 0}) == 0);
  CHECK(code({0, 0, 0, 0, 0, just_above(0.5)}) == 20);
  CHECK(code({0.06, 0.08, 0, 0, 0, 0}) == 0);   // norm 0.1
  CHECK(code({0.08, 0.08, 0, 0, 0, 0}) == 20);  // each axis is inside
  CHECK(code({0, 0, 0, 0.4, 0.4, 0}) == 20);
  for (const double bad : {not_a_number, infinite, -infinite}) {
    CHECK(code({0, bad, 0, 0, 0, 0}) == 20);
    CHECK(code({0, 0, 0, 0, bad, 0}) == 20);
  }
}

TEST_CASE("G020 body twist: the norm of each half") {
  const auto code = [](const Row& row) {
    return judge(ChunkBuilder().add(base, Mode::body_twist, {row}, {}, "base_link").chunk)
        .evidence.code;
  };
  CHECK(code({1.0, 0, 0, 0, 0, 0}) == 0);
  CHECK(code({just_above(1.0), 0, 0, 0, 0, 0}) == 20);
  CHECK(code({0.8, 0.8, 0, 0, 0, 0}) == 20);
  CHECK(code({0, 0, 0, 0, 0, 1.5}) == 0);
  CHECK(code({0, 0, 0, 0, 0, just_below(-1.5)}) == 20);
  for (const double bad : {not_a_number, infinite, -infinite})
    CHECK(code({bad, 0, 0, 0, 0, 0}) == 20);
}

TEST_CASE("G020 gripper and composite: inside their ranges, ends included") {
  MeasuredState state = state_at_rest();
  const auto opening = [&state](double value) {
    return judge(ChunkBuilder().scalar(gripper, Mode::gripper_position, {value}).chunk, state)
        .evidence.code;
  };
  for (const double fine : {0.0, 0.08, 0.04}) CHECK(opening(fine) == 0);
  for (const double bad : {just_above(0.08), just_below(0.0), not_a_number, infinite, -infinite})
    CHECK(opening(bad) == 20);
  const auto mode = [](double value) {
    return judge(ChunkBuilder().scalar(composite, Mode::composite_mode, {value}).chunk)
        .evidence.code;
  };
  for (const double fine : {-1.0, 1.0, 0.0}) CHECK(mode(fine) == 0);
  for (const double bad : {just_above(1.0), just_below(-1.0), not_a_number, infinite, -infinite})
    CHECK(mode(bad) == 20);
}

TEST_CASE("the evidence says row, part, axis, value, limit, margin and source") {
  const Judgement judgement =
      judge(ChunkBuilder().along(arm, Mode::cartesian_delta, 2, {0.05, 0.05, 0.11}).chunk);
  CHECK(judgement.outcome == Outcome::truncated);
  CHECK(judgement.row_count == 2);
  CHECK(judgement.evidence.code == 20);
  CHECK(judgement.evidence.row == 2);
  CHECK(judgement.evidence.part == "arm");
  CHECK(judgement.evidence.axis == "linear");
  CHECK(judgement.evidence.value == doctest::Approx(0.11));
  CHECK(judgement.evidence.limit == 0.1);
  CHECK(judgement.evidence.margin == doctest::Approx(-0.01));
  CHECK(judgement.evidence.limit_source == "test cartesian mode");
}

TEST_CASE("a breach in the first row refuses, a later one cuts before it, none releases all") {
  const auto outcome = [](const Row& rows) {
    return judge(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, rows).chunk).outcome;
  };
  CHECK(outcome({0.2, 0.0, 0.0}) == Outcome::refused);
  CHECK(outcome({0.0, 0.0, 0.2}) == Outcome::truncated);
  CHECK(outcome({0.0, 0.0, 0.0}) == Outcome::released);
}

TEST_CASE("rows that are past are not judged, and the first live row is the one that refuses") {
  const ChunkBuilder builder =
      ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {5.0, 0.05, 0.05});
  CHECK(judge(builder.chunk).outcome == Outcome::refused);
  const Judgement later = judge(builder.chunk, state_at_rest(), {}, 1);
  CHECK(later.outcome == Outcome::released);
  CHECK(later.first_row == 1);
  CHECK(later.row_count == 2);
}

TEST_CASE("G011 an arm joint outside bounds and tolerance: only targets nearer to them") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = 2.2;
  const auto code = [&state](const Row& targets) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, targets).chunk, state)
        .evidence.code;
  };
  CHECK(code({2.15}) == 0);  // still outside, nearer
  CHECK(code({2.15, 2.1, 2.0}) == 0);
  CHECK(code({2.2}) == 11);  // as far out
  CHECK(code({2.25}) == 11);
  CHECK(code({2.1, 2.15}) == 11);   // and out again
  state.positions[arm_1] = 2.0625;  // within the tolerance: the bounds apply as they are
  CHECK(code({2.05}) == 20);
  CHECK(code({1.95}) == 0);
}

TEST_CASE("G011 an arm joint outside: velocities lead back, other commands do not") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = -2.2;
  const auto velocity = [&state](double value) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {value}).chunk, state)
        .evidence.code;
  };
  CHECK(velocity(0.1) == 0);
  CHECK(velocity(0.0) == 11);
  CHECK(velocity(-0.1) == 11);
  CHECK(judge(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_2, {0.1}).chunk, state)
            .evidence.code == 11);
  CHECK(judge(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.01}).chunk, state)
            .evidence.code == 11);
  // Parts that are inside their bounds are not concerned.
  CHECK(judge(ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {0.1}).chunk, state)
            .evidence.code == 0);
}

TEST_CASE("G011 a gripper outside its bounds may go anywhere inside them") {
  MeasuredState state = state_at_rest();
  state.positions[gripper_joint] = 0.095;
  CHECK(judge(ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.06}).chunk, state)
            .evidence.code == 0);
}

TEST_CASE("G011 a passive joint outside its bounds: no row can bring it back") {
  MeasuredState state = state_at_rest();
  const ChunkBuilder builder = ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.04});
  state.positions[torso] = 0.41;
  CHECK(judge(builder.chunk, state).evidence.code == 0);  // at the tolerance
  state.positions[torso] = just_above(0.41) + 1e-9;
  CHECK(judge(builder.chunk, state).evidence.code == 11);
  CHECK(judge(builder.chunk, state).evidence.axis == "torso");
  state.positions[torso] = -0.2;
  CHECK(judge(builder.chunk, state).evidence.code == 11);
}

TEST_CASE("G021 a joint target starts within a step of the measured position") {
  const auto code = [](double target) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {target}).chunk)
        .evidence.code;
  };
  CHECK(code(0.35) == 0);  // step 0.25 + tolerance 0.1
  CHECK(code(just_above(0.35)) == 21);
  CHECK(code(just_below(-0.35)) == 21);
}

TEST_CASE("G021 a joint target starts within a step of what was executed last") {
  ChunkBuilder previous;
  previous.joint(arm, Mode::joint_position, arm_1, {-0.1});
  const auto code = [&previous](double target) {
    return code_after(previous, ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {target}));
  };
  CHECK(code(0.15) == 0);
  CHECK(code(0.15 + 1e-9) == 21);
}

TEST_CASE("G021 padding of the row before is no setpoint") {
  ChunkBuilder previous;
  previous.joint(arm, Mode::joint_position, arm_2, {0.1});
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = 1.0;
  CHECK(code_after(previous, ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {1.0}),
                   state) == 0);
}

TEST_CASE("G021 a velocity starts from what was executed, after a hold from what is measured") {
  MeasuredState state = state_at_rest();
  state.velocities[arm_1] = 0.2;
  const auto after_hold = [&state](double value) {
    return judge(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {value}).chunk, state)
        .evidence.code;
  };
  CHECK(after_hold(0.7) == 0);
  CHECK(after_hold(0.7 + 1e-9) == 21);
  CHECK(after_hold(-0.3 - 1e-9) == 21);
  ChunkBuilder previous;
  previous.joint(arm, Mode::joint_velocity, arm_1, {0.5});
  CHECK(code_after(previous, ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {1.0}),
                   state) == 0);
  CHECK(code_after(previous,
                   ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {just_above(1.0)}),
                   state) == 21);
}

TEST_CASE("G021 a delta or twist after a hold starts from zero") {
  static Limits limits = test_limits();
  ClaimLimits claim = whole_robot(limits);
  claim.modes[arm].cartesian_delta.linear_step_limit = 0.05;
  claim.modes[base].body_twist.angular_step_limit = 0.5;
  const auto code = [&claim](const ChunkBuilder& builder) {
    return judge_rows(limits, claim, state_at_rest(), builder.chunk, 0, {}).evidence.code;
  };
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 1, {0.05})) == 0);
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 1, {just_above(0.05)})) == 21);
  CHECK(code(ChunkBuilder().along(base, Mode::body_twist, 5, {0.5})) == 0);
  CHECK(code(ChunkBuilder().along(base, Mode::body_twist, 5, {just_above(0.5)})) == 21);
}

TEST_CASE("G021 gripper and composite start from what is known of them") {
  MeasuredState state = state_at_rest();
  state.positions[gripper_joint] = 0.0;
  const auto opening = [&state](double value) {
    return judge(ChunkBuilder().scalar(gripper, Mode::gripper_position, {value}).chunk, state)
        .evidence.code;
  };
  CHECK(opening(0.06) == 0);  // step 0.05 + tolerance 0.01
  CHECK(opening(0.06 + 1e-9) == 21);
  ChunkBuilder previous;
  previous.scalar(composite, Mode::composite_mode, {-1.0});
  CHECK(code_after(previous, ChunkBuilder().scalar(composite, Mode::composite_mode, {0.5})) == 0);
  CHECK(code_after(previous,
                   ChunkBuilder().scalar(composite, Mode::composite_mode, {0.5 + 1e-9})) == 21);
  ChunkBuilder closed;
  closed.scalar(gripper, Mode::gripper_position, {0.0});
  state.positions[gripper_joint] = 0.04;
  CHECK(code_after(closed, ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.05}), state) ==
        0);
  CHECK(code_after(closed,
                   ChunkBuilder().scalar(gripper, Mode::gripper_position, {just_above(0.05)}),
                   state) == 21);
}

TEST_CASE("G022 the jump from row to row, for every mode") {
  const auto code = [](const ChunkBuilder& builder) { return judge(builder.chunk).evidence.code; };
  CHECK(code(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, 0.25})) == 0);
  CHECK(code(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, just_above(0.25)})) ==
        22);
  CHECK(code(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.0, -0.5})) == 0);
  CHECK(code(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.0, just_below(-0.5)})) ==
        22);
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.1, 0.1, -0.05})) == 0);
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.1, 0.1, -0.06})) == 22);
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 4, {0.5, -0.25})) == 0);
  CHECK(code(ChunkBuilder().along(arm, Mode::cartesian_delta, 4, {0.5, -0.26})) == 22);
  CHECK(code(ChunkBuilder().along(base, Mode::body_twist, 0, {1.0, -0.5})) == 0);
  CHECK(code(ChunkBuilder().along(base, Mode::body_twist, 0, {1.0, -0.51})) == 22);
  CHECK(code(ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.0, 0.05})) == 0);
  CHECK(code(ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.0, just_above(0.05)})) ==
        22);
  CHECK(code(ChunkBuilder().scalar(composite, Mode::composite_mode, {-1.0, 0.5})) == 0);
  CHECK(code(ChunkBuilder().scalar(composite, Mode::composite_mode, {-1.0, 1.0})) == 22);
}

TEST_CASE("a tighter limit never releases more") {
  static Limits limits = test_limits();
  const ClaimLimits wide = whole_robot(limits);
  ClaimLimits tight = wide;
  tight.modes[arm].cartesian_delta.linear_limit = 0.04;
  for (int i = 0; i < 200; ++i) {
    Row rows;
    for (int k = 0; k < 8; ++k) rows.push_back(0.1 * std::sin(0.37 * i + 0.9 * k));
    const ChunkBuilder builder = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, rows);
    const auto released = [&](const ClaimLimits& claim) {
      return judge_rows(limits, claim, state_at_rest(), builder.chunk, 0, {}).row_count;
    };
    CHECK(released(tight) <= released(wide));
  }
}
