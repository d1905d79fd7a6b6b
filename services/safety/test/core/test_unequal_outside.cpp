// G031 and G032 outside what they keep to, where of each row another share happens: a row is
// compared with where the rows before can have led.

#include <doctest/doctest.h>

#include "half_to_all.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;
using namespace fairlead::test::half_to_all;

TEST_CASE("G031 outside, rows that leave in turn have to mend more than may be lost") {
  // The tool is 0.1 m outside. The second row takes it back by 25 to 50 mm.
  const auto code = [](double aside) {
    Limits limits = half_to_all::limits();
    (void)limits.workspace.volumes.push_back({"shelf", false, {0, -1, 0}, {0.6, 1, 1}});
    const ChunkBuilder chunk =
        ChunkBuilder().add(arm, Mode::joint_velocity,
                           {{0, -1e-3, 0, 0, 0, 0}, {0, -1.0, aside, 0, 0, 0}}, {slide_x, slide_y});
    return path_of(limits, chunk).code;
  };
  CHECK(code(0.0) == 0);
  CHECK(code(0.2) == 0);
  CHECK(code(3.0) == 0);
  const auto across = [](double back) {
    Limits limits = half_to_all::limits();
    (void)limits.workspace.volumes.push_back({"shelf", false, {0, -1, 0}, {0.6, 1, 1}});
    const ChunkBuilder chunk =
        ChunkBuilder().add(arm, Mode::joint_velocity,
                           {{0, -1e-3, 0, 0, 0, 0}, {0, back, 1.0, 0, 0, 0}}, {slide_x, slide_y});
    return path_of(limits, chunk).code;
  };
  CHECK(across(-1e-3) == 31);
  CHECK(across(-0.5) == 0);
}

namespace {

// Two rows lead back, and the second aside as well: shares between them lead 1.4 mm apart. Of the
// last little happens.
Evidence outside(Limits limits, double back, double last) {
  return path_of(
      limits,
      ChunkBuilder().add(arm, Mode::joint_velocity,
                         {{0, back, 0, 0, 0, 0}, {0, back, 0.1, 0, 0, 0}, {0, last, 0, 0, 0, 0}},
                         {slide_x, slide_y}));
}

void check_last_row(const Limits& limits, double back) {
  CHECK(outside(limits, 0.6 * back, 0.02 * back).ok());
  CHECK(outside(limits, 0.6 * back, -0.02 * back).row == 2);
}

}  // namespace

TEST_CASE("G031 outside its volume a tool is compared with where shares had led it before") {
  for (const bool is_ahead : {true, false}) {
    Limits limits = half_to_all::limits();
    if (is_ahead)
      (void)limits.workspace.volumes.push_back({"shelf", false, {0, -1, 0}, {0.6, 1, 1}});
    else
      (void)limits.workspace.volumes.push_back({"shelf", false, {0.8, -1, 0}, {2, 1, 1}});
    check_last_row(limits, is_ahead ? -1.0 : 1.0);
  }
}

TEST_CASE("G031 outside, forecast rows are compared with forecast ones, whose shares are certain") {
  Limits limits = half_to_all::limits();
  (void)limits.workspace.volumes.push_back({"shelf", false, {0, -1, 0}, {0.6, 1, 1}});
  const RobotModel model(limits);
  const auto rows = [&](double last) {
    const ChunkBuilder chunk = ChunkBuilder().add(arm, Mode::joint_velocity,
                                                  {{0, -0.6, 0, 0, 0, 0},
                                                   {0, -0.6, 0.1, 0, 0, 0},
                                                   {0, -0.02, 0, 0, 0, 0},
                                                   {0, last, 0, 0, 0, 0}},
                                                  {slide_x, slide_y});
    PathRoom room;
    return judge_path(room, model, whole_robot(limits), at_rest(), chunk.chunk, {0, 4, 2}, {}, {})
        .row_count;
  };
  CHECK(rows(-0.02) == 4);
  CHECK(rows(0.02) == 3);
}

TEST_CASE("G031 G032 within what it keeps out of a capsule is compared so as well") {
  Limits limits = half_to_all::limits();
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.2};
  SUBCASE("of a volume") {
    (void)limits.workspace.volumes.push_back({"wall", true, {0.75, -1, 0}, {2, 1, 1}});
  }
  SUBCASE("of another capsule") {
    limits.collision.capsules[0] = {0, {1, 0, 0.5}, {1, 0, 0.5}, 0.05};
    limits.collision.clearance = 0.4;
  }
  check_last_row(limits, -1.0);
}
