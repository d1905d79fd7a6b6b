// Rows that are in order as a whole are those of which no row has a fault by itself: random rows
// and measured joints, all of them mostly at the edge of what they may be; and each edge by itself.

#include <doctest/doctest.h>

#include <random>

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "core/modes/row_limit_check.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

using Random = std::mt19937_64;

double one_of(Random& random, std::initializer_list<double> values) {
  return values.begin()[random() % values.size()];
}

// The test robot, with a part of all its joints if `whole`, else its arm.
Limits robot(bool whole) {
  Limits limits = test_limits();
  if (!whole) return limits;
  PartLimits& part = limits.parts[arm];
  part.joints.clear();
  for (std::size_t j = 0; j < joint_count; ++j) {
    (void)part.joints.push_back(j);
    limits.joints[j].part = arm;
    limits.joints[j].velocity_limit = 1.5;
    if (limits.joints[j].bounded) limits.joints[j].bounds = {-2.0, 2.0, 0.1};
  }
  part.modes.joint_position = joint_mode({0, 1, 2, 3, 4, 5}, 0.25);
  part.modes.joint_velocity = joint_mode({0, 1, 2, 3, 4, 5}, 0.5);
  return limits;
}

struct Case {
  Case(Random& random, bool whole_robot, Mode which)
      : whole(whole_robot), mode(which), limits(robot(whole_robot)) {
    const double place = one_of(random, {0.0, 1.8, 1.9, 2.0});
    measure(random, place);
    first_row = random() % 3;
    fill(random, place, chunk, first_row + 1 + random() % 4);
  }

  void measure(Random& random, double place) {
    for (std::size_t j = 0; j < joint_count; ++j)
      state.positions[j] = place + one_of(random, {0.0, 0.0, 0.0, 0.0, 0.05, 0.1, 0.3});
  }
  void fill(Random& random, double place, ChunkBuilder& builder, std::size_t count) const {
    const bool velocity = mode == Mode::joint_velocity;
    Rows rows;
    for (std::size_t i = 0; i < count; ++i) {
      Row row(joint_count, 0.0);
      for (std::size_t j = whole ? 0 : arm_1; j < (whole ? joint_count : gripper_joint); ++j)
        row[j] = velocity ? one_of(random, {0.0, 0.1, 0.5, 0.5, -0.1})
                          : place + one_of(random, {0.0, 0.0, 0.0, 0.1, 0.1, 0.2, -0.05});
      rows.push_back(row);
    }
    if (whole)
      builder.add(arm, mode, rows, {0, 1, 2, 3, 4, 5});
    else
      builder.add(arm, mode, rows, {arm_1, arm_2});
  }

  [[nodiscard]] bool at_once() const {
    return rows_in_order(limits, limits.parts[arm].modes, state, chunk.chunk.parts[0], first_row,
                         chunk.chunk.horizon);
  }
  [[nodiscard]] bool row_by_row() const {
    for (std::size_t row = first_row; row < chunk.chunk.horizon; ++row)
      if (!check_absolute(view_of(row)).ok() || (row > first_row && !check_step(view_of(row)).ok()))
        return false;
    return true;
  }
  [[nodiscard]] RowView view_of(std::size_t row) const {
    const ActionPart& action = chunk.chunk.parts[0];
    return {model, limits.parts[arm].modes, state, row_of(action, row, limits),
            row > first_row ? row_of(action, row - 1, limits) : Setpoint{}};
  }

  bool whole;
  Mode mode;
  Limits limits;
  RobotModel model{limits};
  MeasuredState state = state_at_rest();
  std::size_t first_row = 0;
  ChunkBuilder chunk;
};

}  // namespace

TEST_CASE("rows in order: all at once says what row by row says, where every joint is inside") {
  Random random(20261122);
  for (const bool whole : {true, false})
    for (const Mode mode : {Mode::joint_position, Mode::joint_velocity}) {
      std::size_t in_order = 0, faults = 0, passed_over = 0;
      for (int i = 0; i < 4000; ++i) {
        const Case one(random, whole, mode);
        bool inside = true;
        for (const std::size_t j : one.limits.parts[arm].joints)
          inside = inside && std::abs(one.state.positions[j]) < 2.09;
        const bool found = one.at_once();
        in_order += found ? 1U : 0U;
        faults += found && !one.row_by_row() ? 1U : 0U;
        passed_over += !found && inside && one.row_by_row() ? 1U : 0U;
      }
      CHECK(faults == 0);
      CHECK(passed_over == 0);
      CHECK(in_order > 100);
    }
}

TEST_CASE("rows in order: every edge of targets, speeds and steps; false of all other modes") {
  const Limits limits = test_limits();
  const auto asked = [&](Mode mode, const Row& values, double measured = 0.0) {
    MeasuredState state = state_at_rest();
    state.positions[arm_1] = measured;
    const auto chunk = ChunkBuilder().joint(arm, mode, arm_1, values);
    return rows_in_order(limits, limits.parts[arm].modes, state, chunk.chunk.parts[0], 0,
                         values.size());
  };
  const auto all = [&](Mode mode, double edge, double limit) {
    for (const double sign : {1.0, -1.0}) {
      CHECK(asked(mode, {sign * (edge - limit), sign * edge}));
      CHECK_FALSE(asked(mode, {sign * (edge - limit), sign * just_above(edge)}));
      CHECK_FALSE(asked(mode, {sign * just_above(edge), sign * edge}));
      CHECK(asked(mode, {0.0, sign * limit, 0.0}));
      CHECK_FALSE(asked(mode, {0.0, sign * just_above(limit), 0.0}));
    }
    CHECK_FALSE(asked(mode, {not_a_number}));
    CHECK_FALSE(asked(mode, {0.0, not_a_number}));
  };
  all(Mode::joint_position, 2.0, 0.25);
  all(Mode::joint_velocity, 1.5, 0.5);
  const double outside = just_above(2.0 + limits.joints[arm_1].bounds.tolerance);
  CHECK_FALSE(asked(Mode::joint_position, {1.9}, outside));
  CHECK_FALSE(asked(Mode::joint_velocity, {0.0}, outside));
  const auto deltas = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.0});
  CHECK_FALSE(
      rows_in_order(limits, limits.parts[arm].modes, state_at_rest(), deltas.chunk.parts[0], 0, 1));
}
