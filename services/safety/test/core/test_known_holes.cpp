// Holes that earlier gates had, each shut here by name.

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

Verdict judged(const ChunkBuilder& commands) {
  GateRig rig;
  rig.ready();
  ChunkBuilder chunk = rig.chunk();
  chunk.chunk.parts = commands.chunk.parts;
  chunk.chunk.horizon = commands.chunk.horizon;
  const Verdict verdict = rig.send_chunk(chunk);
  CHECK(rig.count(OutputKind::safe_chunk) ==
        (verdict.outcome == static_cast<std::uint8_t>(Outcome::refused) ? 0U : 1U));
  return verdict;
}

}  // namespace

TEST_CASE("hole: a 6-wide twist chunk read with the robot's dof as row stride") {
  // With any other stride row 3 would be looked for elsewhere, or beyond the block.
  const Verdict verdict =
      judged(ChunkBuilder().along(base, Mode::body_twist, 0, {0.1, 0.1, 0.1, 5.0}));
  CHECK(verdict.outcome == static_cast<std::uint8_t>(Outcome::truncated));
  CHECK(verdict.code == 20);
  CHECK(verdict.row == 3);
  CHECK(verdict.value == 5.0);
  // Fewer columns than the robot has joints, and more.
  CHECK(judged(ChunkBuilder().add(base, Mode::body_twist, {Row(joint_count + 1, 0.0)}, {},
                                  "base_link"))
            .code == 7);
}

TEST_CASE("hole: bounds checked on row 0 only") {
  for (std::size_t bad = 2; bad < 8; ++bad) {
    Row rows(8, 0.1);
    rows[bad] = 1.6;
    const Verdict verdict =
        judged(ChunkBuilder().joint(base, Mode::joint_velocity, base_yaw, rows));
    CHECK(verdict.code == 20);
    CHECK(verdict.row == static_cast<std::int64_t>(bad));
  }
}

TEST_CASE("hole: a joint jump from 0 to the far end of its range in one step") {
  CHECK(judged(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, 1.9, 1.9})).code == 21);
  CHECK(judged(ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {0.0, 0.0, 1.9})).code == 22);
}

TEST_CASE("hole: an all-zero joint chunk without a mask commands 0 rad") {
  CHECK(
      judged(ChunkBuilder().add(arm, Mode::joint_position, Rows(2, Row(joint_count, 0.0)))).code ==
      9);
}

TEST_CASE("hole: slots of one tick judged apart, so that siblings of a refused slot still move") {
  ChunkBuilder both;
  both.joint(base, Mode::joint_velocity, base_x, {0.1, 0.1, 0.1, 0.1});
  both.scalar(gripper, Mode::gripper_position, {0.04, 5.0, 5.0, 5.0});
  CHECK(judged(both).outcome == static_cast<std::uint8_t>(Outcome::refused));

  ChunkBuilder later;
  later.joint(base, Mode::joint_velocity, base_x, {0.1, 0.1, 0.1, 0.1});
  later.scalar(gripper, Mode::gripper_position, {0.04, 0.04, 0.04, 5.0});
  const Verdict verdict = judged(later);
  CHECK(verdict.outcome == static_cast<std::uint8_t>(Outcome::truncated));
  CHECK(verdict.released_last - verdict.released_first + 1 == 2);  // rows 1 and 2, for both parts
}

TEST_CASE("hole: a cartesian delta of 5 m, a twist of 5 m/s, gripper 5.0, composite 5.0") {
  CHECK(judged(ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {5.0, 5.0})).code == 20);
  CHECK(judged(ChunkBuilder().along(base, Mode::body_twist, 0, {5.0, 5.0})).code == 20);
  CHECK(judged(ChunkBuilder().scalar(gripper, Mode::gripper_position, {5.0, 5.0})).code == 20);
  CHECK(judged(ChunkBuilder().scalar(composite, Mode::composite_mode, {5.0, 5.0})).code == 20);
}

TEST_CASE("hole: a NaN joint state hides what it should show") {
  GateRig rig;
  rig.ready();
  rig.positions[arm_1] = not_a_number;
  rig.next_tick();
  CHECK(rig.gate->state() == GateState::stopped);
  CHECK(rig.lease().grants.empty());
}

TEST_CASE("hole: a latch cleared by a restart") {
  GateRig rig;
  rig.restart(BootInfo{false, false, {}});
  const auto record = frame_of(rig.get<LatchRecord>(OutputKind::persist_latch));
  const std::uint64_t id = rig.status().latch_id;
  for (int i = 0; i < 3; ++i) {
    rig.restart(BootInfo{false, true, record});
    CHECK(rig.gate->state() == GateState::latched);
    CHECK(rig.status().latch_id == id);
  }
}

TEST_CASE("hole: a stop lost by who joins late") {
  GateRig rig;
  rig.ready();
  rig.send(EventKind::stop_level, StopLevel{77, "operator", ""});
  // Every lease lists it for as long as it is held, and so does the status.
  for (int i = 0; i < 5; ++i) {
    rig.timer(25 * ms);
    CHECK(rig.lease().stop_ids.contains(77));
  }
  CHECK(rig.status().stop_ids.contains(77));
  // A gate that was not there yet takes it from the repeats of whoever raised it.
  rig.restart(BootInfo{false, true, {}});
  rig.send(EventKind::stop_level, StopLevel{77, "operator", ""});
  CHECK(rig.gate->state() == GateState::stopped);
}

TEST_CASE("hole: limits that default to infinity") {
  Limits limits = test_limits();
  limits.parts[arm].modes.cartesian_delta.linear_limit = CartesianLimits{}.linear_limit;
  CHECK(check_limits(limits) ==
        "parts.arm.modes.cartesian_delta.linear_limit: expected a finite number above 0, got nan");
  // And should it get past that, it refuses.
  const ChunkBuilder tiny = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.0});
  CHECK(judge_rows(limits, whole_robot(limits), state_at_rest(), tiny.chunk, 0, {}).outcome ==
        Outcome::refused);
}

TEST_CASE("hole: rows resumed in mid-chunk after a gap") {
  GateRig rig;
  rig.ready();
  ChunkBuilder chunk = rig.chunk();
  chunk.chunk.parts.clear();
  Row ramp;
  for (int i = 0; i < 10; ++i) ramp.push_back(0.2 * i);
  chunk.joint(arm, Mode::joint_position, arm_1, ramp);
  CHECK(rig.send_chunk(chunk).code == 0);
  for (int i = 0; i < 6; ++i) {
    rig.next_tick(Acted{4, 0, 0});  // held all the while: the arm is still at 0
    CHECK(rig.count(OutputKind::safe_chunk) == (i == 0 ? 1U : 0U));
  }
  CHECK(rig.counter("G021") == 1);  // judged once more, from 0, and refused for good
}
