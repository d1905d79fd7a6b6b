// What a verdict says beside its code: whose it is, of which row, and the numbers that decided.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("a refusal names the claim only of a chunk that is its own in every respect") {
  GateRig rig;
  rig.ready();
  CHECK(rig.send_chunk(rig.chunk()).claim_id == rig.claim_id);
  const auto named = [&rig](auto spoil, const char* key = "runner") {
    ChunkBuilder chunk = rig.chunk({0.4});
    chunk.chunk.seq = 1;  // used already, for another chunk
    spoil(chunk.chunk);
    const Verdict verdict = rig.send_chunk(chunk, key);
    CHECK(verdict.outcome == 2);
    return verdict.claim_id;
  };
  CHECK(named([](ActionChunk&) {}) == rig.claim_id);
  CHECK(named([](ActionChunk&) {}, "other") == 0);
  CHECK(named([](ActionChunk& chunk) { chunk.source = "other"; }) == 0);
  CHECK(named([](ActionChunk& chunk) { chunk.source = "other"; }, "other") == 0);
  CHECK(named([](ActionChunk& chunk) { ++chunk.session; }) == 0);
  CHECK(named([](ActionChunk& chunk) { ++chunk.epoch; }) == 0);
  CHECK(named([](ActionChunk& chunk) { ++chunk.claim_id; }) == 0);
}

TEST_CASE("a single released row is the first and the last") {
  GateRig rig(true);
  rig.ready();
  const Verdict verdict = rig.send_chunk(rig.chunk({0.5}));
  CHECK(verdict.released_first == rig.tick);
  CHECK(verdict.released_last == rig.tick);
}

TEST_CASE("G010 the excess is counted with the chunk that makes it") {
  GateRig rig;
  rig.ready();
  for (int i = 0; i < 7; ++i) CHECK(rig.send_chunk(rig.chunk()).code == 0);
  const Verdict verdict = rig.send_chunk(rig.chunk());
  CHECK(verdict.code == 10);
  CHECK(verdict.value == 8.0);
  CHECK(verdict.limit == 7.0);
}

TEST_CASE("G006 five within 20 ticks are those of the newest tick and of the 19 before") {
  for (const std::uint64_t later : {19U, 20U}) {
    GateRig rig(true);
    rig.ready();
    const auto ahead = [&rig] {
      ChunkBuilder chunk = rig.chunk();
      chunk.chunk.obs_tick = rig.tick + 2;
      chunk.chunk.oldest_tick = rig.tick;
      CHECK(rig.send_chunk(chunk).code == 6);
    };
    for (int i = 0; i < 4; ++i) ahead();
    rig.pass(later - 1);
    rig.next_tick();
    ahead();
    CHECK((rig.gate->state() == GateState::stopped) == (later == 19));
  }
}

TEST_CASE("G021 after an act that nobody knows: the first row that is not past is at fault") {
  GateRig rig(true);
  rig.ready();
  rig.next_tick(rig.forgotten_row());
  ChunkBuilder chunk = rig.chunk({0.1, 0.1, 0.1, 0.1});
  chunk.chunk.start_tick -= 2;
  const Verdict verdict = rig.send_chunk(chunk);
  CHECK(verdict.code == 21);
  CHECK(verdict.axis == "acted");
  CHECK(verdict.row == 2);
  CHECK(verdict.margin == 0.0);
}

TEST_CASE("realtime: after an act that nobody knows nothing later than this tick is granted") {
  GateRig rig;
  rig.ready();
  const Acted forgotten = rig.forgotten_row();
  rig.next_tick(Acted{1, 0, 0});
  rig.next_tick(forgotten);
  CHECK(rig.verdict().outcome == 2);
  CHECK(rig.lease().grants[0].until_tick == rig.tick);
}

TEST_CASE("realtime: where nothing is left to judge again nothing is granted") {
  GateRig rig;
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3}));
  rig.next_tick(Acted{1, 0, 0});
  rig.next_tick(Acted{1, 0, 0});
  CHECK(rig.lease().grants[0].until_tick == rig.tick);
}

TEST_CASE("a rule without a measure has no margin") {
  const Limits limits = test_limits();
  ChunkBuilder chunk = ChunkBuilder().along(base, Mode::body_twist, 0, {0.1});
  chunk.chunk.parts[0].values = NumberView();
  const Evidence evidence = check_shape(limits, whole_robot(limits), chunk.chunk);
  CHECK(evidence.axis == "values");
  CHECK(evidence.value == 0.0);
  CHECK(evidence.limit == 6.0);
  CHECK(evidence.margin == 0.0);
}
