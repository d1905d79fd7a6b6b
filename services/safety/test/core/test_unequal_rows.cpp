// G031 and G032 where of each row another share happens: that leads beside where equal shares
// do, and limits count from there.

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "half_to_all.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;
using namespace fairlead::test::half_to_all;

namespace {

constexpr double eps = 1e-9;

// Keeps out of it, or in it.
std::uint32_t code_beside(bool keep_out, std::array<double, 3> lower, std::array<double, 3> upper,
                          const ChunkBuilder& chunk) {
  Limits limits = half_to_all::limits();
  (void)limits.workspace.volumes.push_back({"shelf", keep_out, lower, upper});
  return path_of(limits, chunk).code;
}

// Equal shares lead from (25, 25) to (50, 50) mm, others to anywhere in that square: each slide is
// 12.5 mm off at most, both together 25 mm.
const ChunkBuilder aside_then_ahead = in_turn({{slide_y, 1.0}, {slide_x, 1.0}});
constexpr double ahead = 0.75, beside = 0.025;

}  // namespace

TEST_CASE("G031 the tool stays in by what unequal shares can make of the rows") {
  const auto kept_in = [](double lower_x, double upper_x, double speed) {
    return code_beside(false, {lower_x, -1, 0}, {upper_x, 1, 1},
                       in_turn({{slide_y, speed}, {slide_x, speed}}));
  };
  CHECK(kept_in(0.0, ahead + beside + eps, 1.0) == 0);
  CHECK(kept_in(0.0, ahead + beside - eps, 1.0) == 31);
  CHECK(kept_in(0.65 - beside - eps, 1.0, -1.0) == 0);
  CHECK(kept_in(0.65 - beside + eps, 1.0, -1.0) == 31);
}

TEST_CASE("G031 tool and capsules stay out by what unequal shares can make of the rows") {
  const auto kept_out = [](double lower_x) {
    return code_beside(true, {lower_x, -1, 0}, {1.5, 1, 1}, aside_then_ahead);
  };
  CHECK(kept_out(ahead + beside + eps) == 0);
  CHECK(kept_out(ahead + beside - eps) == 31);
  // The tool's capsule: a ball of 10 mm, 10 m under it.
  const auto ball_kept_out = [](double lower_x) {
    return code_beside(true, {lower_x, -1, -10.0}, {1.5, 1, -9.0}, aside_then_ahead);
  };
  CHECK(ball_kept_out(ahead + beside + 0.01 + eps) == 0);
  CHECK(ball_kept_out(ahead + beside + 0.01 - eps) == 31);
}

TEST_CASE("G031 in the first row, and in rows alike, any share lies between equal ones") {
  const auto kept_in = [](double upper_x, const ChunkBuilder& chunk) {
    return code_beside(false, {0, -1, 0}, {upper_x, 1, 1}, chunk);
  };
  CHECK(kept_in(ahead + eps, in_turn({{slide_x, 1.0}})) == 0);
  const ChunkBuilder on = in_turn({{slide_x, 0.4}, {slide_x, 0.4}, {slide_x, 0.2}});
  CHECK(kept_in(ahead + eps, on) == 0);
  CHECK(kept_in(ahead - eps, on) == 31);
}

TEST_CASE("G031 rows alike of the robot's first joint: nothing more where there is no base") {
  const auto kept_in = [](double upper_y) {
    return code_beside(false, {0, -1, 0}, {1, upper_y, 1},
                       ChunkBuilder().add(arm, Mode::joint_velocity,
                                          {{0.5, 0, 0, 0, 0, 0}, {0.5, 0, 0, 0, 0, 0}}, {turn_z}));
  };
  const double aside = 0.7 * std::sin(0.05);
  CHECK(kept_in(aside + 1e-3) == 0);
  CHECK(kept_in(aside - 1e-3) == 31);
}

TEST_CASE("G031 a row that acts and is not measured yet has a share of its own") {
  const ChunkBuilder acts = in_turn({{slide_y, 1.0}}), next = in_turn({{slide_x, 1.0}});
  const auto code = [&](double upper_x, bool measured) {
    Limits limits = half_to_all::limits();
    (void)limits.workspace.volumes.push_back({"shelf", false, {0, -1, 0}, {upper_x, 1, 1}});
    RowBefore before{&acts.chunk, 0};
    before.measured = measured;
    return path_of(limits, next, before).code;
  };
  CHECK(code(ahead + beside + eps, false) == 0);
  CHECK(code(ahead + beside - eps, false) == 31);
  CHECK(code(ahead + eps, true) == 0);
}

TEST_CASE("G031 forecast rows go by the middle of their gains, whatever came before") {
  Limits limits = half_to_all::limits();
  (void)limits.workspace.volumes.push_back(
      {"shelf", false, {0, -1, 0}, {0.7 + 0.0375 + eps, 1, 1}});
  const RobotModel model(limits);
  const ChunkBuilder chunk = in_turn({{slide_y, 1.0}, {slide_y, -1.0}, {slide_x, 1.0}});
  PathRoom room;
  CHECK(judge_path(room, model, whole_robot(limits), at_rest(), chunk.chunk, {0, 3, 2}, {}, {})
            .row_count == 3);
  CHECK(judge_path(room, model, whole_robot(limits), at_rest(), chunk.chunk, {0, 3, 3}, {}, {})
            .row_count == 2);
}

TEST_CASE("G031 the stop behind a share counts as well") {
  // At 5 m/s2 the slide ahead brakes in 100 mm from 1 m/s, in 25 mm from half of that: it rests at
  // 50 to 150 mm, by widths of 25 mm aside and 100 mm ahead, of weights 1 and 16.
  const auto code = [](double off_by) {
    Limits limits = half_to_all::limits();
    limits.joints[slide_x].acceleration_limit = 5.0;
    (void)limits.workspace.volumes.push_back({"shelf", false, {0, -1, 0}, {0.85 + off_by, 1, 1}});
    return path_of(limits, aside_then_ahead).code;
  };
  // Where it rests: 0.025 * 16 / 17 aside and 0.1 / 17 ahead; on the way there 12.5 mm ahead.
  const double off = 0.025 * 16.0 / 17.0 + 0.0125;
  CHECK(code(off + eps) == 0);
  CHECK(code(off - eps) == 31);
}

TEST_CASE("G032 capsules keep their distance by what unequal shares can make of the rows") {
  // A ball of 50 mm stands in the tool's way, 1 m ahead of the root; the tool carries another. At
  // (50, 50) mm their middles are 0.2550 m apart.
  const auto code = [](double clearance) {
    Limits limits = half_to_all::limits();
    limits.collision.capsules[0] = {0, {1, 0, 0.5}, {1, 0, 0.5}, 0.05};
    limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.05};
    limits.collision.clearance = clearance;
    return path_of(limits, aside_then_ahead).code;
  };
  const double apart = std::hypot(0.25, 0.05) - 0.1;
  CHECK(code(apart - beside - eps) == 0);
  CHECK(code(apart - beside + eps) == 32);
}

TEST_CASE("G032 a pair far off is passed over only if it is so wherever shares lead") {
  // So small a step that the spheres about the capsules decide, but for what shares may add.
  for (const double way : {1.0, 0.02}) {
    CAPTURE(way);
    const auto code = [way](double clearance) {
      Limits limits = half_to_all::limits();
      limits.collision.capsules[0] = {0, {1, 0, 0.5}, {1, 0, 0.5}, 0.05};
      limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.05};
      limits.collision.clearance = clearance;
      return path_of(limits, in_turn({{slide_y, way}, {slide_x, way}})).code;
    };
    const double apart = std::hypot(0.3 - 0.05 * way, 0.05 * way) - 0.1;
    CHECK(code(apart - way * beside - eps) == 0);
    CHECK(code(apart - way * beside + eps) == 32);
  }
}

TEST_CASE("G031 switch up: what is left of a row is a part of the next") {
  // The tool swings by 0.05 rad and back, from (0.7, 0). With the switch down other shares leave
  // the joint 25 mrad off; up, the upper end leaves nothing and the lower one half: 12.5 mrad.
  const auto kept_in = [](double value, double upper_x) {
    Limits limits = test_limits();
    limits.parts[arm].modes.cartesian_delta.gain = {0.5, 1.0};
    limits.parts[composite].modes.composite_mode.step_limit = 2.0;
    (void)limits.workspace.volumes.push_back({"shelf", false, {-1, -1, -1}, {upper_x, 1, 1}});
    const Row turn{0, 0.035, 0, 0, 0, 0.05}, back{0, -0.035, 0, 0, 0, -0.05};
    ChunkBuilder chunk;
    chunk.add(arm, Mode::cartesian_delta, {turn, back}, {}, "base_link");
    chunk.scalar(composite, Mode::composite_mode, {value, value});
    PartMemories memories;
    memories[arm].goal = Pose{Eigen::Matrix3d::Identity(), {0.7, 0, 0.5}};
    RowBefore before;
    before.memories = &memories;
    const RobotModel model(limits);
    return judge_path(model, whole_robot(limits), state_at_rest(), chunk.chunk, 0, 2, before, {})
        .evidence.code;
  };
  CHECK(kept_in(-1.0, 0.7 + 0.013) == 31);
  CHECK(kept_in(1.0, 0.7 + 0.013) == 0);
  CHECK(kept_in(1.0, 0.7 + 0.007) == 31);
}

TEST_CASE("G031 a joint that goes faster than told may go on, or as told: each has its stop") {
  // Ahead it is told 0.6 m/s and measured at 1 m/s, of which it brakes in 0.1 m at 5 m/s2; as told
  // in 9 to 36 mm. Its way is 15 to 30 mm, and aside 25 to 50 mm by the row that acts.
  const auto code = [](double off) {
    Limits limits = half_to_all::limits();
    limits.joints[slide_x].acceleration_limit = 5.0;
    (void)limits.workspace.volumes.push_back({"shelf", false, {0, -1, 0}, {0.83 + off, 1, 1}});
    const ChunkBuilder acts = in_turn({{slide_y, 1.0}}), next = in_turn({{slide_x, 0.6}});
    RowBefore before{&acts.chunk, 0};
    before.measured = false;
    MeasuredState state = at_rest();
    state.velocities[slide_x] = 1.0;
    const RobotModel model(limits);
    return judge_path(model, whole_robot(limits), state, next.chunk, 0, 1, before, {})
        .evidence.code;
  };
  const auto off = [](double x) {  // of widths of 25 mm aside, and that
    const double y = 0.025, square = x * x + y * y;
    return std::array{x * y * y / square, y * x * x / square};
  };
  const std::array on_the_way = off(0.015), told = off(0.015 + 0.027);
  const double most = std::max(on_the_way[0], told[0]) + std::max(on_the_way[1], told[1]);
  CHECK(code(most + eps) == 0);
  CHECK(code(most - eps) == 31);
}

TEST_CASE("G031 so may the robot's first joint alone: each of its stops counts") {
  // Ahead it has 25 to 50 mm by the row that acts. It is told 0.6 rad/s about z and measured at
  // 1 rad/s, of which it brakes in 0.1 rad at 5 rad/s2; as told in 9 to 36 mrad.
  const auto code = [](double upper_y) {
    Limits limits = half_to_all::limits();
    limits.joints[turn_z].acceleration_limit = 5.0;
    (void)limits.workspace.volumes.push_back({"shelf", false, {0, -1, 0}, {1, upper_y, 1}});
    const auto row = [](std::uint8_t joint, double speed) {
      Row values(joint_count, 0.0);
      values[joint] = speed;
      return ChunkBuilder().add(arm, Mode::joint_velocity, {values}, {turn_z, slide_x});
    };
    const ChunkBuilder acts = row(slide_x, 1.0), next = row(turn_z, 0.6);
    RowBefore before{&acts.chunk, 0};
    before.measured = false;
    MeasuredState state = at_rest();
    state.velocities[turn_z] = 1.0;
    const RobotModel model(limits);
    return judge_path(model, whole_robot(limits), state, next.chunk, 0, 1, before, {})
        .evidence.code;
  };
  CHECK(code(0.196) == 0);
  CHECK(code(0.194) == 31);  // its stop from 1 rad/s alone would leave it at 0.183
}
