// Who gets a claim, and with which limits.

#include <string>

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

std::string refusal_of(GateRig& rig, const Claim& request) {
  rig.send(EventKind::claim, request);
  return rig.count(OutputKind::refusal) == 0 ? "" : std::string(rig.refusal().reason.view());
}

std::string refusal_with(const LimitOverride& wanted) {
  GateRig rig;
  rig.connect_and_arm();
  Claim request = rig.claim_request();
  (void)request.limits.push_back(wanted);
  return refusal_of(rig, request);
}

constexpr auto number = [](Mode mode) { return static_cast<std::uint8_t>(mode); };

}  // namespace

TEST_CASE("a claim is given only while armed, and the refusal names the command") {
  GateRig rig;
  rig.send(EventKind::claim, rig.claim_request());
  CHECK(rig.refusal().reason == "the gate is disarmed, not armed; started");
  CHECK(rig.refusal().fix == "fairlead arm");
  CHECK(rig.refusal().who == "safety");
}

TEST_CASE("a claim says who it is for: source, robot, period and skill are checked once, here") {
  GateRig rig;
  rig.connect_and_arm();
  Claim request = rig.claim_request();
  std::string expected;
  SUBCASE("source") {
    request.source = "Run/ner";
    expected =
        "source: expected 1 to 64 of a-z 0-9 _ . - starting with a letter or digit, got 'Run/ner'";
  }
  SUBCASE("no source") {
    request.source = "";
    expected = "source: expected 1 to 64 of a-z 0-9 _ . - starting with a letter or digit, got ''";
  }
  SUBCASE("robot") {
    request.robot_hash = hash_of(8);
    expected = "robot_hash is not that of test_robot";
  }
  SUBCASE("period") {
    request.period_ns = 1;
    expected = "period: expected 50000000 ns, got 1 ns";
  }
  SUBCASE("skill") {
    request.skill_hash = Hash{};
    expected = "skill_hash: expected the skill's hash, got none";
  }
  SUBCASE("no part") {
    request.parts.clear();
    expected = "parts: expected at least one";
  }
  SUBCASE("unknown part") {
    request.parts[1] = "tail";
    expected = "parts: no part tail; known: arm, gripper, base, composite";
  }
  SUBCASE("part twice") {
    request.parts[1] = "arm";
    expected = "parts: arm is named twice";
  }
  SUBCASE("rate 0") {
    request.chunk_rate_hz = 0.0;
    expected = "chunk_rate_hz: expected above 0 and at most 20, got 0";
  }
  SUBCASE("rate above") {
    request.chunk_rate_hz = 20.5;
    expected = "chunk_rate_hz: expected above 0 and at most 20, got 20.5";
  }
  SUBCASE("rate nan") {
    request.chunk_rate_hz = not_a_number;
    expected = "chunk_rate_hz: expected above 0 and at most 20, got nan";
  }
  SUBCASE("horizon 0") {
    request.horizon_max = 0;
    expected = "horizon_max: expected 1 to 64, got 0";
  }
  SUBCASE("horizon") {
    request.horizon_max = 65;
    expected = "horizon_max: expected 1 to 64, got 65";
  }
  SUBCASE("age") {
    request.age_max_ticks = 11;
    expected = "age_max_ticks: expected at most 10, got 11";
  }
  CHECK(refusal_of(rig, request) == expected);
  CHECK(rig.status().claims.empty());
}

TEST_CASE("the log names who claims, where the claim says it") {
  GateRig rig;
  rig.connect_and_arm();
  const auto logged = [&rig](const Claim& claim) {
    rig.send(EventKind::claim, claim);
    const std::uint64_t id = rig.reply<ClaimReply>().claim_id;
    const Bytes line = rig.out->payload(rig.out->items()[0]);
    const std::string text(line.begin(), line.end());
    rig.send(EventKind::release, Release{"runner", id});
    return text.substr(22);
  };
  Claim claim = rig.claim_request();
  claim.by = "ada@lab (fairlead run)";
  CHECK(logged(claim) == " of runner for test-skill, by ada@lab (fairlead run)");
  claim.by.clear();
  CHECK(logged(claim) == " of runner for test-skill");
}

TEST_CASE("who claims is not who claimed before, where a claim does not say it") {
  GateRig rig;
  rig.connect_and_arm();
  Claim claim = rig.claim_request();
  claim.by = "ada";
  auto frame = frame_of(claim);
  rig.send_frame(EventKind::claim, frame);
  rig.send(EventKind::release, Release{"runner", rig.reply<ClaimReply>().claim_id});
  frame.resize(frame.size() - 4);  // "ada" and its head
  --frame[0];                      // one field fewer
  rig.send_frame(EventKind::claim, frame);
  const Bytes line = rig.out->payload(rig.out->items()[0]);
  CHECK(std::string(line.begin(), line.end()).ends_with(" of runner for test-skill"));
}

TEST_CASE("a held part is refused with the name of its holder; free parts are given") {
  GateRig rig;
  rig.connect_and_arm();
  CHECK(refusal_of(rig, rig.claim_request({"arm", "gripper"})).empty());
  Claim second = rig.claim_request({"base", "gripper"});
  second.source = "planner";
  CHECK(refusal_of(rig, second) == "part gripper is held by runner (test-skill)");
  CHECK(rig.refusal().fix == "fairlead cancel runner (if no runner: end it where it began)");
  second.parts.erase_at(1);
  CHECK(refusal_of(rig, second).empty());
  CHECK(rig.status().claims.size() == 2);
  CHECK(rig.status().claims[1].source == "planner");
}

TEST_CASE("a composite switch goes with each part whose tool it switches, and with nothing else") {
  GateRig rig;
  rig.connect_and_arm();
  const char* refusal = "parts: expected arm with composite, the switch of its motion";
  CHECK(refusal_of(rig, rig.claim_request({"composite"})) == refusal);
  CHECK(refusal_of(rig, rig.claim_request({"base", "composite", "gripper"})) == refusal);
  CHECK(refusal_of(rig, rig.claim_request({"composite", "arm"})).empty());
}

TEST_CASE("two claims are judged side by side, each with its own chunks") {
  GateRig rig(true);
  rig.connect_and_arm();
  rig.send(EventKind::claim, rig.claim_request({"arm"}));
  rig.send(EventKind::claim, rig.claim_request({"base"}));
  rig.claim_id = rig.reply<ClaimReply>().claim_id;
  CHECK(rig.send_chunk(rig.chunk()).code == 0);
  const Lease lease = rig.lease();
  REQUIRE(lease.grants.size() == 2);
  CHECK(lease.grants[0].decision == static_cast<std::uint8_t>(Decision::undecided));
  CHECK(lease.grants[1].decision == static_cast<std::uint8_t>(Decision::row));
}

TEST_CASE("a claim's limits may be tighter or equal, never looser, and must exist") {
  CHECK(refusal_with({"arm", number(Mode::cartesian_delta), "linear_limit", 0.1}).empty());
  CHECK(refusal_with({"arm", number(Mode::cartesian_delta), "angular_limit", 0.2}).empty());
  CHECK(refusal_with({"arm", number(Mode::cartesian_delta), "linear_step_limit", 0.01}).empty());
  CHECK(refusal_with({"base", number(Mode::body_twist), "angular_step_limit", 0.01}).empty());
  CHECK(refusal_with({"base", number(Mode::joint_velocity), "step_limit", 0.5}).empty());
  CHECK(refusal_with({"arm", number(Mode::joint_position), "step_limit", 0.1}).empty());
  CHECK(refusal_with({"gripper", number(Mode::gripper_position), "lower", 0.01}).empty());
  CHECK(refusal_with({"gripper", number(Mode::gripper_position), "upper", 0.07}).empty());
  CHECK(refusal_with({"composite", number(Mode::composite_mode), "step_limit", 0.5}).empty());
  CHECK(refusal_with({"arm", number(Mode::cartesian_delta), "linear_limit", 0.11}) ==
        "limits: arm cartesian_delta linear_limit: expected above 0 and at most 0.1, got 0.11");
  for (const double bad : {0.0, -1.0, infinite, not_a_number}) {
    CHECK_FALSE(refusal_with({"arm", number(Mode::cartesian_delta), "linear_limit", bad}).empty());
    CHECK_FALSE(refusal_with({"base", number(Mode::joint_velocity), "step_limit", bad}).empty());
  }
  for (const double bad : {-0.01, 0.08, infinite, not_a_number})
    CHECK_FALSE(refusal_with({"gripper", number(Mode::gripper_position), "lower", bad}).empty());
  for (const double bad : {0.081, 0.0, infinite, not_a_number})
    CHECK_FALSE(refusal_with({"gripper", number(Mode::gripper_position), "upper", bad}).empty());
  CHECK(refusal_with({"gripper", number(Mode::gripper_position), "lower", 0.2}) ==
        "limits: gripper gripper_position lower: expected at least 0 and below upper, 0.08, got "
        "0.2");
  CHECK(refusal_with({"gripper", number(Mode::gripper_position), "upper", 0.0}) ==
        "limits: gripper gripper_position upper: expected above lower, 0, and at most 0.08, got 0");
  CHECK(refusal_with({"tail", number(Mode::cartesian_delta), "linear_limit", 0.1}) ==
        "limits: tail is not a part of this claim");
  CHECK(refusal_with({"arm", number(Mode::body_twist), "linear_limit", 0.1}) ==
        "limits: arm has no mode body_twist (7)");
  CHECK(refusal_with({"arm", 200, "linear_limit", 0.1}) == "limits: arm has no mode unknown (200)");
  CHECK(refusal_with({"arm", number(Mode::cartesian_delta), "speed", 0.1}) ==
        "limits: arm cartesian_delta has no limit speed");
  CHECK_FALSE(refusal_with({"gripper", number(Mode::gripper_position), "speed", 0.1}).empty());
  CHECK_FALSE(refusal_with({"base", number(Mode::joint_velocity), "speed", 0.1}).empty());
}

TEST_CASE("a tightened limit binds this claim and is gone with it") {
  GateRig rig;
  rig.connect_and_arm();
  Claim request = rig.claim_request();
  (void)request.limits.push_back({"base", number(Mode::joint_velocity), "step_limit", 0.25});
  rig.send(EventKind::claim, request);
  rig.claim_id = rig.reply<ClaimReply>().claim_id;
  CHECK(rig.send_chunk(rig.chunk({0.5, 0.5})).code == 21);
  rig.send(EventKind::release, Release{"runner", rig.claim_id});
  rig.take_claim();
  rig.seq = 0;
  CHECK(rig.send_chunk(rig.chunk({0.5, 0.5})).code == 0);
}

TEST_CASE("there is room for eight claims") {
  // The test robot has four parts; the table itself is asked through a robot of eight.
  GateRig rig;
  Limits& limits = rig.limits;
  limits.parts[composite].modes = limits.parts[gripper].modes;  // a switch goes with its arm
  for (const char* name : {"five", "six", "seven", "eight"}) {
    PartLimits extra = limits.parts[composite];
    extra.name = name;
    (void)limits.parts.push_back(extra);
  }
  rig.restart(BootInfo{true, false, {}});
  rig.send_hal_status();
  JointState state;
  state.session = rig.session;
  state.tick = rig.tick;
  const std::vector<double> zeros(measured_count, 0.0);
  const Bytes block(reinterpret_cast<const std::uint8_t*>(zeros.data()),
                    zeros.size() * sizeof(double));
  state.positions = state.velocities = state.efforts = NumberView(block);
  (void)state.acted.resize(8);
  state.robot_hash = hash_of(7);
  rig.send(EventKind::joint_state, state);
  rig.arm();
  for (const char* name : {"arm", "gripper", "base", "composite", "five", "six", "seven", "eight"})
    CHECK(refusal_of(rig, rig.claim_request({name})).empty());
  CHECK(refusal_of(rig, rig.claim_request({"arm"})) == "all 8 claims are taken");
  CHECK(rig.status().claims.size() == 8);
}

TEST_CASE("a claim may lower its joint velocities, and never raise them") {
  GateRig rig;
  rig.connect_and_arm();
  Claim claim = rig.claim_request();
  const auto mode = static_cast<std::uint8_t>(Mode::joint_velocity);
  (void)claim.limits.push_back(LimitOverride{"base", mode, "velocity_limit", just_above(1.5)});
  rig.send(EventKind::claim, claim);
  CHECK(rig.count(OutputKind::refusal) == 1);
  claim.limits[0].value = 0.4;
  rig.send(EventKind::claim, claim);
  rig.claim_id = rig.reply<ClaimReply>().claim_id;
  CHECK(rig.send_chunk(rig.chunk({0.4, 0.4})).code == 0);
  CHECK(rig.send_chunk(rig.chunk({0.4, just_above(0.4)})).code == 20);
}

TEST_CASE("a claim may lower its steps and shrink its box, and never loosen them") {
  const auto pose = number(Mode::cartesian_pose);
  const auto target = number(Mode::joint_position);
  const auto twist = number(Mode::cartesian_twist);
  const auto refused = [](std::uint8_t mode, const char* name, double value) {
    return refusal_with({"arm", mode, name, value});
  };
  CHECK(refused(target, "step_limit", 0.25).empty());
  CHECK(refused(target, "step_limit", just_above(0.25)) ==
        "limits: arm joint_position step_limit: expected above 0 and at most 0.25, got "
        "0.25000000000000006");
  CHECK_FALSE(refused(target, "velocity_limit", 1.0).empty());
  for (const char* name : {"lower_x", "lower_y", "lower_z"}) {
    for (const double fine : {-1.0, 0.0, just_below(1.0)}) CHECK(refused(pose, name, fine).empty());
    for (const double bad : {just_below(-1.0), 1.0, not_a_number})
      CHECK_FALSE(refused(pose, name, bad).empty());
  }
  for (const char* name : {"upper_x", "upper_y", "upper_z"}) {
    for (const double fine : {1.0, 0.0, just_above(-1.0)}) CHECK(refused(pose, name, fine).empty());
    for (const double bad : {just_above(1.0), -1.0, not_a_number})
      CHECK_FALSE(refused(pose, name, bad).empty());
  }
  CHECK(refused(pose, "linear_step_limit", 0.05).empty());
  CHECK_FALSE(refused(pose, "linear_step_limit", just_above(0.05)).empty());
  CHECK(refused(pose, "angular_step_limit", 0.25).empty());
  CHECK_FALSE(refused(pose, "angular_step_limit", just_above(0.25)).empty());
  CHECK(refused(pose, "lower", 0.0) == "limits: arm cartesian_pose has no limit lower");
  CHECK(refused(twist, "angular_limit", 1.0).empty());
  CHECK_FALSE(refused(twist, "angular_limit", just_above(1.0)).empty());
  CHECK(refusal_with({"gripper", number(Mode::gripper_binary), "step_limit", 0.5}) ==
        "limits: gripper gripper_binary has no limit step_limit");
}
