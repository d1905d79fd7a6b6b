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
                      std::size_t certified_end = 1) {
  ChunkBuilder chunk;
  chunk.add(arm, Mode::joint_position, {{0.05, 0.0, -0.035, 0.0, 0.0, 0.0}}, {turn_z, slide_y});
  return judge_path(shared_room(), RobotModel(limits), whole_robot(limits), state, chunk.chunk,
                    {0, 1, certified_end}, {}, {});
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

TEST_CASE("G031 a forecast and what is out already are judged by all joints together") {
  const Limits limits = in_volume(false, {-1, -1, 0}, {2, turned_only - eps, 1});
  CHECK(turned_back(limits, at_rest(), 0).evidence.ok());
  MeasuredState out = at_rest();
  out.positions[slide_y] = 0.2;
  CHECK(turned_back(limits, out).evidence.ok());
}
