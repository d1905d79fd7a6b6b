// Released rows are judged again by every new state, as far as they can act before the next one: a
// breach there revokes the rows from it on.

#include "tracked_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// Velocities happen as told, and the joint brakes at once: each row of 1 rad/s is 0.05 rad.
void narrow(Limits& limits) { limits.parts[arm].modes.joint_velocity.gain = {1.0, 1.0}; }

// arm_1 goes from 1.5 rad towards its bound of 2 rad, and would end at 1.875.
struct Approach : TrackedRig {
  explicit Approach(bool in_lockstep) : TrackedRig(in_lockstep, narrow) {
    for (const double place : {0.5, 1.0, 1.5, 1.5}) {  // where it stands still
      positions[arm_1] = place;
      hold();
    }
    begin(ChunkBuilder().joint(fairlead::test::arm, Mode::joint_velocity, arm_1,
                               {0.5, 1, 1, 1, 1, 1, 1, 1}));
  }
  /// Pushed ahead by 0.2 m in row 0; then as told, up to the first state that cuts something off.
  Verdict pushed_until_cut() {
    double position = 1.725;
    for (act_at(position); count(OutputKind::verdict) == 0; act_at(position)) position += 0.05;
    return verdict();
  }
  /// The next row acted, and the joint is there.
  void act_at(double position) {
    positions[arm_1] = position;
    act();
  }
};

constexpr auto as_number = [](auto value) { return static_cast<std::uint8_t>(value); };

}  // namespace

TEST_CASE("rows that lead where they were judged to lead are released once") {
  for (const bool lockstep : {true, false}) {
    Approach rig(lockstep);
    double position = 1.525;
    for (int row = 0; row < 8; ++row, position += 0.05) {
      rig.act_at(position);
      CHECK(rig.count(OutputKind::verdict) == 0);
    }
    CHECK_FALSE(rig.stopped());
  }
}

TEST_CASE("a push towards a bound cuts off the row that would pass it before a lease grants it") {
  // From 1.725 after row 0, row 5 ends at 1.975 and row 6 at 2.025.
  for (const bool lockstep : {true, false}) {
    Approach rig(lockstep);
    const SafeChunk first = rig.safe;
    const std::uint64_t begun = rig.tick;  // the tick of row 0
    const Verdict verdict = rig.pushed_until_cut();
    CHECK(verdict.verdict_id > first.verdict_id);
    CHECK(verdict.seq == rig.seq);
    CHECK(verdict.code == 24);
    CHECK(verdict.row == 6);
    CHECK(verdict.part == "arm");
    CHECK(verdict.axis == "arm_1");
    CHECK(verdict.limit == 2.0);
    CHECK(verdict.value == doctest::Approx(2.025));
    const Grant grant = rig.lease().grants[0];
    if (lockstep) {  // row 5 acted; row 6 would be next
      CHECK(grant.decision == number(Decision::hold));
      CHECK(rig.tick == begun + 6);
      CHECK(verdict.outcome == as_number(Outcome::refused));
      CHECK(rig.count(OutputKind::safe_chunk) == 0);
      CHECK(rig.counter("G024") == 1);
      continue;
    }
    CHECK(rig.tick == begun + 3);  // row 3 acts; the lease before granted row 4
    CHECK(grant.until_tick == begun + 5);
    CHECK(verdict.outcome == as_number(Outcome::truncated));
    CHECK(verdict.released_first == rig.tick + 1);
    CHECK(verdict.released_last == rig.tick + 2);
    const SafeChunk shorter = rig.safe_chunk();
    CHECK(shorter.verdict_id == verdict.verdict_id);
    CHECK(shorter.first_tick == rig.tick + 1);
    CHECK(shorter.horizon == 2);
    CHECK(same_act(shorter.after, row_of(first, 3)));
    CHECK(shorter.parts[0].values[arm_1] == 1.0);
    CHECK(rig.counter("G024") == 1);
    CHECK(rig.counter("truncated") == 1);
  }
}

TEST_CASE("realtime: the HAL takes the shorter release, ends with its last row, and then holds") {
  Approach rig(false);
  (void)rig.pushed_until_cut();
  const SafeChunk shorter = rig.safe_chunk();
  rig.act_at(1.875);  // row 3, of the release before
  rig.safe = shorter;
  rig.restart_rows();
  for (const double position : {1.925, 1.975}) {
    rig.act_at(position);
    CHECK(rig.count(OutputKind::verdict) == 0);
  }
  CHECK(rig.lease().grants[0].decision == number(Decision::undecided));
  rig.hold();
  CHECK_FALSE(rig.stopped());
}

TEST_CASE("a push so far that nothing may follow leaves a hold, and the claim goes on after it") {
  for (const bool lockstep : {true, false}) {
    Approach rig(lockstep);
    rig.act_at(1.99);
    const Verdict verdict = rig.verdict();
    CHECK(verdict.code == 24);
    CHECK(verdict.outcome == as_number(Outcome::refused));
    CHECK(verdict.row == (lockstep ? 1 : 2));
    CHECK(verdict.released_last == 0);
    CHECK(rig.count(OutputKind::safe_chunk) == 0);
    const Grant grant = rig.lease().grants[0];
    CHECK(grant.until_tick == rig.tick);  // nothing after the present tick
    if (lockstep) {
      CHECK(grant.decision == number(Decision::hold));
      CHECK(grant.verdict_id == verdict.verdict_id);
      rig.hold();
    } else {
      rig.act_at(2.04);  // the row that acted already
      CHECK(rig.lease().grants[0].until_tick == rig.tick - 1);
      rig.hold();
      CHECK(rig.lease().grants[0].until_tick == rig.tick + 2);
    }
    CHECK_FALSE(rig.stopped());
    rig.begin(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {-0.5, -0.5}));
    rig.act();
    CHECK_FALSE(rig.stopped());
  }
}

TEST_CASE("realtime: while the shorter release is lost, no grant reaches a row that was revoked") {
  Approach rig(false);
  const Verdict cut = rig.pushed_until_cut();
  const std::uint64_t revoked = cut.released_last + 1;
  for (int row = 1; row < 6; ++row) {
    CHECK(rig.lease().grants[0].until_tick < revoked);
    rig.act_at(1.825 + 0.02 * row);  // it is slower than told: nothing more would be revoked
  }
  CHECK(rig.lease().grants[0].until_tick < revoked);
  rig.hold();
  CHECK(rig.lease().grants[0].until_tick == rig.tick + 2);
}

TEST_CASE("realtime: rows that a lost release had replaced do not run on past its end") {
  Approach rig(false);
  rig.act_at(1.525);
  // A new chunk of two rows takes the place of the rest, and never reaches the HAL.
  ChunkBuilder builder = rig.chunk();
  builder.chunk.parts.clear();
  builder.joint(arm, Mode::joint_velocity, arm_1, {1.0, 1.0, 1.0});
  REQUIRE(rig.send_chunk(builder).code == 0);
  const std::uint64_t last = rig.verdict().released_last;
  for (int row = 1; row < 6; ++row) {
    rig.act_at(1.525 + 0.05 * row);
    if (rig.tick > last) CHECK(rig.lease().grants[0].until_tick <= rig.tick);
  }
  rig.hold();
  CHECK(rig.lease().grants[0].until_tick == rig.tick + 2);
}

TEST_CASE(
    "realtime: a second push while the shorter release is lost ends the grant earlier still") {
  Approach rig(false);
  const std::uint64_t last = rig.pushed_until_cut().released_last;
  // The row of this tick acts and ends at 1.98, the next would at 2.03.
  rig.act_at(1.93);
  const Verdict again = rig.verdict();
  CHECK(again.code == 24);
  CHECK(again.row == 5);
  CHECK(again.outcome == as_number(Outcome::refused));
  const std::uint64_t acts = rig.tick;
  CHECK(acts < last);
  for (int row = 2; row < 5; ++row) {
    CHECK(rig.lease().grants[0].until_tick <= acts);
    rig.act_at(1.93);
  }
}

TEST_CASE("realtime: what a push cut off stays cut off when the robot is back and has held") {
  Approach rig(false);
  const Verdict cut = rig.pushed_until_cut();
  REQUIRE(cut.row == 6);
  rig.positions[arm_1] = 1.5;
  rig.velocities[arm_1] = 0.5;  // from which rows of 1 rad/s may begin
  rig.hold();
  const SafeChunk again = rig.safe_chunk();
  CHECK(again.verdict_id > cut.verdict_id);
  CHECK(again.first_tick + again.horizon - 1 == cut.released_last);
}

TEST_CASE("realtime: no tick is granted whose row a push has cut off") {
  Approach rig(false);
  // Row 1 acts and ends at 1.93, row 2 at 1.98, row 3 would at 2.03.
  rig.velocities[arm_1] = 1.0;
  rig.act_at(1.88);
  CHECK(rig.verdict().row == 3);
  CHECK(rig.verdict().released_last == rig.tick + 1);
  CHECK(rig.lease().grants[0].until_tick == rig.tick + 1);
}

TEST_CASE(
    "realtime: a joint pushed out of its bounds is led back by the row after the one acting") {
  const auto stops = [](const Row& speeds) {
    TrackedRig rig(false, narrow);
    for (const double place : {0.5, 1.0, 1.5, 1.875, 1.875}) {
      rig.positions[arm_1] = place;
      rig.hold();
    }
    rig.begin(ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, speeds));
    rig.positions[arm_1] = 2.25;
    rig.act();
    return rig.stopped();
  };
  CHECK_FALSE(stops({0.0625, 0.0625, -0.0625, -0.0625, -0.0625}));
  CHECK(stops({0.0625, -0.0625, 0.0625, -0.0625, -0.0625}));
}
