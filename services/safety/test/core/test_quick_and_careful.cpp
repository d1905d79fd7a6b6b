// What the quick look finds certain, the careful look finds without fault: random rows, measured
// joints and rows before, all of them mostly at the edge of what they may be.

#include <doctest/doctest.h>

#include <random>

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "core/modes/mode_table.hpp"
#include "core/modes/quick_look.hpp"

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
      : whole(whole_robot), mode(which), limits(robot(whole_robot)), plan(limits) {
    const double place = one_of(random, {0.0, 1.8, 1.9, 2.0});
    measure(random, place);
    fill(random, place, chunk, 1 + random() % 4);
    fill(random, place, acted, 1);
    if (random() % 2 == 0) before.chunk = &acted.chunk;
    if (random() % 2 == 0) before.memories = &memories;
    before.measured = random() % 2 == 0;
    if (random() % 2 == 0) memories[arm].note(acted.chunk.parts[0]);
    if (random() % 8 == 0) memories[arm].mode = static_cast<std::uint8_t>(Mode::cartesian_delta);
    if (random() % 8 == 0) acted.chunk.parts[0].frame_id = "elsewhere";
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

  [[nodiscard]] Certain quick() const {
    return look_quickly(plan, limits.parts[arm].modes, state, chunk.chunk.parts[0], 0,
                        chunk.chunk.horizon, before);
  }
  [[nodiscard]] bool rows_in_order() const {
    for (std::size_t row = 0; row < chunk.chunk.horizon; ++row)
      if (!check_absolute(view_of(row)).ok() || (row > 0 && !check_step(view_of(row)).ok()))
        return false;
    return true;
  }
  [[nodiscard]] bool starts() const {
    return check_start(view_of(0), whole_robot(limits), before).ok();
  }
  [[nodiscard]] RowView view_of(std::size_t row) const {
    const ActionPart& action = chunk.chunk.parts[0];
    return {limits, limits.parts[arm].modes, state, row_of(action, row, limits),
            row > 0 ? row_of(action, row - 1, limits) : Setpoint{}};
  }

  bool whole;
  Mode mode;
  Limits limits;
  PathPlan plan;
  MeasuredState state = state_at_rest();
  ChunkBuilder chunk, acted;
  PartMemories memories;
  RowBefore before;
};

}  // namespace

TEST_CASE("quick look: what it is certain of is without fault, and it is certain of much") {
  Random random(20261122);
  for (const bool whole : {true, false})
    for (const Mode mode : {Mode::joint_position, Mode::joint_velocity}) {
      std::size_t in_order = 0, starts = 0, faults = 0;
      for (int i = 0; i < 2000; ++i) {
        const Case one(random, whole, mode);
        const Certain found = one.quick();
        if (found != Certain::nothing) ++in_order;
        if (found == Certain::starts) ++starts;
        if (found != Certain::nothing && !one.rows_in_order()) ++faults;
        if (found == Certain::starts && !one.starts()) ++faults;
      }
      CHECK(faults == 0);
      CHECK(in_order > 100);
      CHECK((starts > 20) == (mode == Mode::joint_position));
    }
}
