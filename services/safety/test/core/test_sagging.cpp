// A limit that is found broken: a row may leave it as it is, and the next one no worse than that,
// however far the robot has sagged meanwhile.

#include <doctest/doctest.h>

#include "core/chunk/judgement.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

// A ball of 30 mm on the tool, whose lowest point is 0.1 mm in a table when `slide_z` is at -20.1
// mm.
constexpr double broken = -0.0201;

Limits above_table() {
  Limits limits = free_arm::limits();
  (void)limits.workspace.volumes.push_back({"table", true, {-2, -2, -1}, {2, 2, 0.45}});
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.03};
  return limits;
}

Limits tool_above(bool keep_out) {
  Limits limits = free_arm::limits();
  const double edge = 0.5 + broken + 0.0001;
  if (keep_out)
    (void)limits.workspace.volumes.push_back({"table", true, {-2, -2, -1}, {2, 2, edge}});
  else
    (void)limits.workspace.volumes.push_back({"box", false, {-2, -2, edge}, {2, 2, 2}});
  return limits;
}

// Measured at `measured` [m], told `last` in the row before, and `next` in this one.
std::uint32_t found_code(const Limits& limits, double measured, double last, double next,
                         Mode mode = Mode::joint_position) {
  MeasuredState state = at_rest();
  state.positions[slide_z] = measured;
  ChunkBuilder acted = one_joint(mode, slide_z, {last});
  const RowBefore before{&acted.chunk, 0};
  return free_arm::judge(limits, one_joint(mode, slide_z, {next}).chunk, state, before)
      .evidence.code;
}

}  // namespace

TEST_CASE("G031 an arm that sags, told each time to be where it is, does not sink") {
  for (const Limits& limits : {above_table(), tool_above(true), tool_above(false)}) {
    CHECK(found_code(limits, broken, broken, broken) == 0);
    CHECK(found_code(limits, broken - 0.0005, broken, broken - 0.0005) == 31);
    // Nor told to be half of its sag better. Where it was told to be before, or better than that:
    CHECK(found_code(limits, broken - 0.0005, broken, broken - 0.00025) == 31);
    CHECK(found_code(limits, broken - 0.0005, broken, broken) == 0);
    CHECK(found_code(limits, broken - 0.0005, broken, 0.0) == 0);
    // Told to be in there before, by whatever did: it may stay where it is.
    CHECK(found_code(limits, broken, broken - 0.0005, broken) == 0);
    CHECK(found_code(limits, broken, broken - 0.0005, broken - 0.0005) == 31);
  }
}

TEST_CASE("G031 of a row before that told no target nothing is known but what is measured") {
  CHECK(found_code(above_table(), broken - 0.0005, 0.0, 0.0, Mode::joint_velocity) == 0);
  MeasuredState state = at_rest();
  state.positions[slide_z] = broken;
  CHECK(free_arm::judge(above_table(), one_joint(Mode::joint_position, slide_z, {broken}).chunk,
                        state)
            .evidence.ok());
}

TEST_CASE("G031 the second row of a chunk counts from the first") {
  MeasuredState state = at_rest();
  state.positions[slide_z] = broken - 0.0005;
  ChunkBuilder acted = one_joint(Mode::joint_position, slide_z, {broken});
  const RowBefore before{&acted.chunk, 0};
  const auto rows = [&](double second) {
    return free_arm::judge(above_table(),
                           one_joint(Mode::joint_position, slide_z, {broken, second}).chunk, state,
                           before)
        .row_count;
  };
  CHECK(rows(broken) == 2);
  CHECK(rows(broken - 0.00005) == 1);
}
