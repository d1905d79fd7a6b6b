// G025: a part changes its mode or frame at standstill only, whatever held or moved beside it.

#include "acted_rows.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted hold{2, 0, 0};

// A base that is told 0.5 m/s at tick 100 and does it, armed and claimed, in either pacing.
struct MovingBase : GateRig {
  SafeChunk safe;
  std::uint64_t lead;  // ticks from the newest state to the first row

  explicit MovingBase(bool in_lockstep) : GateRig(in_lockstep), lead(in_lockstep ? 0 : 1) {
    ready();
    const Verdict verdict = send_chunk(speeds({0.5}));
    REQUIRE(verdict.code == 0);
    safe = safe_chunk();
  }
  ChunkBuilder speeds(const Row& values) {
    ChunkBuilder builder = chunk(values);
    builder.chunk.start_tick += lead;
    return builder;
  }
  ChunkBuilder twist() {
    ChunkBuilder builder = speeds({0.0});
    builder.chunk.parts.clear();
    return builder.along(base, Mode::body_twist, 0, {0.4});
  }
  ChunkBuilder grip() {
    ChunkBuilder builder = speeds({0.0});
    builder.chunk.parts.clear();
    return builder.scalar(gripper, Mode::gripper_binary, {1.0});
  }
  // The first row has acted; the base moves (or not) at the state that says so.
  void act(double speed) {
    if (lead == 1) next_tick(hold);  // the row is for the tick that begins now
    velocities[base_x] = speed;
    next_tick_of({hold, hold, row_of(safe, 0), hold});
  }
};

}  // namespace

TEST_CASE("G025 a held tick does not let a moving part change its mode; standstill does") {
  for (const bool lockstep : {true, false}) {
    MovingBase rig(lockstep);
    rig.act(0.5);
    rig.next_tick(hold);
    CHECK(rig.send_chunk(rig.twist()).code == 25);
    rig.velocities[base_x] = 0.04;
    rig.next_tick(hold);
    CHECK(rig.send_chunk(rig.twist()).code == 0);
  }
}

TEST_CASE("G025 a chunk for another part does not let a moving part change its mode") {
  MovingBase rig(true);
  rig.act(0.5);
  REQUIRE(rig.send_chunk(rig.grip()).code == 0);
  const SafeChunk grip = rig.safe_chunk();
  rig.next_tick_of({hold, row_of(grip, 0), hold, hold});
  CHECK(rig.send_chunk(rig.twist()).code == 25);
}

TEST_CASE("G025 the same mode goes on after a hold, also while the part moves") {
  for (const bool lockstep : {true, false}) {
    MovingBase rig(lockstep);
    rig.act(0.5);
    rig.next_tick(hold);
    CHECK(rig.send_chunk(rig.speeds({0.5})).code == 0);
  }
}

TEST_CASE("G025 a part that came to rest may change its mode, though it moves again by itself") {
  MovingBase rig(true);
  rig.act(0.5);
  rig.velocities[base_x] = 0.0;
  rig.next_tick(hold);
  rig.velocities[base_x] = 0.06;
  rig.next_tick(hold);
  CHECK(rig.send_chunk(rig.twist()).code == 0);
}

TEST_CASE("G025 lockstep: standstill after the row that acted is enough") {
  MovingBase rig(true);
  rig.act(0.04);
  CHECK(rig.send_chunk(rig.twist()).code == 0);
}

TEST_CASE("G025 realtime: a row that begins in this tick is not measured yet") {
  MovingBase rig(false);
  rig.next_tick(hold);  // stands still, but the row acts from now on
  const Verdict early = rig.send_chunk(rig.twist());
  CHECK(early.code == 25);
  CHECK(early.axis == "mode");
  rig.next_tick_of({hold, hold, row_of(rig.safe, 0), hold});
  CHECK(rig.send_chunk(rig.twist()).code == 25);  // still, but after a row: it may have just begun
  rig.next_tick(hold);
  CHECK(rig.send_chunk(rig.twist()).code == 0);
}

TEST_CASE("G025 a part in motion at arming needs standstill before its first row") {
  for (const bool lockstep : {true, false}) {
    GateRig rig(lockstep);
    rig.velocities[base_x] = 0.5;
    rig.ready();
    const auto send = [&rig, lockstep] {
      ChunkBuilder chunk = rig.chunk({0.5});
      chunk.chunk.start_tick += lockstep ? 0 : 1;
      return rig.send_chunk(chunk).code;
    };
    CHECK(send() == 25);
    rig.next_tick(hold);
    CHECK(send() == 25);
    rig.velocities[base_x] = 0.0;
    rig.next_tick(hold);
    CHECK(send() == 0);
  }
}

TEST_CASE("G025 the claim that moved a part has ended: the next one may not change its mode") {
  MovingBase rig(true);
  rig.act(0.5);
  rig.send(EventKind::release, Release{"runner", rig.claim_id});
  rig.take_claim();
  rig.seq = 0;
  rig.next_tick(hold);
  CHECK(rig.send_chunk(rig.twist()).code == 25);
  CHECK(rig.send_chunk(rig.speeds({0.5})).code == 0);
}

TEST_CASE("G025 the first of the parts that moves may not change its mode either") {
  GateRig rig(true);
  rig.ready();
  const auto send = [&rig](Mode mode, double value) {
    ChunkBuilder builder = rig.chunk();
    builder.chunk.parts.clear();
    builder.joint(arm, mode, arm_1, {value});
    return rig.send_chunk(builder).code;
  };
  REQUIRE(send(Mode::joint_velocity, 0.5) == 0);
  const SafeChunk safe = rig.safe_chunk();
  rig.velocities[arm_1] = 0.5;
  rig.next_tick_of({row_of(safe, 0), hold, hold, hold});
  rig.next_tick(hold);
  CHECK(send(Mode::joint_position, 0.0) == 25);
  CHECK(send(Mode::joint_velocity, 0.5) == 0);
}

TEST_CASE("G025 what nobody knows may have been of any mode: each has to be listed") {
  GateRig rig(true);
  const auto velocity = static_cast<std::uint8_t>(Mode::joint_velocity);
  rig.limits.parts[arm].followers[static_cast<std::size_t>(Mode::joint_position)] &=
      static_cast<std::uint16_t>(~PartMemory::mode_bit(velocity));
  rig.restart(BootInfo{true, false, {}});
  rig.ready();
  rig.next_tick(rig.forgotten_row([&rig] {
    ChunkBuilder targets = rig.chunk();
    targets.chunk.parts.clear();
    return targets.joint(arm, Mode::joint_position, arm_1, {0.0});
  }));
  rig.next_tick(hold);
  ChunkBuilder builder = rig.chunk();
  builder.chunk.parts.clear();
  builder.joint(arm, Mode::joint_velocity, arm_1, {0.0});
  CHECK(rig.send_chunk(builder).code == 25);
}

TEST_CASE("G025 realtime: the row that is about to act is the one whose followers are listed") {
  GateRig rig;
  const auto velocity = static_cast<std::uint8_t>(Mode::joint_velocity);
  rig.limits.parts[arm].followers[static_cast<std::size_t>(Mode::joint_position)] &=
      static_cast<std::uint16_t>(~PartMemory::mode_bit(velocity));
  rig.restart(BootInfo{true, false, {}});
  rig.ready();
  const auto send = [&rig](Mode mode) {
    ChunkBuilder builder = rig.chunk();
    builder.chunk.parts.clear();
    builder.chunk.start_tick += 1;
    builder.joint(arm, mode, arm_1, {0.0});
    return rig.send_chunk(builder);
  };
  REQUIRE(send(Mode::joint_position).code == 0);
  rig.next_tick(hold);
  const Verdict verdict = send(Mode::joint_velocity);
  CHECK(verdict.code == 25);
  CHECK(verdict.limit_source == "a change in its transitions");
}

TEST_CASE("G025 realtime: the verdict names the mode that the part moves in, if it is known") {
  PartMemories memories;
  PartMemory& memory = memories[arm];
  memory.note(ChunkBuilder().along(arm, Mode::cartesian_twist, 0, {0.0}).chunk.parts[0]);
  const ChunkBuilder chunk = ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.0});
  const auto found = [&] {
    return judge(chunk.chunk, state_at_rest(), RowBefore{nullptr, 0, false, &memories}).evidence;
  };
  CHECK(found().code == 25);
  CHECK(found().value == 1.0);  // joint_velocity
  CHECK(found().limit == 6.0);  // cartesian_twist
  memory.kind = PartMemory::Kind::unknown;
  CHECK(found().code == 25);
  CHECK(found().limit == 1.0);
}

TEST_CASE("G025 realtime: a part that moves is not told in another frame after a held tick") {
  PartMemories memories;
  const ChunkBuilder chunk = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.0});
  memories[arm].note(chunk.chunk.parts[0]);
  const auto found = [&] {
    return judge(chunk.chunk, state_at_rest(), RowBefore{nullptr, 0, false, &memories}).evidence;
  };
  CHECK(found().ok());
  memories[arm].frame_id = "tool";
  CHECK(found().code == 25);
}
