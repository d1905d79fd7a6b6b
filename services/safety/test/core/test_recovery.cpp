// Realtime: what the HAL really did decides what may run next.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

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

TEST_CASE("realtime: rows that run on beyond a newer chunk that was lost are not granted") {
  GateRig rig;
  rig.ready();
  rig.send_chunk(rig.chunk({0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8}));
  const SafeChunk older = rig.safe_chunk();
  rig.next_tick(Acted{1, 0, 0});
  rig.next_tick(row_of(older, 0));
  ChunkBuilder one_row = rig.chunk({0.2});
  one_row.chunk.start_tick += 1;
  REQUIRE(rig.send_chunk(one_row).code == 0);
  rig.next_tick(row_of(older, 1));
  CHECK(rig.lease().grants[0].until_tick > rig.tick);
  rig.next_tick(row_of(older, 2));  // and not the newer one, which has ended
  CHECK(rig.lease().grants[0].until_tick == rig.tick);
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
  rig.pass(3);
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
