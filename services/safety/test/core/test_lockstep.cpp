// Lockstep: the world waits until every claim is decided.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("parts of one chunk that acted apart: refused with G021, so the next tick holds") {
  GateRig rig(true);
  rig.ready();
  ChunkBuilder both = rig.chunk({0.1, 0.2, 0.3, 0.4});
  both.joint(arm, Mode::joint_velocity, arm_1, {0.1, 0.1, 0.1, 0.1});
  CHECK(rig.send_chunk(both).code == 0);
  const SafeChunk safe = rig.safe_chunk();
  rig.next_tick_of({Acted{3, 0, 0}, Acted{1, 0, 0}, row_of(safe, 0), Acted{1, 0, 0}});
  CHECK(rig.verdict().code == 21);
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
  CHECK(decision(rig) == number(Decision::hold));
}

TEST_CASE("a chunk for some parts of its claim is continued by its rows and by the next chunk") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();  // all parts; the chunk moves the base only
    CHECK(rig.send_chunk(rig.chunk({0.1, 0.2, 0.3, 0.4})).code == 0);
    const SafeChunk safe = rig.safe_chunk();
    const Acted beside{1, 0, 0};
    if (!lockstep) rig.next_tick();
    rig.next_tick_of({beside, beside, row_of(safe, 0), beside});
    CHECK(rig.count(OutputKind::verdict) == 0);  // as expected: nothing to judge again
    CHECK(rig.send_chunk(rig.chunk({0.2, 0.3, 0.4})).code == 0);
    CHECK(same_act(rig.safe_chunk().after, row_of(safe, lockstep ? 0 : 1)));
  }
}

TEST_CASE("G021 the row that acted was another claim's: one held tick, then from standstill") {
  GateRig rig(true);
  rig.ready();
  rig.send_chunk(rig.chunk({0.5, 0.5}));
  const SafeChunk others = rig.safe_chunk();
  rig.send(EventKind::release, Release{"runner", rig.claim_id});
  rig.take_claim();
  rig.seq = 0;
  rig.next_tick(row_of(others, 0));  // was under way when its claim ended
  CHECK(rig.send_chunk(rig.chunk({-0.5, -0.5})).code == 21);
  CHECK(decision(rig) == number(Decision::hold));
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
  rig.next_tick(Acted{6, 0, 0});
  CHECK(rig.send_chunk(rig.chunk({-0.5, -0.5})).code == 0);
}

TEST_CASE("G021 the row that acted is forgotten: refused, not judged as a standstill") {
  GateRig rig(true);
  rig.ready();
  rig.next_tick(rig.forgotten_row());
  CHECK(rig.verdict().code == 21);
  CHECK(rig.verdict().axis == "acted");
  CHECK(decision(rig) == number(Decision::hold));
}

TEST_CASE("lockstep: the first row is for the tick the robot waits in, and decides it") {
  GateRig rig(true);
  rig.ready();
  CHECK(decision(rig) == number(Decision::undecided));
  CHECK(rig.lease().grants[0].until_tick == rig.tick);
  const Verdict verdict = rig.send_chunk(rig.chunk({0.1, 0.2, 0.3}));
  CHECK(verdict.released_first == rig.tick);
  CHECK(rig.safe_chunk().first_tick == rig.tick);
  CHECK(decision(rig) == number(Decision::row));
  CHECK(rig.lease().grants[0].verdict_id == verdict.verdict_id);
}

TEST_CASE("lockstep: rows decide tick after tick, then the claim is undecided") {
  GateRig rig(true);
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3}));
  const SafeChunk safe = rig.safe_chunk();
  for (std::uint32_t row = 0; row < 2; ++row) {
    rig.next_tick(row_of(safe, row));
    CHECK(decision(rig) == number(Decision::row));
    CHECK(rig.lease().grants[0].verdict_id == safe.verdict_id);
  }
  rig.next_tick(row_of(safe, 2));
  CHECK(decision(rig) == number(Decision::undecided));
  rig.timer(25 * ms);
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
  CHECK(rig.send_chunk(rig.chunk({0.2, 0.1})).code == 0);
  CHECK(same_act(rig.safe_chunk().after, row_of(safe, 2)));
}

TEST_CASE("lockstep: a refused chunk decides a hold for this tick and no other") {
  GateRig rig(true);
  rig.ready();
  const Verdict verdict = rig.send_chunk(rig.chunk({9.0}));
  CHECK(verdict.code == 20);
  CHECK(decision(rig) == number(Decision::hold));
  CHECK(rig.lease().grants[0].verdict_id == verdict.verdict_id);
  rig.next_tick(Acted{6, 0, 0});
  CHECK(decision(rig) == number(Decision::undecided));
  CHECK(rig.send_chunk(rig.chunk({0.1})).code == 0);
  CHECK(rig.safe_chunk().after.hold == 6);
}

TEST_CASE("lockstep: what is refused before it is judged decides nothing") {
  GateRig rig(true);
  rig.ready();
  ChunkBuilder old_epoch = rig.chunk();
  old_epoch.chunk.epoch -= 1;
  CHECK(rig.send_chunk(old_epoch).code == 3);
  ChunkBuilder old_seq = rig.chunk();
  old_seq.chunk.seq = 0;
  CHECK(rig.send_chunk(old_seq).code == 5);
  rig.timer(25 * ms);
  CHECK(decision(rig) == number(Decision::undecided));
}

TEST_CASE("lockstep: the SafeChunk is repeated before every lease until it is named") {
  GateRig rig(true);
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3}));
  const SafeChunk safe = rig.safe_chunk();
  for (int i = 0; i < 3; ++i) {
    rig.timer(25 * ms);
    CHECK(rig.safe_chunk().verdict_id == safe.verdict_id);
    CHECK(rig.out->items()[0].kind == OutputKind::safe_chunk);
  }
  rig.send_state();  // the waiting robot repeats its tick
  CHECK(rig.safe_chunk().verdict_id == safe.verdict_id);
  rig.next_tick(row_of(safe, 0));
  rig.timer(25 * ms);
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
}

TEST_CASE("lockstep: a held tick in mid-chunk, and the rest is judged again at once") {
  GateRig rig(true);
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3, 0.4}));
  const SafeChunk first = rig.safe_chunk();
  rig.next_tick(row_of(first, 0));
  rig.next_tick(Acted{5, 0, 0});
  const SafeChunk again = rig.safe_chunk();
  CHECK(again.first_tick == rig.tick);
  CHECK(again.verdict_id > first.verdict_id);
  CHECK(again.after.hold == 5);
  CHECK(decision(rig) == number(Decision::row));
  CHECK(rig.lease().grants[0].verdict_id == again.verdict_id);
}

TEST_CASE("lockstep: a chunk one tick ahead waits as long as the world does") {
  GateRig rig(true);
  rig.ready();
  ChunkBuilder chunk = rig.chunk();
  chunk.chunk.obs_tick = chunk.chunk.oldest_tick = chunk.chunk.start_tick = rig.tick + 1;
  rig.send_frame(EventKind::candidate, chunk.frame(), "runner");
  for (int i = 0; i < 50; ++i) {
    rig.now_ns += 1000 * ms;
    rig.send_heartbeat();
    rig.send_state();
  }
  CHECK(decision(rig) == number(Decision::undecided));
  rig.next_tick();
  CHECK(decision(rig) == number(Decision::row));
}

TEST_CASE("lockstep: a repeated tick repeats each claim's newest verdict, byte for byte") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();
    rig.send_state();
    CHECK(rig.count(OutputKind::verdict) == 0);  // none was given yet
    const auto first = frame_of(rig.send_chunk(rig.chunk({9.0})));
    rig.now_ns += 100 * ms;
    rig.send_state();
    CHECK(rig.count(OutputKind::verdict) == (lockstep ? 1U : 0U));
    if (lockstep) CHECK(frame_of(rig.verdict()) == first);
    CHECK(rig.counter("refused") == 1);
  }
}

TEST_CASE("lockstep: once the HAL executes a claim's rows, a leap over a tick stops") {
  GateRig rig(true);
  rig.ready();
  rig.pass(5);  // nobody waits for the gate yet: held ticks may have been lost
  rig.next_tick(Acted{1, 0, 0});
  CHECK(rig.gate->state() == GateState::armed);
  rig.send_chunk(rig.chunk({0.1, 0.1, 0.1, 0.1}));
  const SafeChunk safe = rig.safe_chunk();
  rig.next_tick(row_of(safe, 0));
  CHECK(rig.gate->state() == GateState::armed);
  rig.pass(1);
  rig.next_tick(row_of(safe, 2));
  CHECK(rig.gate->state() == GateState::stopped);
}
