// Released rows meet newer states: G011.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted hold{2, 0, 0};

// An arm whose two joints were told something for three ticks; the first row has begun.
struct LiveArm : GateRig {
  SafeChunk safe;

  LiveArm(bool in_lockstep, double position, Mode mode, const Row& values) : GateRig(in_lockstep) {
    positions[arm_1] = position;
    ready();
    ChunkBuilder builder = chunk();
    builder.chunk.parts.clear();
    builder.chunk.start_tick += lockstep ? 0 : 1;
    Rows rows;
    for (const double value : values) {
      Row row(joint_count, 0.0);
      row[arm_1] = value;
      rows.push_back(row);
    }
    builder.add(fairlead::test::arm, mode, rows, {arm_1, arm_2});
    const Verdict verdict = send_chunk(builder);
    REQUIRE(verdict.code == 0);
    safe = safe_chunk();
  }
  void after_row() {
    if (!lockstep) next_tick(hold);
    next_tick_of({row_of(safe, 0), hold, hold, hold});
  }
  bool stopped() const { return gate->state() == GateState::stopped; }
};

}  // namespace

TEST_CASE("G011 released rows stop where a joint has left its bounds and they do not lead back") {
  for (const bool lockstep : {true, false}) {
    LiveArm rig(lockstep, 1.9, Mode::joint_velocity, {0.5, 0.5, 0.5});
    rig.positions[arm_1] = just_above(2.1);  // bounds of 2, tolerance 0.1
    rig.after_row();
    CHECK(rig.stopped());
    const Text cause = rig.status().cause;
    CHECK(cause.view().starts_with("stopped: G011 arm arm_1, row "));
  }
}

TEST_CASE("G011 released rows run on within the tolerance, and where they lead back") {
  for (const bool lockstep : {true, false}) {
    LiveArm inside(lockstep, 1.9, Mode::joint_velocity, {0.5, 0.5, 0.5});
    inside.positions[arm_1] = 2.09;
    inside.after_row();
    CHECK_FALSE(inside.stopped());
    LiveArm back(lockstep, 2.2, Mode::joint_velocity, {-0.5, -0.5, -0.5});
    back.after_row();
    CHECK_FALSE(back.stopped());
    LiveArm target(lockstep, 2.2, Mode::joint_position, {2.15, 2.1, 2.05});
    target.after_row();
    CHECK_FALSE(target.stopped());
  }
}

// Twelve rows are released, of which the first acted in the tick before.
static SafeChunk begin_a_run(GateRig& rig) {
  rig.ready();
  rig.send_chunk(rig.chunk(Row(12, 0.5)));
  const SafeChunk safe = rig.safe_chunk();
  rig.next_tick();
  rig.next_tick(row_of(safe, 0));
  return safe;
}

TEST_CASE("realtime: rows of a release that was replaced are granted no more once they go on") {
  GateRig rig;
  const SafeChunk first = begin_a_run(rig);
  REQUIRE(rig.send_chunk(rig.chunk(Row(12, 0.4))).code == 0);
  const SafeChunk second = rig.safe_chunk();
  rig.next_tick(row_of(first, 1));  // the second begins in this tick, if it came in time
  CHECK(rig.lease().grants[0].until_tick > rig.tick);
  SUBCASE("it did") {
    rig.next_tick(row_of(second, 0));
    CHECK(rig.lease().grants[0].until_tick > rig.tick);
  }
  SUBCASE("it did not") {
    rig.next_tick(row_of(first, 2));
    CHECK(rig.lease().grants[0].until_tick == rig.tick);
    CHECK(rig.safe_chunk().after.verdict_id == first.verdict_id);  // for a HAL that takes it yet
    rig.next_tick(row_of(first, 3));
    CHECK(rig.lease().grants[0].until_tick < rig.tick);
    rig.next_tick();
    CHECK(rig.lease().grants[0].until_tick > rig.tick);
    CHECK(rig.safe_chunk().after.hold != 0);
  }
}

TEST_CASE("realtime: so are those of a release whose numbers are forgotten") {
  GateRig rig;
  const SafeChunk first = begin_a_run(rig);
  for (int i = 0; i < 5; ++i) REQUIRE(rig.send_chunk(rig.chunk(Row(12, 0.4))).code == 0);
  rig.next_tick(row_of(first, 1));
  CHECK(rig.lease().grants[0].until_tick > rig.tick);
  rig.next_tick(row_of(first, 2));
  CHECK(rig.lease().grants[0].until_tick == rig.tick);
  CHECK(rig.gate->state() == GateState::armed);
}
