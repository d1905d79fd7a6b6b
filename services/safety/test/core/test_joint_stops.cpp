// G031 and G032: of what brakes, each joint may stop anywhere between where it is and where it was
// declared to come to rest, whatever the others do. The free arm's tool turns about the base, 0.7 m
// from it, and slides back as far, or turns at the wrist.

#include <doctest/doctest.h>

#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr double eps = 1e-4;

// In one row to 0.05 rad and -0.035 m at 1 rad/s and 0.7 m/s, and on to 0.15 and -0.105 in a stop:
// along a chord, if both stop alike. The tool is at 0.7 sin(q) + slid cos(q) then.
Limits turning_back() {
  Limits limits = free_arm::limits();
  limits.joints[turn_z].acceleration_limit = 5.0;
  limits.joints[slide_y].acceleration_limit = 3.5;
  return limits;
}

Judgement turned_back(const Limits& limits, const MeasuredState& state = at_rest(),
                      std::size_t certified_end = 1, std::size_t queries = max_queries) {
  ChunkBuilder chunk;
  chunk.add(arm, Mode::joint_position, {{0.05, 0.0, -0.035, 0.0, 0.0, 0.0}}, {turn_z, slide_y});
  return judge_path(shared_room(), RobotModel(limits), whole_robot(limits), state, chunk.chunk,
                    {0, 1, certified_end, queries}, {}, {});
}

Limits in_volume(bool keep_out, std::array<double, 3> lower, std::array<double, 3> upper) {
  Limits limits = turning_back();
  (void)limits.workspace.volumes.push_back({"shelf", keep_out, lower, upper});
  return limits;
}

// Where the tool is if one of both joints stops at once.
const double turned_only = 0.7 * std::sin(0.15) - 0.035 * std::cos(0.15);
const double slid_only = 0.7 * std::sin(0.05) - 0.105 * std::cos(0.05);

}  // namespace

TEST_CASE("G031 a tool stays in where one of its joints stops at once") {
  const auto code = [](double lowest, double highest) {
    return turned_back(in_volume(false, {-1, lowest, 0}, {2, highest, 1})).evidence.code;
  };
  CHECK(code(slid_only - eps, turned_only + eps) == 0);
  CHECK(code(slid_only - eps, turned_only - eps) == 31);
  CHECK(code(slid_only + eps, turned_only + eps) == 31);
}

TEST_CASE("G030 wherever the looks at single stops run out, none is taken beyond") {
  const Limits limits = in_volume(false, {-1, slid_only - eps, 0}, {2, turned_only + eps, 1});
  const auto looks = [&](std::size_t most) { return turned_back(limits, at_rest(), 1, most); };
  const std::size_t all = looks(max_queries).configurations;
  CHECK(all > 8);
  for (std::size_t most = 0; most < all; ++most) {
    CAPTURE(most);
    CHECK(looks(most).configurations == most);
    CHECK(looks(most).evidence.code == 30);
  }
  CHECK(looks(all).evidence.ok());
}

TEST_CASE("G031 a tool and a capsule stay out where one joint stops at once") {
  const auto code = [](double radius, double lower, double upper) {
    Limits limits = in_volume(true, {0.4, lower, 0}, {1.0, upper, 1});
    limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, radius};
    return turned_back(limits).evidence.code;
  };
  CHECK(code(1e-6, turned_only + eps, 1) == 0);
  CHECK(code(1e-6, turned_only - eps, 1) == 31);
  CHECK(code(1e-6, -1, slid_only - eps) == 0);
  CHECK(code(1e-6, -1, slid_only + eps) == 31);
  CHECK(code(0.01, turned_only + 0.01 + eps, 1) == 0);
  CHECK(code(0.01, turned_only + 0.01 - eps, 1) == 31);
}

TEST_CASE("G032 two capsules keep their clearance where one joint stops at once") {
  const auto code = [](double y) {
    Limits limits = turning_back();
    limits.collision.clearance = 0.02;
    limits.collision.capsules[0] = {0, {0.4, y, 0.5}, {1.0, y, 0.5}, 0.01};
    limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.01};
    return turned_back(limits).evidence.code;
  };
  CHECK(code(turned_only + 0.04 + eps) == 0);
  CHECK(code(turned_only + 0.04 - eps) == 32);
  CHECK(code(slid_only - 0.04 - eps) == 0);
  CHECK(code(slid_only - 0.04 + eps) == 32);
}

TEST_CASE("G031 of what is measured to move one joint may go on for a tick, another stop at once") {
  // At 1 rad/s and -0.7 m/s, told to stop: either goes 0.05 or -0.035 on, and as far again twice.
  MeasuredState state = at_rest();
  state.velocities[turn_z] = 1.0;
  state.velocities[slide_y] = -0.7;
  const auto code = [&](double lowest, double highest) {
    const Limits limits = in_volume(false, {-1, lowest, 0}, {2, highest, 1});
    ChunkBuilder chunk;
    chunk.add(arm, Mode::joint_velocity, {{0, 0, 0, 0, 0, 0}}, {turn_z, slide_y});
    return free_arm::judge(limits, chunk.chunk, state).evidence.code;
  };
  const double turned = 0.7 * std::sin(0.15);
  CHECK(code(-0.105 - eps, turned + eps) == 0);
  CHECK(code(-0.105 - eps, turned - eps) == 31);
  CHECK(code(-0.105 + eps, turned + eps) == 31);
}

TEST_CASE("G031 a forecast is judged by all joints together; what is out may come back") {
  const Limits limits = in_volume(false, {-1, -1, 0}, {2, turned_only - eps, 1});
  CHECK(turned_back(limits, at_rest(), 0).evidence.ok());
  MeasuredState out = at_rest();
  out.positions[slide_y] = 0.2;
  CHECK(turned_back(limits, out).evidence.ok());
}

// Two slides take the tool to (0.75, 0.04), and on by up to 0.25 and 0.064 in a stop. What it comes
// nearest to is beside a side of that rectangle: all corners are clear of it, and nothing bends.
TEST_CASE("G031, G032 between the corners of where two slides may stop") {
  Limits limits = free_arm::limits();
  limits.joints[slide_x].acceleration_limit = 2.0;
  limits.joints[slide_y].acceleration_limit = 5.0;
  limits.collision.clearance = 0.02;
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.05};
  const auto code = [&](const Limits& changed) {
    ChunkBuilder chunk;
    chunk.add(arm, Mode::joint_position, {{0.0, 0.05, 0.04, 0.0, 0.0, 0.0}}, {slide_x, slide_y});
    return free_arm::judge(changed, chunk.chunk).evidence.code;
  };
  // 0.09 m from a pole where only x goes on; 0.12 are needed.
  limits.collision.capsules[0] = {0, {0.83, -0.05, 0}, {0.83, -0.05, 1}, 0.05};
  CHECK(code(limits) == 32);
  limits.collision.capsules[0] = {0, {0.83, -0.081, 0}, {0.83, -0.081, 1}, 0.05};
  CHECK(code(limits) == 0);
  limits.collision.capsules[0] = {0, {0.83, -0.0785, 0}, {0.83, -0.0785, 1}, 0.05};
  CHECK(code(limits) == 32);
  // Thin ones, wherever along the way: the nearer, the shorter is what comes too near.
  limits.collision.capsules[1].radius = 0.005;
  for (const double x : {0.78, 0.80, 0.83, 0.90, 0.95}) {
    limits.collision.capsules[0] = {0, {x, 0.0105, 0}, {x, 0.0105, 1}, 0.0052};
    CHECK(code(limits) == 32);
    limits.collision.capsules[0].radius = 0.0044;
    CHECK(code(limits) == 0);
  }
  limits.collision.capsules[1].radius = 0.05;
  // 0.039 m from a thin volume; the radius is 0.05.
  limits.collision.clearance = 0.0;
  limits.collision.capsules[0] = {0, {0, 0, 3}, {0, 0, 3}, 0.01};
  (void)limits.workspace.volumes.push_back({"pole", true, {0.83, -0.02, 0}, {0.84, 0.001, 1}});
  CHECK(code(limits) == 31);
  limits.workspace.volumes[limits.workspace.volumes.size() - 1].upper[1] = -0.011;
  CHECK(code(limits) == 0);
}

// The worst corner of one face says nothing of another's.
TEST_CASE("G031 a tool stays in by each of two faces, that different joints bring it to") {
  const auto code = [](double least_ahead, double lowest) {
    return turned_back(in_volume(false, {least_ahead, lowest, 0}, {2, 1, 1})).evidence.code;
  };
  const double least_ahead = 0.7 * std::cos(0.15) + 0.035 * std::sin(0.15);
  CHECK(code(least_ahead - eps, slid_only - eps) == 0);
  CHECK(code(least_ahead + 6e-4, slid_only - eps) == 31);
  CHECK(code(least_ahead - eps, slid_only + 6e-4) == 31);
}

// In y from 0 to -1 mm, and on to -4 in a stop; to 69 if only the turn goes on.
TEST_CASE("G031, G032 what is broken already may not get worse where one joint stops at once") {
  const auto code = [](Limits limits, bool brakes) {
    if (!brakes) limits.joints[turn_z].acceleration_limit = 1e18;
    ChunkBuilder chunk;
    chunk.add(arm, Mode::joint_position, {{0.05, 0.0, -0.036, 0.0, 0.0, 0.0}}, {turn_z, slide_y});
    return free_arm::judge(limits, chunk.chunk).evidence.code;
  };
  for (const bool brakes : {false, true}) {
    Limits rod = turning_back();
    rod.collision.clearance = 0.02;
    rod.collision.capsules[0] = {0, {0.4, 0.039, 0.5}, {1.0, 0.039, 0.5}, 0.01};
    rod.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.01};
    CHECK(code(rod, brakes) == (brakes ? 32 : 0));
    Limits kept_out = in_volume(true, {0.4, -1e-3, 0}, {1.0, 1, 1});
    CHECK(code(kept_out, brakes) == (brakes ? 31 : 0));
    kept_out.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.01};
    CHECK(code(kept_out, brakes) == (brakes ? 31 : 0));
    CHECK(code(in_volume(false, {0.5, -1, 0}, {2, -1e-3, 1}), brakes) == (brakes ? 31 : 0));
  }
}

TEST_CASE("G031, G032 either end of a capsule may be what comes near") {
  const std::array<double, 3> tip{0, 0, 0}, tail{0, -0.2, 0};
  const double ahead = 0.7 * std::cos(0.15) + 0.035 * std::sin(0.15);
  const auto kept_out = [&](bool turned, double y) {
    Limits limits = in_volume(true, {0.4, y, 0}, {1.0, 1, 1});
    limits.collision.capsules[1] = {tool_link, turned ? tail : tip, turned ? tip : tail, 0.05};
    return turned_back(limits).evidence.code;
  };
  const auto apart = [&](bool tool_turned, bool rod_turned, double y) {
    Limits limits = turning_back();
    limits.collision.clearance = 0.02;
    const std::array<double, 3> near{ahead, y, 0.5}, far{ahead, y + 0.5, 0.5};
    limits.collision.capsules[0] = {0, rod_turned ? far : near, rod_turned ? near : far, 0.01};
    limits.collision.capsules[1] = {tool_link, tool_turned ? tail : tip, tool_turned ? tip : tail,
                                    0.01};
    return turned_back(limits).evidence.code;
  };
  for (const bool turned : {false, true}) {
    CHECK(kept_out(turned, turned_only + 0.05 + eps) == 0);
    CHECK(kept_out(turned, turned_only + 0.05 - eps) == 31);
    for (const bool rod_turned : {false, true}) {
      CHECK(apart(turned, rod_turned, turned_only + 0.04 + eps) == 0);
      CHECK(apart(turned, rod_turned, turned_only + 0.04 - 6e-4) == 32);
    }
  }
}
