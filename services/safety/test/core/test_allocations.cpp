// From received bytes to encoded bytes the core allocates nothing.

#include <cstdlib>
#include <cstring>
#include <new>

#include "decisions/record.hpp"
#include "decisions/record_ring.hpp"
#include "filled_heap.hpp"
#include "tracked_rig.hpp"

namespace {

bool counting = false;
std::size_t allocations = 0;

void* allocate(std::size_t size) {
  if (counting) ++allocations;
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  if (fairlead::test::heap_fill >= 0) std::memset(memory, fairlead::test::heap_fill, size);
  return memory;
}

}  // namespace

// Replaces the program's allocator, also for every other test, where it only passes through.
void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

using namespace fairlead;
using namespace fairlead::test;

namespace {

// One step with the counter on; the frame is made before.
std::size_t allocations_of(GateRig& rig, EventKind kind, const std::vector<std::uint8_t>& frame) {
  allocations = 0;
  counting = true;
  rig.gate->step(rig.now_ns, Event{kind, "runner", frame, rig.now_ns}, *rig.out);
  counting = false;
  return allocations;
}

std::vector<std::uint8_t> full_chunk(GateRig& rig) {
  ChunkBuilder chunk = rig.chunk();
  chunk.chunk.parts.clear();
  chunk.joint(arm, Mode::joint_position, arm_1, Row(64, 0.1));
  chunk.scalar(gripper, Mode::gripper_position, Row(64, 0.04));
  chunk.joint(base, Mode::joint_velocity, base_x, Row(64, 0.1));
  chunk.scalar(composite, Mode::composite_mode, Row(64, -1.0));
  return chunk.frame();
}

}  // namespace

TEST_CASE("the counter counts") {
  allocations = 0;
  counting = true;
  delete new int(5);
  counting = false;
  CHECK(allocations == 1);
}

TEST_CASE("no event allocates: chunks, states, heartbeats, queries, stops, time") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();
    const auto good = full_chunk(rig);
    CHECK(allocations_of(rig, EventKind::candidate, good) == 0);
    CHECK(rig.verdict().code == 0);
    CHECK(allocations_of(rig, EventKind::candidate, good) == 0);  // a copy
    CHECK(allocations_of(rig, EventKind::candidate, rig.chunk({9.0}).frame()) == 0);
    CHECK(allocations_of(rig, EventKind::candidate, {1, 2, 3}) == 0);
    CHECK(allocations_of(rig, EventKind::heartbeat, frame_of(Heartbeat{rig.claim_id})) == 0);
    CHECK(allocations_of(rig, EventKind::timer, {}) == 0);
    CHECK(allocations_of(rig, EventKind::hal_status, frame_of(rig.hal_status())) == 0);
    CHECK(allocations_of(rig, EventKind::status, frame_of(StatusQuery{})) == 0);
    CHECK(allocations_of(rig, EventKind::claim, frame_of(rig.claim_request())) == 0);
    CHECK(allocations_of(rig, EventKind::release, frame_of(Release{"runner", rig.claim_id})) == 0);
    CHECK(allocations_of(rig, EventKind::claim, frame_of(rig.claim_request())) == 0);
    CHECK(allocations_of(rig, EventKind::stop_level, frame_of(StopLevel{5, "operator", "test"})) ==
          0);
    CHECK(allocations_of(rig, EventKind::reset, frame_of(Reset{"test", 5})) == 0);
    CHECK(allocations_of(rig, EventKind::arm, frame_of(Arm{"test"})) == 0);
    CHECK(allocations_of(rig, EventKind::disarm, frame_of(Disarm{"test"})) == 0);
  }
}

TEST_CASE("no chunk allocates, in any mode") {
  const Row tool{0.7, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0};
  const std::vector<ChunkBuilder> commands{
      ChunkBuilder().poses(arm, Rows(64, tool)),
      ChunkBuilder().along(arm, Mode::cartesian_delta, 0, Row(64, 0.01)),
      ChunkBuilder().along(arm, Mode::cartesian_twist, 0, Row(64, 0.1)),
      ChunkBuilder().along(base, Mode::body_twist, 0, Row(64, 0.1)),
      ChunkBuilder().scalar(gripper, Mode::gripper_binary, Row(64, 1.0)),
  };
  for (const ChunkBuilder& command : commands) {
    GateRig rig;
    rig.ready();
    ChunkBuilder chunk = rig.chunk();
    chunk.chunk.parts = command.chunk.parts;
    chunk.chunk.horizon = command.chunk.horizon;
    CHECK(allocations_of(rig, EventKind::candidate, chunk.frame()) == 0);
    CHECK(rig.verdict().code == 0);
    CHECK(rig.safe_chunk().horizon == 63);  // realtime: the first row is past
  }
}

TEST_CASE("no state allocates, not even one that has rows judged again") {
  GateRig rig;
  rig.ready();
  rig.send_frame(EventKind::candidate, full_chunk(rig), "runner");
  std::size_t judged_again = 0;
  for (int i = 0; i < 3; ++i) {
    JointState state;
    state.session = rig.session;
    state.tick = ++rig.tick;
    const std::vector<double> zeros(measured_count, 0.0);
    const Bytes block(reinterpret_cast<const std::uint8_t*>(zeros.data()),
                      zeros.size() * sizeof(double));
    state.positions = state.velocities = state.efforts = NumberView(block);
    state.robot_hash = hash_of(7);
    (void)state.acted.resize(4);
    CHECK(allocations_of(rig, EventKind::joint_state, frame_of(state)) == 0);
    judged_again += rig.count(OutputKind::verdict);
  }
  CHECK(judged_again == 1);
}

namespace {

// A state one tick later, in which the next row of the rig's chunk has acted.
std::vector<std::uint8_t> state_after(TrackedRig& rig, std::uint32_t row) {
  JointState state;
  state.session = rig.session;
  state.tick = ++rig.tick;
  rig.now_ns += period_ns;
  const auto view = [](const std::vector<double>& numbers) {
    return NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers.data()),
                            numbers.size() * sizeof(double)));
  };
  state.positions = view(rig.positions);
  state.velocities = view(rig.velocities);
  state.efforts = view(rig.efforts);
  state.robot_hash = hash_of(7);
  (void)state.acted.resize(4);
  for (Acted& act : state.acted) act = no_row;
  for (const ActionPart& part : rig.safe.parts) state.acted[part.part] = row_of(rig.safe, row);
  return frame_of(state);
}

}  // namespace

TEST_CASE("no state allocates that is compared with the rows that acted, in any mode") {
  const Row tool{0.7, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0};
  const std::vector<ChunkBuilder> commands{
      ChunkBuilder().joint(arm, Mode::joint_position, arm_1, Row(8, 0.1)),
      ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, Row(8, 0.1)),
      ChunkBuilder().poses(arm, Rows(8, tool)),
      ChunkBuilder().along(arm, Mode::cartesian_delta, 0, Row(8, 0.01)),
      ChunkBuilder().along(arm, Mode::cartesian_twist, 0, Row(8, 0.1)),
      ChunkBuilder().along(base, Mode::body_twist, 0, Row(8, 0.1)),
      ChunkBuilder().scalar(gripper, Mode::gripper_position, Row(8, 0.02)),
  };
  for (const bool lockstep : {true, false}) {
    for (const ChunkBuilder& command : commands) {
      TrackedRig rig(lockstep, [](Limits&) {});
      rig.begin(command);
      for (std::uint32_t row = 0; row < 3; ++row)
        CHECK(allocations_of(rig, EventKind::joint_state, state_after(rig, row)) == 0);
      CHECK(rig.gate->state() == GateState::armed);
      rig.efforts[arm_1] = 2e4;  // what stops allocates as little
      CHECK(allocations_of(rig, EventKind::joint_state, state_after(rig, 3)) == 0);
      CHECK(rig.stopped());
    }
  }
}

TEST_CASE("recording a step for the decision log allocates nothing") {
  GateRig rig;
  rig.ready();
  RecordRing ring(1U << 20U);
  const std::vector<std::uint8_t> frame = full_chunk(rig);
  rig.send_frame(EventKind::candidate, frame, "runner");
  REQUIRE(rig.count(OutputKind::safe_chunk) == 1);
  const Event event{EventKind::candidate, "runner", frame, rig.now_ns};
  allocations = 0;
  counting = true;
  const Record record = step_record(rig.now_ns, event, {}, *rig.out);
  const std::span<std::uint8_t> room = ring.reserve(room_for(record));
  const bool has_room = !room.empty();
  if (has_room) ring.commit(encode_record(record, room));
  counting = false;
  CHECK(has_room);
  CHECK(allocations == 0);
}
