// G025: a composite switch turns (its number changes its sign) at standstill only, where the robot
// does not declare otherwise.

#include "acted_rows.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted hold{2, 0, 0};

ChunkBuilder switched(const Row& values) {
  return ChunkBuilder().scalar(composite, Mode::composite_mode, values);
}

// Of a robot whose switch turns at standstill only. The step limit admits a full turn.
struct Judged {
  Limits limits = test_limits();
  ClaimLimits claim;
  MeasuredState state = state_at_rest();
  PartMemories memories;

  Judged() {
    limits.parts[composite].modes.composite_mode.switches_anywhere = false;
    limits.parts[composite].modes.composite_mode.step_limit = 2.0;
    claim = whole_robot(limits);
  }
  Judgement of(const ChunkBuilder& next, const RowBefore& before = {}) const {
    return judge_rows(limits, claim, state, next.chunk, 0, before);
  }
  std::uint32_t after(double value, double next, bool measured = true) const {
    const ChunkBuilder previous = switched({value});
    return of(switched({next}), RowBefore{&previous.chunk, 0, measured, &memories}).evidence.code;
  }
};

}  // namespace

TEST_CASE("G025 the switch turns while every part of the claim stands still") {
  Judged robot;
  CHECK(robot.after(-1.0, 1.0) == 0);
  for (const std::size_t j : {base_x, arm_1, arm_2, gripper_joint}) {
    robot.state.velocities = {};
    robot.state.velocities[j] = just_below(0.05);
    CHECK(robot.after(-1.0, 1.0) == 0);
    for (const double speed : {0.05, -0.05, just_above(0.05), infinite, not_a_number}) {
      robot.state.velocities[j] = speed;
      CHECK(robot.after(-1.0, 1.0) == 25);
      CHECK(robot.after(1.0, -1.0) == 25);
      if (std::isfinite(speed)) CHECK(robot.after(-1.0, -0.5) == 0);
    }
  }
}

TEST_CASE("G025 the switch says which joint moves, how fast, and its limit") {
  Judged robot;
  robot.state.velocities[arm_2] = 0.25;
  const ChunkBuilder previous = switched({-1.0});
  const Evidence evidence = robot.of(switched({1.0}), RowBefore{&previous.chunk, 0}).evidence;
  CHECK(evidence.part == "composite");
  CHECK(evidence.axis == "arm_2");
  CHECK(evidence.value == 0.25);
  CHECK(evidence.limit == 0.05);
  CHECK(evidence.row == 0);
}

TEST_CASE("G025 zero counts as not below zero, from either side") {
  Judged robot;
  robot.state.velocities[base_x] = 1.0;
  CHECK(robot.after(-5e-324, 0.0) == 25);
  CHECK(robot.after(0.0, -5e-324) == 25);
  CHECK(robot.after(-0.0, 0.0) == 0);
  CHECK(robot.after(0.0, 1.0) == 0);
}

TEST_CASE("G025 a part that is not the claim's may move while the switch turns") {
  Judged robot;
  robot.claim.parts.clear();
  (void)robot.claim.parts.push_back(composite);
  (void)robot.claim.parts.push_back(arm);
  robot.state.velocities[base_x] = 1.0;
  CHECK(robot.after(-1.0, 1.0) == 0);
  robot.state.velocities[arm_1] = 0.05;
  CHECK(robot.after(-1.0, 1.0) == 25);
}

TEST_CASE("G025 a switch that may turn anywhere turns anywhere") {
  Judged robot;
  robot.claim.modes[composite].composite_mode.switches_anywhere = true;
  robot.state.velocities[base_x] = 1.0;
  CHECK(robot.after(-1.0, 1.0) == 0);
  CHECK(robot.after(-1.0, 1.0, false) == 0);
  CHECK(robot.of(switched({1.0, -1.0, 1.0})).outcome == Outcome::released);
}

TEST_CASE("G025 within a chunk the switch does not turn: standstill there is not measured yet") {
  const Judged robot;  // stands still
  const Judgement judgement = robot.of(switched({-1.0, -0.5, 0.5, -1.0}));
  CHECK(judgement.outcome == Outcome::truncated);
  CHECK(judgement.row_count == 2);
  CHECK(judgement.evidence.code == 25);
  CHECK(judgement.evidence.row == 2);
  CHECK(judgement.evidence.axis == "composite");
  CHECK(judgement.evidence.value == 0.5);
  CHECK(judgement.evidence.limit == -0.5);
  CHECK(robot.of(switched({0.5, 0.0, -5e-324})).row_count == 2);
}

TEST_CASE("G025 realtime: the switch turns only after a tick without a row") {
  Judged robot;
  CHECK(robot.after(-1.0, 1.0, false) == 25);  // stands still, but a row acts from now on
  robot.memories[composite].composite = Switch::negative;
  const RowBefore held{nullptr, 0, false, &robot.memories};
  CHECK(robot.of(switched({1.0}), held).outcome == Outcome::released);
  robot.memories[base].kind = PartMemory::Kind::known;  // a row has acted since it stood still
  CHECK(robot.of(switched({1.0}), held).evidence.code == 25);
  CHECK(robot.of(switched({-1.0}), held).outcome == Outcome::released);
}

TEST_CASE("G025 left out of the row that acts, the switch is down, whatever it was before") {
  Judged robot;
  robot.memories[composite].composite = Switch::positive;
  const ChunkBuilder without = ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.01});
  const RowBefore before{&without.chunk, 0, false, &robot.memories};
  CHECK(robot.of(switched({1.0}), before).evidence.code == 25);
  CHECK(robot.of(switched({-1.0}), before).evidence.code != 25);
}

TEST_CASE("G025 a switch that is up is not turned down by leaving it out, but at standstill") {
  Judged robot;
  const ChunkBuilder without = ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.01, 0.01});
  const auto after = [&](double value, bool measured) {
    const ChunkBuilder previous = switched({value});
    return robot.of(without, RowBefore{&previous.chunk, 0, measured, &robot.memories}).evidence;
  };
  CHECK(after(1.0, true).code == 0);
  CHECK(after(-1.0, false).code == 0);
  const Evidence left_out = after(0.0, false);
  CHECK(left_out.code == 25);
  CHECK(left_out.row == 0);
  CHECK(left_out.part == "composite");
  CHECK(left_out.axis == "composite left out");
  CHECK(left_out.value == -1.0);
  robot.state.velocities[arm_2] = 0.25;
  CHECK(after(1.0, true).axis == "arm_2");
  CHECK(after(-1.0, true).code == 0);
  robot.memories[composite].composite = Switch::positive;  // and a tick without a row
  const RowBefore held{nullptr, 0, true, &robot.memories};
  CHECK(robot.of(without, held).evidence.code == 25);
  robot.memories[composite].composite = Switch::unknown;
  CHECK(robot.of(without, held).evidence.code == 25);
  robot.memories[composite].composite = Switch::none;
  CHECK(robot.of(without, held).evidence.code == 0);
  robot.memories[composite].composite = Switch::positive;
  robot.claim.modes[composite].composite_mode.switches_anywhere = true;
  CHECK(robot.of(without, held).evidence.code == 0);
  robot.claim = whole_robot(robot.limits);
  robot.claim.parts.clear();
  (void)robot.claim.parts.push_back(gripper);  // whose switch is not this claim's
  robot.state.velocities[gripper_joint] = 0.25;
  CHECK(robot.of(without, held).evidence.code == 0);
}

TEST_CASE("G025 the row that acted last is remembered over holds, claims and standstill") {
  for (const bool lockstep : {true, false}) {
    GateRig rig(lockstep);
    rig.limits.parts[composite].modes.composite_mode.switches_anywhere = false;
    rig.limits.parts[composite].modes.composite_mode.step_limit = 2.0;
    rig.restart(BootInfo{true, false, {}});
    rig.ready();
    const auto send = [&rig, lockstep](double value) {
      ChunkBuilder chunk = rig.chunk({0.0});
      chunk.chunk.start_tick += lockstep ? 0 : 1;
      chunk.chunk.parts.clear();
      return rig.send_chunk(chunk.scalar(composite, Mode::composite_mode, {value})).code;
    };
    rig.velocities[base_x] = 0.5;
    rig.next_tick(hold);
    REQUIRE(send(1.0) == 0);  // nothing known since arming: either side may start
    const SafeChunk safe = rig.safe_chunk();
    if (!lockstep) rig.next_tick(hold);
    rig.next_tick_of({hold, hold, hold, row_of(safe, 0)});
    rig.next_tick(hold);
    CHECK(send(-1.0) == 25);
    CHECK(send(0.5) == 0);
    rig.send(EventKind::release, Release{"runner", rig.claim_id});
    rig.take_claim();
    rig.seq = 0;
    rig.next_tick(hold);
    rig.next_tick(hold);
    CHECK(send(-1.0) == 25);
    rig.velocities[base_x] = 0.0;
    rig.next_tick(hold);
    CHECK(send(-1.0) == 0);
  }
}

TEST_CASE("G025 a switch that rows have left out is down, also after a hold in motion") {
  bool ends = false;
  std::size_t told = gripper;
  SUBCASE("under its claim") {}
  SUBCASE("by rows of the first part") { told = arm; }
  SUBCASE("whose claim ended before the state came that tells of them") { ends = true; }
  GateRig rig(true);
  rig.limits.parts[composite].modes.composite_mode.switches_anywhere = false;
  rig.limits.parts[composite].modes.composite_mode.step_limit = 2.0;
  rig.restart(BootInfo{true, false, {}});
  rig.ready();
  const auto send = [&rig, told](bool switched_up) {
    ChunkBuilder chunk = rig.chunk({0.0});
    chunk.chunk.parts.clear();
    if (told == arm)
      chunk.joint(arm, Mode::joint_position, arm_1, {0.0});
    else
      chunk.scalar(gripper, Mode::gripper_position, {0.01});
    if (switched_up) chunk.scalar(composite, Mode::composite_mode, {1.0});
    return rig.send_chunk(chunk).code;
  };
  const auto act = [&rig, told](const SafeChunk& safe, bool composite_acts) {
    std::vector<Acted> acted;
    for (std::size_t part = 0; part < rig.limits.parts.size(); ++part) {
      const bool acts = part == told || (part == composite && composite_acts);
      acted.push_back(acts ? row_of(safe, 0) : hold);
    }
    rig.next_tick_of(acted);
  };
  rig.next_tick(hold);
  REQUIRE(send(true) == 0);
  act(rig.safe_chunk(), true);
  REQUIRE(send(false) == 0);  // at standstill it may be left out
  const SafeChunk without = rig.safe_chunk();
  rig.velocities[base_x] = 0.5;
  if (ends) rig.send(EventKind::release, Release{"runner", rig.claim_id});
  act(without, false);
  if (ends) {
    rig.take_claim();
    rig.seq = 0;
  }
  rig.next_tick(hold);
  CHECK(send(true) == 25);
  CHECK(send(false) == 0);
}

TEST_CASE("G025 rows of another claim say nothing of a switch that is not theirs") {
  GateRig rig(true);
  rig.limits.parts[composite].modes.composite_mode.switches_anywhere = false;
  rig.limits.parts[composite].modes.composite_mode.step_limit = 2.0;
  rig.restart(BootInfo{true, false, {}});
  rig.connect_and_arm();
  rig.send(EventKind::claim, rig.claim_request({"arm", "gripper", "composite"}));
  rig.claim_id = rig.reply<ClaimReply>().claim_id;
  Claim driving = rig.claim_request({"base"});
  driving.source = "driver";
  rig.send(EventKind::claim, driving);
  const std::uint64_t driver_id = rig.reply<ClaimReply>().claim_id;
  const auto grip = [&rig](bool switched_up) {
    ChunkBuilder chunk = rig.chunk({0.0});
    chunk.chunk.parts.clear();
    chunk.scalar(gripper, Mode::gripper_position, {0.01});
    if (switched_up) chunk.scalar(composite, Mode::composite_mode, {1.0});
    return rig.send_chunk(chunk);
  };
  const auto drive = [&rig, driver_id] {
    ChunkBuilder chunk = rig.chunk({0.0});
    chunk.chunk.source = "driver";
    chunk.chunk.claim_id = driver_id;
    const Verdict verdict = rig.send_chunk(chunk, "driver");
    REQUIRE(verdict.code == 0);
    return Acted{0, verdict.verdict_id, 0};
  };
  rig.next_tick(hold);
  const Verdict up = grip(true);
  REQUIRE(up.code == 0);
  const Acted gripped{0, up.verdict_id, 0};
  std::vector<Acted> acted(rig.limits.parts.size(), hold);
  acted[base] = drive();
  acted[gripper] = acted[composite] = gripped;
  rig.next_tick_of(acted);
  acted.assign(acted.size(), hold);
  acted[base] = drive();
  rig.velocities[arm_1] = 0.5;
  rig.next_tick_of(acted);
  CHECK(grip(false).code == 25);  // it is still up: nobody left it out
}
