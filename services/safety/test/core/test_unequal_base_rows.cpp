// G034 where of each row another share happens: the base ends beside where equal shares lead.

#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "chunk_builder.hpp"
#include "predicted.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// Of two rows of 25 to 50 mm, one aside and one ahead, each slide is 12.5 mm off at most.
constexpr double beside = 0.025;

// Half to all of what a base of 0.2 m is told, in a room that ends ahead.
Limits walled_at(double ahead) {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_velocity.gain = {0.5, 1.0};
  limits.base.reaction_s = 1e-9;
  limits.base.footprint = square(0.1);
  Zone room{"room", false, square(5.0)};
  room.corners[1][0] = room.corners[2][0] = ahead;
  (void)limits.base.zones.push_back(room);
  return limits;
}

}  // namespace

TEST_CASE("G034 a base keeps to its zones by what unequal shares can make of the rows") {
  const auto code = [](double wall) {
    const Limits limits = walled_at(0.1 + wall);
    Row aside(joint_count, 0.0), forward(joint_count, 0.0);
    aside[base_y] = forward[base_x] = 1.0;
    ChunkBuilder chunk;
    chunk.add(base, Mode::joint_velocity, {aside, forward}, {base_x, base_y});
    return judge_rows(limits, whole_robot(limits), state_at_rest(), chunk.chunk, 0, {})
        .evidence.code;
  };
  CHECK(code(0.05 + beside + 1e-6) == 0);
  CHECK(code(0.05 + beside - 1e-6) == 34);
}

TEST_CASE("G034 outside a zone a base is compared with where shares had led it before") {
  const auto judged = [](double last) {
    const Limits limits = walled_at(0.0);  // 0.1 m outside
    Row back(joint_count, 0.0), aside(joint_count, 0.0), end(joint_count, 0.0);
    back[base_x] = aside[base_x] = -0.6;
    aside[base_y] = 0.1;
    end[base_x] = last;
    ChunkBuilder chunk;
    chunk.add(base, Mode::joint_velocity, {back, aside, end}, {base_x, base_y});
    return judge_rows(limits, whole_robot(limits), state_at_rest(), chunk.chunk, 0, {}).evidence;
  };
  CHECK(judged(-0.02).ok());
  CHECK(judged(0.02).code == 34);
  CHECK(judged(0.02).row == 2);
}

TEST_CASE(
    "G034 an arm whose rows go on with the switch up takes nothing off what a base is off by") {
  const auto first_wall = [](bool with_arm) {
    Limits limits = test_limits();
    limits.parts[base].modes.joint_velocity.gain = {0.5, 1.0};
    limits.parts[composite].modes.composite_mode.step_limit = 2.0;
    for (const std::size_t j : {base_x, base_y}) limits.joints[j].acceleration_limit = 5.0;
    limits.base.footprint = square(0.1);
    Row aside(joint_count, 0.0), forward(joint_count, 0.0);
    aside[base_y] = forward[base_x] = 1.0;
    ChunkBuilder chunk;
    chunk.add(base, Mode::joint_velocity, {aside, forward}, {base_x, base_y});
    const Row still(6, 0.0);
    if (with_arm) chunk.add(arm, Mode::cartesian_delta, {still, still}, {}, "base_link");
    if (with_arm) chunk.scalar(composite, Mode::composite_mode, {1.0, 1.0});
    PartMemories memories;
    memories[arm].goal = Pose{Eigen::Matrix3d::Identity(), {0.7, 0, 0.5}};
    RowBefore before;
    before.memories = &memories;
    double fails = 0.0, passes = 1.0;
    while (passes - fails > 1e-7) {
      const double wall = 0.5 * (fails + passes);
      Limits walled = limits;
      Zone room{"room", false, square(5.0)};
      room.corners[1][0] = room.corners[2][0] = 0.1 + wall;
      (void)walled.base.zones.push_back(room);
      const std::uint32_t code =
          judge_rows(walled, whole_robot(walled), state_at_rest(), chunk.chunk, 0, before)
              .evidence.code;
      (code == 0 ? passes : fails) = wall;
    }
    return passes;
  };
  CHECK(first_wall(false) > 0.1);  // where it stops
  CHECK(std::abs(first_wall(true) - first_wall(false)) < 1e-6);
}

TEST_CASE("G034 forecast rows go by the middle of their gains, whatever came before") {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_velocity.gain = {0.5, 1.0};
  limits.base.reaction_s = 1e-9;
  limits.base.footprint = square(0.1);
  Zone room{"room", false, square(5.0)};
  room.corners[1][0] = room.corners[2][0] = 0.1 + 0.0375 + 1e-6;
  (void)limits.base.zones.push_back(room);
  const RobotModel model(limits);
  Rows rows(3, Row(joint_count, 0.0));
  rows[0][base_y] = rows[2][base_x] = 1.0;
  rows[1][base_y] = -1.0;
  ChunkBuilder chunk;
  chunk.add(base, Mode::joint_velocity, rows, {base_x, base_y});
  const auto passing = [&](std::size_t certified_end) {
    return judge_path(shared_room(), model, whole_robot(limits), state_at_rest(), chunk.chunk,
                      {0, 3, certified_end}, {}, {})
        .row_count;
  };
  CHECK(passing(2) == 3);
  CHECK(passing(3) == 2);
}

TEST_CASE("G034 a base that shares may have turned goes ahead another way") {
  const auto code = [](double wall) {
    Limits limits = test_limits();
    limits.parts[base].modes.body_twist.gain = {0.0, 1.0};
    limits.base.reaction_s = 1e-9;
    limits.base.yaw_axis = {0.0, 0.0};
    limits.base.footprint = square(1e-9);
    Zone room{"room", false, square(5.0)};
    room.corners[2][1] = room.corners[3][1] = wall;
    (void)limits.base.zones.push_back(room);
    Row turn(6, 0.0), forward(6, 0.0);
    turn[5] = forward[0] = 1.0;
    ChunkBuilder chunk;
    chunk.add(base, Mode::body_twist, {turn, forward}, {}, "base_link");
    const RobotModel model(limits);
    return judge_path(model, whole_robot(limits), state_at_rest(), chunk.chunk, 0, 2, {}, {})
        .evidence.code;
  };
  // By up to 0.05 rad, then 0.05 m that way: weights of what the turn and the way add up to.
  const double x = 0.05 * std::cos(0.05), y = 0.05 * std::sin(0.05);
  const double turned = 0.05 * 0.05 / (0.05 * 0.05 + x * x + y * y);
  const double other_way = 2.0 * 0.05 * 0.05;  // of either slide
  const double off = y + turned * (x + y) + other_way;
  CHECK(code(off + 1e-6) == 0);
  CHECK(code(off - 1e-6) == 34);
}

TEST_CASE("G034 in the first row a base that turns and drives stops where its shares do") {
  const auto code = [](double wall) {
    Limits limits = test_limits();
    limits.parts[base].modes.body_twist.gain = {0.0, 1.0};
    for (const std::size_t j : {base_x, base_y}) limits.joints[j].acceleration_limit = 5.0;
    limits.base.reaction_s = 1e-9;
    limits.base.yaw_axis = {0.0, 0.0};
    limits.base.footprint = square(1e-9);
    Zone room{"room", false, square(5.0)};
    room.corners[2][1] = room.corners[3][1] = wall;
    (void)limits.base.zones.push_back(room);
    Row twist(6, 0.0);
    twist[5] = twist[0] = 1.0;
    ChunkBuilder chunk;
    chunk.add(base, Mode::body_twist, {twist}, {}, "base_link");
    return judge_rows(limits, whole_robot(limits), state_at_rest(), chunk.chunk, 0, {})
        .evidence.code;
  };
  // 0.05 m by the yaw half way, 0.025 rad, and braking from what of its speed that is.
  const double aside = 0.05 * std::sin(0.025), speed = std::sin(0.025);
  const double rests = aside + speed * speed / 10.0;
  CHECK(code(rests + 2e-6) == 0);
  CHECK(code(rests - 2e-6) == 34);
}

namespace {

// It turned at 1.5 rad/s when it was measured. Realtime: it holds in the tick that runs, so it is
// 75 mrad on when that ends, or not. Left alone it takes 0.45 rad to rest.
struct Turning {
  explicit Turning(double turning, bool is_left_alone) : state(state_at_rest()) {
    state.velocities[base_yaw] = turning;
    memories[base].kind = MovingMode::Kind::known;
    memories[base].mode = static_cast<std::uint8_t>(Mode::joint_velocity);
    before = {nullptr, 0, is_left_alone, &memories};
    limits.parts[base].modes.joint_velocity.gain = {1.0, 1.0};
    limits.base.against_yaw = true;
    limits.base.reaction_s = 1e-9;
    limits.base.footprint = square(0.1);
    limits.joints[base_x].acceleration_limit = 1e18;
    limits.joints[base_yaw].acceleration_limit = is_left_alone ? 2.5 : 1e18;
    limits.joints[base_yaw].velocity_limit = 100.0;  // its share is not the largest
  }
  // Along one of its slides at so many metres a second, without a turn.
  ChunkBuilder driven(double speed, std::size_t rows, std::size_t along = base_x) const {
    Row row(joint_count, 0.0);
    row[along] = speed;
    ChunkBuilder chunk;
    if (before.measured)
      chunk.add(base, Mode::joint_velocity, Rows(rows, row), {base_x, base_y});
    else
      chunk.add(base, Mode::joint_velocity, Rows(rows, row), {base_x, base_y, base_yaw});
    return chunk;
  }
  // The least room that lets it, to its left, or ahead if it drives aside.
  double room(double speed, std::size_t rows, std::size_t along = base_x) const {
    const ChunkBuilder chunk = driven(speed, rows, along);
    const std::size_t across = along == base_x ? base_y : base_x;
    double least = 0.1, most = 1.0;  // inside, where it is
    while (most - least > 1e-9) {
      const double wall = 0.5 * (least + most);
      Limits walled = limits;
      Zone zone{"room", false, square(5.0)};
      for (const std::size_t corner : across == base_y ? std::array{2U, 3U} : std::array{1U, 2U})
        zone.corners[corner][across] = state.positions[across] + wall;
      (void)walled.base.zones.push_back(zone);
      const auto judged = judge_rows(walled, whole_robot(walled), state, chunk.chunk, 0, before);
      (judged.evidence.ok() ? most : least) = wall;
    }
    return most;
  }
  Limits limits = test_limits();
  MeasuredState state;
  PartMemories memories;
  RowBefore before;
};

}  // namespace

TEST_CASE("a slide counts as fast as any yaw makes it that nobody commands, or that was held") {
  for (const bool is_left_alone : {false, true})
    for (const double turning : {1.5, -1.5, 0.0}) {
      Turning base(turning, is_left_alone);
      base.state.positions[base_yaw] = 0.7;
      const ChunkBuilder chunk = base.driven(0.9, 2);
      Predicted predicted(base.limits, base.state, chunk.chunk, base.before);
      const double aside = std::abs(turning) * (is_left_alone ? 0.3 : 0.025);
      for (int row = 0; row < 2; ++row) {
        (void)predicted.after_a_row();
        CHECK(predicted.all.turn_off() == doctest::Approx(aside));
        const Branch& branch = predicted.all.branch(0);
        for (const std::size_t slide : {base_x, base_y}) {
          const double fastest = std::abs(branch.speed[slide]) + aside * 0.9;
          CHECK(predicted.all.base_speed() >= doctest::Approx(fastest / 1.5));
        }
        CHECK(predicted.all.base_speed() <= 0.9 * (1.0 + aside) / 1.5 + 1e-9);
      }
    }
}

TEST_CASE("G034 a base is beside its way by as much as a held tick may have turned it") {
  // To its right by 1.5 rad/s: what it is told goes to its left by 75 mrad of the way at most.
  const Turning base(-1.5, false);
  const double beside = std::sin(0.075) * 0.05 * 8.0, more = base.room(1.0, 16) - base.room(1.0, 8);
  CHECK(more >= beside);
  CHECK(more <= 1.6 * beside);
}

TEST_CASE("G034 it is so wherever the base is, and whichever way it drives") {
  const double here = Turning(-1.5, false).room(1.0, 16);
  // Half the turn is predicted, of the footprint and of the way; the other half may be beside it.
  const double half = 0.0375, turned = 0.1 * (std::cos(half) + std::sin(half));
  const double beside = 2.0 * 0.8 * half + std::hypot(0.1, 0.1) * half;
  CHECK(here == doctest::Approx(turned + 0.8 * std::sin(half) + beside).epsilon(1e-5));
  Turning away(-1.5, false);
  away.state.positions[base_x] = 2.0;
  away.state.positions[base_y] = -3.0;
  CHECK(away.room(1.0, 16) == doctest::Approx(here).epsilon(1e-6));
  Turning aside(1.5, false);
  aside.state.positions[base_x] = -3.0;
  aside.limits.joints[base_y].acceleration_limit = 1e18;
  CHECK(aside.room(1.0, 16, base_y) == doctest::Approx(here).epsilon(1e-6));
}
