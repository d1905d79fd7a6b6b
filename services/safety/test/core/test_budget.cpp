// What a claim may ask for, at each limit, and what its limits then bind.

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

bool admits(const Claim& request) {
  GateRig rig;
  rig.connect_and_arm();
  rig.send(EventKind::claim, request);
  return rig.count(OutputKind::refusal) == 0;
}

Claim any_claim() { return GateRig().claim_request(); }

constexpr auto number = [](Mode mode) { return static_cast<std::uint8_t>(mode); };

// The claim's limit that refuses a chunk, with one override.
Verdict judged_under(const LimitOverride& wanted, ChunkBuilder (*rows)(GateRig&)) {
  GateRig rig(true);
  rig.connect_and_arm();
  Claim request = rig.claim_request();
  (void)request.limits.push_back(wanted);
  rig.send(EventKind::claim, request);
  REQUIRE(rig.count(OutputKind::refusal) == 0);
  rig.claim_id = rig.reply<ClaimReply>().claim_id;
  return rig.send_chunk(rows(rig));
}

ChunkBuilder of(GateRig& rig, const ChunkBuilder& parts) {
  ChunkBuilder builder = rig.chunk();
  ChunkBuilder only = parts;
  const ActionChunk head = builder.chunk;
  only.chunk.session = head.session;
  only.chunk.epoch = head.epoch;
  only.chunk.claim_id = head.claim_id;
  only.chunk.seq = head.seq;
  only.chunk.obs_tick = only.chunk.oldest_tick = only.chunk.start_tick = head.start_tick;
  return only;
}

}  // namespace

TEST_CASE("a claim's budget up to and including its limits") {
  Claim request = any_claim();
  request.horizon_max = 1;
  CHECK(admits(request));
  request.horizon_max = 64;
  CHECK(admits(request));
  request.age_max_ticks = 10;
  CHECK(admits(request));
  request.age_max_ticks = 0;
  CHECK(admits(request));
  request.chunk_rate_hz = 20.0;
  CHECK(admits(request));
  request.chunk_rate_hz = 1e-300;
  CHECK(admits(request));
  request.chunk_rate_hz = -1e-300;
  CHECK_FALSE(admits(request));
}

TEST_CASE("G010 the window of a slow claim is two of its chunks") {
  // 2 Hz: 1 s, 20 ticks; ceil(1.2 x 2 x 1) + 1 = 4 chunks. In realtime every chunk counts.
  GateRig rig;
  rig.connect_and_arm();
  Claim request = rig.claim_request();
  request.chunk_rate_hz = 2.0;
  rig.send(EventKind::claim, request);
  rig.claim_id = rig.reply<ClaimReply>().claim_id;
  const auto chunk_code = [&rig] {
    rig.send_heartbeat();
    return rig.send_chunk(rig.chunk({0.0, 0.0, 0.0, 0.0})).code;
  };
  for (int i = 0; i < 4; ++i) CHECK(chunk_code() == 0);
  CHECK(chunk_code() == 10);
  for (int i = 0; i < 19; ++i) {
    rig.send_heartbeat();
    rig.next_tick();
  }
  CHECK(chunk_code() == 10);
  rig.next_tick();
  CHECK(chunk_code() == 0);
}

TEST_CASE("G010 a claim so slow that its window has no end is still counted") {
  GateRig rig;
  rig.connect_and_arm();
  Claim request = rig.claim_request();
  request.chunk_rate_hz = 1e-12;
  rig.send(EventKind::claim, request);
  rig.claim_id = rig.reply<ClaimReply>().claim_id;
  // ceil(1.2 x rate x 5e7 s) + 1 = 2.
  for (const std::uint32_t code : {0U, 0U, 10U}) {
    CHECK(rig.send_chunk(rig.chunk({0.0, 0.0, 0.0, 0.0})).code == code);
  }
}

TEST_CASE("each tightened limit is the one that binds") {
  const auto steps = [](GateRig& rig) {
    return of(rig, ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.0, 0.02}));
  };
  Verdict verdict =
      judged_under({"arm", number(Mode::cartesian_delta), "linear_step_limit", 0.01}, steps);
  CHECK(verdict.code == 22);
  CHECK(verdict.axis == "linear");
  CHECK(verdict.limit == 0.01);
  const auto turns = [](GateRig& rig) {
    return of(rig, ChunkBuilder().along(arm, Mode::cartesian_delta, 3, {0.0, 0.02}));
  };
  verdict = judged_under({"arm", number(Mode::cartesian_delta), "angular_step_limit", 0.01}, turns);
  CHECK(verdict.code == 22);
  CHECK(verdict.axis == "angular");
  CHECK(verdict.limit == 0.01);
  const auto opens = [](GateRig& rig) {
    return of(rig, ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.04, 0.05}));
  };
  verdict = judged_under({"gripper", number(Mode::gripper_position), "step_limit", 0.005}, opens);
  CHECK(verdict.code == 22);
  CHECK(verdict.limit == 0.005);
  verdict = judged_under({"gripper", number(Mode::gripper_position), "upper", 0.045}, opens);
  CHECK(verdict.code == 20);
  CHECK(verdict.limit == 0.045);
  const auto closes = [](GateRig& rig) {
    return of(rig, ChunkBuilder().scalar(gripper, Mode::gripper_position, {0.04, 0.03}));
  };
  verdict = judged_under({"gripper", number(Mode::gripper_position), "lower", 0.035}, closes);
  CHECK(verdict.code == 20);
  CHECK(verdict.limit == 0.035);
}

TEST_CASE("a claim that lowers a limit twice keeps the lower one, and may not raise it again") {
  GateRig rig;
  rig.connect_and_arm();
  Claim request = rig.claim_request();
  (void)request.limits.push_back({"arm", number(Mode::cartesian_delta), "linear_limit", 0.05});
  (void)request.limits.push_back({"arm", number(Mode::cartesian_delta), "linear_limit", 0.08});
  rig.send(EventKind::claim, request);
  CHECK(rig.refusal().reason ==
        "limits: arm cartesian_delta linear_limit: expected above 0 and at most 0.05, got 0.08");
}
