// What the HAL really did decides what may run next, in both pacings.

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

Acted row_of(const SafeChunk& safe, std::uint32_t row) { return Acted{0, safe.verdict_id, row}; }

std::uint8_t decision(const GateRig& rig) { return rig.lease().grants[0].decision; }

constexpr auto number = [](Decision value) { return static_cast<std::uint8_t>(value); };

// A HAL that does what it is told: which act follows `safe` at tick `tick`.
Acted obey(const SafeChunk& safe, std::uint64_t tick) {
  return tick < safe.first_tick + safe.horizon
             ? row_of(safe, static_cast<std::uint32_t>(tick - safe.first_tick))
             : Acted{2, 0, 0};
}

}  // namespace

TEST_CASE("realtime: a chunk that is executed as released needs one verdict only") {
  GateRig rig;
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3, 0.4}));
  const SafeChunk safe = rig.safe_chunk();
  rig.next_tick(Acted{2, 0, 0});  // what acted in the tick of the judgement: still a hold
  CHECK(rig.count(OutputKind::verdict) == 0);
  CHECK(rig.count(OutputKind::safe_chunk) == 1);  // not named yet: repeated before the lease
  CHECK(rig.safe_chunk().verdict_id == safe.verdict_id);
  rig.next_tick(row_of(safe, 0));
  CHECK(rig.count(OutputKind::safe_chunk) == 0);  // named
  rig.next_tick(row_of(safe, 1));
  rig.next_tick(row_of(safe, 2));
  CHECK(rig.count(OutputKind::verdict) == 0);
  rig.next_tick(Acted{2, 0, 0});  // rows have run out
  CHECK(rig.count(OutputKind::verdict) == 0);
  CHECK(rig.counter("released") == 1);
}

TEST_CASE("realtime: a lost SafeChunk is judged again from the newest state") {
  GateRig rig;
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3, 0.4, 0.5}));
  const SafeChunk first = rig.safe_chunk();
  rig.next_tick(Acted{1, 0, 0});
  rig.next_tick(Acted{1, 0, 0});  // its first tick has passed without it
  const SafeChunk again = rig.safe_chunk();
  CHECK(again.verdict_id != first.verdict_id);
  CHECK(again.first_tick == rig.tick + 1);
  CHECK(again.after.hold != 0);
  CHECK(again.horizon == 2);
  CHECK(again.parts[0].values[base_x] == 0.4);
  CHECK(rig.verdict().seq == 1);
}

TEST_CASE(
    "realtime: a hold in mid-chunk throws the rows away; the rest returns after a new judgement "
    "only") {
  GateRig rig;
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3, 0.4, 0.5, 0.6}));
  const SafeChunk first = rig.safe_chunk();
  rig.next_tick(Acted{1, 0, 0});
  rig.next_tick(row_of(first, 0));
  rig.next_tick(Acted{4, 0, 0});  // a stale lease: held
  const SafeChunk again = rig.safe_chunk();
  CHECK(again.verdict_id > first.verdict_id);
  CHECK(again.after.hold != 0);
  rig.next_tick(Acted{2, 0, 0});
  rig.next_tick(row_of(again, 0));
  CHECK(rig.count(OutputKind::verdict) == 0);
}

TEST_CASE("realtime: the HAL goes on with the older chunk when the newer one is lost") {
  GateRig rig;
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8}));
  const SafeChunk older = rig.safe_chunk();
  rig.next_tick(Acted{1, 0, 0});
  rig.next_tick(row_of(older, 0));
  rig.send_chunk(rig.chunk({0.0, 0.0, 0.0, 0.0, 0.0, 0.0}));
  const SafeChunk newer = rig.safe_chunk();
  CHECK(same_act(newer.after, row_of(older, 1)));
  rig.next_tick(row_of(older, 1));
  rig.next_tick(row_of(older, 2));  // and not the newer one
  const SafeChunk again = rig.safe_chunk();
  CHECK(again.verdict_id > newer.verdict_id);
  CHECK(same_act(again.after, row_of(older, 3)));
  CHECK(again.first_tick == rig.tick + 1);
  rig.next_tick(row_of(older, 3));
  CHECK(rig.count(OutputKind::verdict) == 0);
  rig.next_tick(row_of(again, 0));
  CHECK(rig.count(OutputKind::verdict) == 0);
}

TEST_CASE("realtime: a chunk that replaces another continues from what is expected") {
  GateRig rig;
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3, 0.4, 0.5}));
  const SafeChunk first = rig.safe_chunk();
  rig.next_tick(Acted{1, 0, 0});
  rig.send_chunk(rig.chunk({0.0, 0.1, 0.2}));
  const SafeChunk second = rig.safe_chunk();
  CHECK(same_act(second.after, row_of(first, 0)));
  CHECK(second.first_tick == first.first_tick + 1);
  rig.next_tick(row_of(first, 0));
  rig.next_tick(row_of(second, 0));
  CHECK(rig.count(OutputKind::verdict) == 0);
}

TEST_CASE("realtime: states may be lost without harm while the HAL does as expected") {
  GateRig rig;
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7}));
  const SafeChunk safe = rig.safe_chunk();
  rig.tick += 3;
  rig.now_ns += 3 * period_ns;
  rig.next_tick(row_of(safe, 2));
  CHECK(rig.count(OutputKind::verdict) == 0);
  CHECK(rig.gate->state() == GateState::armed);
}

TEST_CASE("realtime: nothing left to judge again is no verdict") {
  GateRig rig;
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3}));
  rig.next_tick(Acted{1, 0, 0});
  rig.next_tick(Acted{1, 0, 0});
  CHECK(rig.count(OutputKind::verdict) == 0);
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
}

TEST_CASE("rows that were cut off once stay cut off") {
  GateRig rig;
  rig.ready();
  CHECK(rig.send_chunk(rig.chunk({0.1, 0.1, 0.1, 0.1, 9.0, 0.1})).outcome == 1);
  CHECK(rig.safe_chunk().horizon == 3);
  rig.next_tick(Acted{1, 0, 0});
  rig.next_tick(Acted{1, 0, 0});
  CHECK(rig.safe_chunk().horizon == 1);  // for the next tick, which is its last
  rig.next_tick(Acted{1, 0, 0});
  rig.next_tick(Acted{1, 0, 0});
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
}

TEST_CASE("judged again from where the robot now is: what no longer fits is refused") {
  GateRig rig;
  rig.ready();
  ChunkBuilder chunk = rig.chunk();
  chunk.chunk.parts.clear();
  chunk.joint(arm, Mode::joint_position, arm_1, {0.0, 0.2, 0.4, 0.6, 0.8});
  CHECK(rig.send_chunk(chunk).code == 0);
  rig.next_tick(Acted{1, 0, 0});
  rig.positions[arm_1] = -0.2;
  rig.next_tick(Acted{1, 0, 0});
  CHECK(rig.verdict().code == 21);
  CHECK(rig.verdict().row == 3);
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
}

TEST_CASE("parts of one claim that act apart continue nothing") {
  GateRig rig(true);
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3, 0.4}));
  const SafeChunk safe = rig.safe_chunk();
  JointState state;
  state.session = rig.session;
  state.tick = ++rig.tick;
  const std::vector<double> zeros(measured_count, 0.0);
  const Bytes block(reinterpret_cast<const std::uint8_t*>(zeros.data()),
                    zeros.size() * sizeof(double));
  state.positions = state.velocities = state.efforts = NumberView(block);
  state.robot_hash = hash_of(7);
  for (int i = 0; i < 4; ++i)
    (void)state.acted.push_back(i == 1 ? Acted{3, 0, 0} : row_of(safe, 0));
  rig.send(EventKind::joint_state, state);
  CHECK(rig.safe_chunk().after.hold != 0);  // no part that moved will match it
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
  CHECK(rig.count(OutputKind::verdict) == 0);
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

TEST_CASE("a long run of chunks, each replacing the last, never disagrees with an obedient HAL") {
  for (const bool lockstep : {false, true}) {
    GateRig rig(lockstep);
    rig.ready();
    SafeChunk active;
    Acted did{1, 0, 0};
    for (int i = 0; i < 300; ++i) {
      if (i % 3 == 0) {
        CHECK(rig.send_chunk(rig.chunk(Row(6, 0.1 * (i % 5)))).code == 0);
        const SafeChunk next = rig.safe_chunk();
        CHECK(same_act(next.after, lockstep ? did : obey(active, rig.tick)));
        // In realtime the row of the present tick is still the older chunk's.
        did = lockstep ? obey(next, rig.tick) : obey(active, rig.tick);
        active = next;
      } else {
        did = obey(active, rig.tick);
      }
      rig.send_heartbeat();
      rig.next_tick(did);
      CHECK(rig.count(OutputKind::verdict) == 0);
    }
    CHECK(rig.counter("released") == 100);
  }
}
