// A magnitude comes with its unit, whatever check found it. G024, G026 and G030 to G034: where they
// are tested; of stops the cause says it.

#include "acted_rows.hpp"
#include "core/chunk/state_check.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

Evidence judged(const ChunkBuilder& chunk) { return judge(chunk.chunk).evidence; }

Evidence of_joint(std::uint8_t part, Mode mode, std::size_t joint, const Row& values) {
  return judged(ChunkBuilder().joint(part, mode, static_cast<std::uint8_t>(joint), values));
}

// A pose at rest, but for its numbers from `first` on.
Row pose(std::size_t first, double number) {
  Row values{0.7, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0};
  values[first] = number;
  return values;
}

void check(const Evidence& evidence, std::uint32_t code, std::string_view unit) {
  CAPTURE(std::string(evidence.axis));
  CHECK(evidence.code == code);
  CHECK(evidence.has_magnitude());
  CHECK(evidence.unit == unit);
}

void check(const Verdict& verdict, std::uint32_t code, std::string_view unit) {
  CHECK(verdict.code == code);
  CHECK(verdict.unit == unit);
}

}  // namespace

TEST_CASE("G020 the unit of a row's limit is that of its mode") {
  check(of_joint(arm, Mode::joint_position, arm_1, {3.0}), 20, "rad");
  check(of_joint(arm, Mode::joint_velocity, arm_1, {3.0}), 20, "rad/s");
  check(of_joint(base, Mode::joint_velocity, base_x, {3.0}), 20, "m/s");
  check(judged(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.2})), 20, "m");
  check(judged(ChunkBuilder().along(arm, Mode::cartesian_delta, 3, {0.6})), 20, "rad");
  check(judged(ChunkBuilder().along(arm, Mode::cartesian_twist, 0, {0.6})), 20, "m/s");
  check(judged(ChunkBuilder().along(base, Mode::body_twist, 5, {2.0})), 20, "rad/s");
  check(judged(ChunkBuilder().poses(arm, {pose(0, 1.5)})), 20, "m");
  check(judged(ChunkBuilder().poses(arm, {pose(6, 0.5)})), 20, "1");
  check(judged(ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.2})), 20, "m");
  check(judged(ChunkBuilder().scalar(gripper, Mode::gripper_binary, {0.75})), 20, "1");
  check(judged(ChunkBuilder().scalar(composite, Mode::composite_mode, {1.5})), 20, "1");
}

TEST_CASE("G021 G022 the unit of a step is that of its mode") {
  check(of_joint(arm, Mode::joint_position, arm_1, {1.0}), 21, "rad");
  check(of_joint(arm, Mode::joint_velocity, arm_1, {1.0}), 21, "rad/s");
  check(judged(ChunkBuilder().along(arm, Mode::cartesian_twist, 0, {0.0, 0.0, 0.4, -0.4})), 22,
        "m/s");
  check(judged(ChunkBuilder().along(arm, Mode::cartesian_delta, 3, {0.4, -0.4})), 22, "rad");
  check(judged(ChunkBuilder().poses(arm, {pose(0, 0.8)})), 21, "m");
  check(judged(ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.04, 0.08, 0.01})), 22,
        "m");
  check(judged(ChunkBuilder().scalar(composite, Mode::composite_mode, {1.0, -1.0})), 22, "1");
}

TEST_CASE("G011 G025 the unit of a joint that is outside, or in motion") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = -2.25;
  const auto told = [&state](const ChunkBuilder& chunk) {
    return judge(chunk.chunk, state).evidence;
  };
  check(told(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {-2.5})), 11, "rad");
  check(told(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {-0.1})), 11, "rad/s");
  check(told(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.0})), 11, "rad");
  const Limits limits = test_limits();
  state.velocities[base_x] = 0.5;
  check(check_still(25, limits, state, limits.parts[base]), 25, "m/s");
  state.velocities = {};
  state.velocities[arm_2] = 0.5;
  check(check_still(25, limits, state, limits.parts[arm]), 25, "rad/s");
}

TEST_CASE("G013 G042 the unit of what is measured of a joint, also of one that nothing commands") {
  const Limits limits = test_limits();
  MeasuredState now = state_at_rest();
  now.tick += 1;
  now.positions[torso] = 0.3;
  check(check_jump(limits, state_at_rest(), now), 13, "m");
  now.positions[arm_1] = 1.0;
  check(check_jump(limits, state_at_rest(), now), 13, "rad");
  now.efforts[arm_1] = infinite;
  check(check_contact(limits, now), 42, "N m");
  now.efforts = {};
  now.efforts[base_x] = infinite;
  check(check_contact(limits, now), 42, "N");
}

TEST_CASE("G005 G006 G007 G010 G012 counts are plain numbers, ticks or rows") {
  GateRig rig(true);
  rig.ready();
  const auto spoilt = [&rig](auto spoil) {
    ChunkBuilder chunk = rig.chunk();
    spoil(chunk.chunk);
    rig.seq = 0;
    return rig.send_chunk(chunk);
  };
  check(spoilt([](ActionChunk& chunk) { chunk.seq = 5000; }), 5, "1");
  check(spoilt([](ActionChunk& chunk) { chunk.obs_tick += 2; }), 6, "ticks");
  check(spoilt([](ActionChunk& chunk) { chunk.seq = 2, chunk.oldest_tick -= 9; }), 6, "ticks");
  check(spoilt([](ActionChunk& chunk) { chunk.seq = 3, chunk.horizon = 0; }), 7, "rows");
  check(spoilt([](ActionChunk& chunk) { chunk.seq = 4, chunk.start_tick -= 9; }), 12, "ticks");
  GateRig live;
  live.ready();
  for (int i = 0; i < 7; ++i) CHECK(live.send_chunk(live.chunk()).code == 0);
  check(live.send_chunk(live.chunk()), 10, "1");
}

TEST_CASE("G008 the limit of a number that is none is alike in every unit") {
  const Limits limits = test_limits();
  const ChunkBuilder chunk = ChunkBuilder().scalar(gripper, Mode::gripper_position, {not_a_number});
  check(check_shape(limits, whole_robot(limits), chunk.chunk), 8, "1");
}
