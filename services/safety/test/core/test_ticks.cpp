// G006, G010, G012: everything about a chunk that counts ticks.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("G006 ages at the limit, beyond it, and inputs newer than the observation") {
  GateRig rig;
  rig.ready();
  const auto code = [&rig](std::uint64_t obs_back, std::uint64_t oldest_back) {
    ChunkBuilder chunk = rig.chunk(Row(20, 0.0));
    chunk.chunk.obs_tick = rig.tick - obs_back;
    chunk.chunk.oldest_tick = rig.tick - oldest_back;
    chunk.chunk.start_tick = chunk.chunk.obs_tick;
    const std::uint32_t result = rig.send_chunk(chunk).code;
    for (int i = 0; i < 11; ++i) {
      rig.next_tick();
      rig.send_heartbeat();
    }
    return result;
  };
  CHECK(code(0, 5) == 0);
  CHECK(code(0, 6) == 6);
  CHECK(code(5, 5) == 0);
  CHECK(code(6, 6) == 6);
  CHECK(code(1, 0) == 6);
  CHECK(code(0, rig.tick) == 6);  // tick 0
}

TEST_CASE("G006 a chunk one tick ahead waits for its state, without a verdict") {
  GateRig rig;
  rig.ready();
  ChunkBuilder chunk = rig.chunk();
  chunk.chunk.obs_tick = chunk.chunk.oldest_tick = chunk.chunk.start_tick = rig.tick + 1;
  rig.send_frame(EventKind::candidate, chunk.frame(), "runner");
  CHECK(rig.count(OutputKind::verdict) == 0);
  rig.next_tick();
  CHECK(rig.verdict().code == 0);
  CHECK(rig.safe_chunk().first_tick == rig.tick + 1);
  rig.next_tick();
  CHECK(rig.count(OutputKind::verdict) == 0);  // only once
}

TEST_CASE("G006 only the newest waiting chunk is kept, and a claim that ended has none") {
  GateRig rig;
  rig.ready();
  for (int i = 0; i < 2; ++i) {
    ChunkBuilder chunk = rig.chunk();
    chunk.chunk.obs_tick = chunk.chunk.oldest_tick = chunk.chunk.start_tick = rig.tick + 1;
    rig.send_frame(EventKind::candidate, chunk.frame(), "runner");
  }
  rig.send_heartbeat();
  rig.next_tick();
  CHECK(rig.count(OutputKind::verdict) == 1);
  CHECK(rig.verdict().seq == 2);

  ChunkBuilder late = rig.chunk();
  late.chunk.obs_tick = late.chunk.oldest_tick = late.chunk.start_tick = rig.tick + 1;
  rig.send_frame(EventKind::candidate, late.frame(), "runner");
  rig.send(EventKind::release, Release{"runner", rig.claim_id});
  rig.next_tick();
  CHECK(rig.count(OutputKind::verdict) == 0);
}

TEST_CASE(
    "G006 what waits for its state when its claim ends is not judged for the next in its place") {
  for (const bool lockstep : {true, false}) {
    GateRig rig(lockstep);
    rig.ready();
    ChunkBuilder chunk = rig.chunk();
    chunk.chunk.obs_tick = chunk.chunk.oldest_tick = chunk.chunk.start_tick = rig.tick + 1;
    rig.send_frame(EventKind::candidate, chunk.frame(), "runner");
    REQUIRE(rig.count(OutputKind::verdict) == 0);
    rig.send(EventKind::release, Release{"runner", rig.claim_id});
    if (!lockstep) rig.next_tick();  // what it was granted may act until then
    rig.take_claim();
    rig.next_tick();
    CHECK(rig.count(OutputKind::verdict) == 0);
  }
}

TEST_CASE("G006 more than one tick ahead is refused, and five times in 20 ticks stop") {
  GateRig rig;
  rig.ready();
  for (int i = 1; i <= 5; ++i) {
    ChunkBuilder chunk = rig.chunk();
    chunk.chunk.obs_tick = rig.tick + 2;
    chunk.chunk.oldest_tick = rig.tick;
    CHECK(rig.send_chunk(chunk).code == 6);
    CHECK(rig.gate->state() == (i < 5 ? GateState::armed : GateState::stopped));
  }
  GateRig far;
  far.ready();
  ChunkBuilder chunk = far.chunk();
  chunk.chunk.obs_tick = UINT64_MAX;
  CHECK(far.send_chunk(chunk).code == 6);
}

TEST_CASE("G006 rows of a chunk may not begin later than the next open tick") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();
    const auto code = [&rig](std::uint64_t ahead) {
      ChunkBuilder chunk = rig.chunk();
      chunk.chunk.start_tick = rig.tick + ahead;
      return rig.send_chunk(chunk).code;
    };
    CHECK(code(0) == 0);
    CHECK(code(1) == (lockstep ? 6 : 0));
    CHECK(code(2) == 6);
    CHECK(code(UINT64_MAX - rig.tick) == 6);
  }
}

TEST_CASE("G010 the excess over the declared rate is refused, counted in ticks") {
  GateRig rig;
  rig.ready();  // 20 Hz: ceil(1.2 x 20 x 0.25 s) + 1 = 7 in 5 ticks
  for (int i = 0; i < 7; ++i) CHECK(rig.send_chunk(rig.chunk()).code == 0);
  CHECK(rig.send_chunk(rig.chunk()).code == 10);
  rig.pass(3);
  rig.next_tick();
  CHECK(rig.send_chunk(rig.chunk()).code == 10);
  rig.next_tick();
  CHECK(rig.send_chunk(rig.chunk()).code == 0);
}

TEST_CASE("G012 past rows are dropped by index, and none left is stale") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();
    const auto outcome = [&rig](std::uint64_t back) {
      ChunkBuilder chunk = rig.chunk({0.1, 0.2, 0.3, 0.4});
      chunk.chunk.start_tick -= back;
      return rig.send_chunk(chunk);
    };
    const std::uint64_t last = lockstep ? 3 : 2;
    const Verdict verdict = outcome(last);
    CHECK(verdict.code == 0);
    CHECK(verdict.released_first == verdict.released_last);
    const SafeChunk safe = rig.safe_chunk();
    CHECK(safe.horizon == 1);
    CHECK(safe.parts[0].values[base_x] == 0.4);
    CHECK(outcome(last + 1).code == 12);
    CHECK(outcome(90).code == 12);
  }
}

TEST_CASE("G010 in lockstep a chunk that the world waits for is no excess; a second one may be") {
  GateRig rig(true);
  rig.ready();
  for (int i = 0; i < 50; ++i) {  // a policy whose chunks are cut to one row each
    CHECK(rig.send_chunk(rig.chunk({0.1, 9.0, 0.1})).outcome == 1);
    rig.next_tick(row_of(rig.safe_chunk(), 0));
    rig.send_heartbeat();
  }
  CHECK(rig.send_chunk(rig.chunk()).code == 0);
  for (int i = 0; i < 7; ++i) CHECK(rig.send_chunk(rig.chunk()).code == 0);
  CHECK(rig.send_chunk(rig.chunk()).code == 10);
}

TEST_CASE("G007 rows whose ticks do not fit 64 bits") {
  const Limits limits = test_limits();
  ChunkBuilder builder = ChunkBuilder().along(base, Mode::body_twist, 0, {0.1, 0.1});
  builder.chunk.start_tick = UINT64_MAX - 2;  // rows for this and the next: one tick is left
  CHECK(check_shape(limits, whole_robot(limits), builder.chunk).ok());
  for (const std::uint64_t start : {UINT64_MAX - 1, UINT64_MAX}) {
    builder.chunk.start_tick = start;
    CHECK(check_shape(limits, whole_robot(limits), builder.chunk).code == 7);
  }
}

TEST_CASE("rows for the last ticks there are: released, executed and ended as any other") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.tick = UINT64_MAX - (lockstep ? 1 : 2);
    HalStatus status = rig.hal_status();
    status.tick = rig.tick;
    rig.send(EventKind::hal_status, status);
    rig.send_state();
    rig.epoch = rig.arm().epoch;
    rig.take_claim();
    CHECK(rig.send_chunk(rig.chunk(lockstep ? Row{0.1} : Row{0.1, 0.1})).code == 0);
    const SafeChunk safe = rig.safe_chunk();
    CHECK(safe.first_tick == UINT64_MAX - 1);
    CHECK(safe.horizon == 1);
    if (!lockstep) rig.next_tick(Acted{2, 0, 0});
    rig.next_tick(row_of(safe, 0));
    CHECK(rig.count(OutputKind::safe_chunk) == 0);
    for (const std::uint64_t back : {0U, 1U, 2U, 3U}) {  // rows that go too far, or are past
      ChunkBuilder late = rig.chunk({0.1, 0.1, 0.1});
      late.chunk.start_tick -= back;
      CHECK(rig.send_chunk(late).code == (back == 3 ? 12 : 7));
      CHECK(rig.count(OutputKind::safe_chunk) == 0);
    }
  }
}

TEST_CASE(
    "G013 a session's first state may be 100,000 ticks ahead of its newest hal/status, no more") {
  for (const std::uint64_t said : {std::uint64_t{0}, std::uint64_t{7}, UINT64_MAX - 100'001}) {
    GateRig rig(true);
    HalStatus status = rig.hal_status();
    status.tick = said;
    rig.send(EventKind::hal_status, status);
    rig.tick = said + 100'001;
    for (const std::size_t lines : {1U, 0U}) {  // it is said once
      rig.send_state();
      CHECK(rig.count(OutputKind::log) == lines);
      CHECK(rig.status().state_tick == 0);
      rig.tick = UINT64_MAX;
    }
    CHECK(rig.counter("G013") == 2);
    rig.tick = said + 100'000;
    rig.send_state();
    CHECK(rig.arm().epoch != 0);
  }
}

TEST_CASE("G013 a hal/status near the last tick there is leaves room for every first state") {
  GateRig rig(true);
  HalStatus status = rig.hal_status();
  status.tick = UINT64_MAX - 5;
  rig.send(EventKind::hal_status, status);
  rig.tick = UINT64_MAX;
  rig.send_state();
  CHECK(rig.arm().epoch != 0);
}

TEST_CASE("G013 a first state that is too far ahead is said once in each session") {
  GateRig rig(true);
  const auto first_state_of = [&rig](std::uint64_t session) {
    rig.session = session;
    rig.tick = 200'000;
    rig.send_state();
    std::size_t said = 0;
    for (const Output& output : rig.out->items()) {
      const Bytes line = rig.out->payload(output);
      said += output.kind == OutputKind::log &&
                      std::string(line.begin(), line.end()).starts_with("G013 the first")
                  ? 1U
                  : 0U;
    }
    return said;
  };
  rig.send_hal_status(5);
  CHECK(first_state_of(5) == 1);
  CHECK(first_state_of(5) == 0);
  rig.send_hal_status(6);
  rig.now_ns += 600 * ms;
  CHECK(first_state_of(6) == 1);
  CHECK(rig.status().session == 6);
  CHECK(first_state_of(6) == 0);
}
