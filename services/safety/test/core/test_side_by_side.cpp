// Two claims whose rows were judged beside each other: what one loses, the other is judged without.
//
// A sledge (base_y) carries a ball across the way of the tool, from 0.45 m right of it; the tool
// (arm_1) comes from 0.9 m behind and passes when the ball is through. Balls of 0.05 m, a clearance
// of 0.2 m: their centres stay 0.3 m apart.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted no_row{2, 0, 0};

void build(Limits& limits) {
  limits.period_ns = 8'000'000;  // so twelve rows can act before the next judgement
  limits.joints[arm_1].kind = JointKind::prismatic;
  for (const std::size_t j : {arm_1, base_y}) limits.joints[j].velocity_limit = 10.0;
  limits.parts[arm].modes.joint_velocity.step_limit[arm_1] = 10.0;
  limits.parts[base].modes.joint_velocity.step_limit[base_y] = 10.0;
  Kinematics& tree = limits.kinematics;
  tree.links[2].motion = LinkMotion::slide;
  tree.links[2].axis = {1.0, 0.0, 0.0};
  (void)tree.links.push_back(
      link("sledge", 0, LinkMotion::slide, base_y, {0, 1, 0}, {1.6, -0.45, 0.5}));
  limits.collision.capsules[0] = {5, {0, 0, 0}, {0, 0, 0}, 0.05};
  limits.collision.capsules[1] = {4, {0, 0, 0}, {0, 0, 0}, 0.05};
  limits.collision.clearance = 0.2;
  limits.parts[arm].modes.joint_velocity.gain = {1.0, 1.0};
  limits.parts[base].modes.joint_velocity.gain = {1.0, 1.0};
  // In the sledge's way once it is pushed to the side; its footprint is a square of 1 m.
  limits.base.reaction_s = 0.0001;
  Zone pillar{"pillar", true, {}};
  for (const Corner& corner :
       {Corner{0.7, 0.95}, Corner{1.2, 0.95}, Corner{1.2, 1.4}, Corner{0.7, 1.4}})
    (void)pillar.corners.push_back(corner);
  (void)limits.base.zones.push_back(pillar);
}

// Two claims; both go ahead by 0.05 m in each of 16 rows, of which the first is half of that.
struct TwoClaims : GateRig {
  explicit TwoClaims(bool tool_first, double tool_at = 0.0) : GateRig(false) {
    build(limits);
    positions[arm_1] = tool_at;
    restart(BootInfo{true, false, {}});
    connect_and_arm();
    const std::uint64_t first = claim_of({tool_first ? "arm" : "base"});
    const std::uint64_t second = claim_of({tool_first ? "base" : "arm"});
    tool_claim = tool_first ? first : second;
    sledge_claim = tool_first ? second : first;
    advance(0.0, no_row, no_row);
  }
  std::uint64_t claim_of(std::initializer_list<const char*> parts) {
    send(EventKind::claim, claim_request(parts));
    return reply<ClaimReply>().claim_id;
  }
  std::uint64_t begin(std::uint64_t claim, std::uint8_t part, std::uint8_t joint) {
    const Verdict verdict = ask(claim, part, joint);
    REQUIRE(verdict.code == 0);
    return verdict.verdict_id;
  }
  Verdict ask(std::uint64_t claim, std::uint8_t part, std::uint8_t joint) {
    claim_id = claim;
    return send_chunk(rows_ahead(part, joint));
  }
  ChunkBuilder rows_ahead(std::uint8_t part, std::uint8_t joint) {
    ChunkBuilder builder = chunk();
    builder.chunk.parts.clear();
    Row speeds(16, 6.25);
    speeds[0] = 3.125;
    builder.joint(part, Mode::joint_velocity, joint, speeds);
    ++builder.chunk.start_tick;
    return builder;
  }
  /// One tick later, in which both went ahead by `way`.
  void advance(double way, const Acted& sledge_did, const Acted& tool_did) {
    for (const std::uint64_t claim : {sledge_claim, tool_claim})
      send(EventKind::heartbeat, Heartbeat{claim}, "runner");
    positions[base_y] += way;
    positions[arm_1] += way;
    std::vector<Acted> acts(part_count, no_row);
    acts[base] = sledge_did;
    acts[fairlead::test::arm] = tool_did;
    next_tick_of(acts);
  }
  std::vector<Verdict> verdicts() const {
    std::vector<Verdict> found;
    for (const Output& output : out->items()) {
      if (output.kind != OutputKind::verdict) continue;
      Verdict& message = found.emplace_back();
      REQUIRE(decode(out->payload(output), message) == FrameFault::none);
    }
    return found;
  }
  std::uint64_t sledge_claim = 0, tool_claim = 0;
};

struct Crossing : TwoClaims {
  explicit Crossing(bool tool_first) : TwoClaims(tool_first) {
    sledge = begin(sledge_claim, base, base_y);
    tool = begin(tool_claim, fairlead::test::arm, arm_1);
    advance(0.0, no_row, no_row);
  }
  std::uint64_t sledge = 0, tool = 0;  // verdicts
};

}  // namespace

TEST_CASE("rows are judged again in the same step beside what another claim has left") {
  for (const bool tool_first : {true, false}) {
    CAPTURE(tool_first);
    Crossing rig(tool_first);
    rig.advance(0.025, Acted{0, rig.sledge, 0}, Acted{0, rig.tool, 0});
    CHECK(rig.verdicts().empty());
    // Pushed to the side, the sledge gets no farther than 0.45 m: after row 8 it is at 0.425 m
    // and its ball 0.025 m beside the tool's way. The tool is 0.325 m behind it after row 11,
    // and would be 0.275 m behind it after row 12.
    rig.positions[base_x] = 0.3;
    rig.advance(0.05, Acted{0, rig.sledge, 1}, Acted{0, rig.tool, 1});
    const std::vector<Verdict> verdicts = rig.verdicts();
    REQUIRE(verdicts.size() == 2);
    const Verdict& first = verdicts[0];
    const Verdict& then = verdicts[1];
    CHECK(first.claim_id == rig.sledge_claim);
    CHECK(first.code == 34);
    CHECK(first.row == 9);
    CHECK(first.released_last == rig.tick + 6);
    CHECK(then.claim_id == rig.tool_claim);
    CHECK(then.code == 32);
    CHECK(then.row == 12);
    CHECK(then.released_last == rig.tick + 9);
    CHECK(rig.count(OutputKind::safe_chunk) == 2);
  }
}

TEST_CASE("G030 where two claims hold rows, a new state gives half the looks to each") {
  // A rod beside all of the tool's way, 0.1 mm beyond the clearance: 8 looks for each of 12 rows
  // and 3 shares.
  for (const bool fingers_move : {false, true}) {
    CAPTURE(fingers_move);
    TwoClaims rig(true);
    rig.limits.collision.capsules[0] = {0, {-9, 0, 0.8001}, {9, 0, 0.8001}, 0.05};
    rig.limits.parts[fairlead::test::arm].modes.joint_velocity.gain = {1.0 - 1e-7, 1.0};
    rig.restart(BootInfo{true, false, {}});
    rig.connect_and_arm();
    rig.tool_claim = rig.claim_of({"arm"});
    rig.claim_id = rig.sledge_claim = rig.claim_of({"gripper"});
    rig.seq = 0;
    rig.advance(0.0, no_row, no_row);
    ChunkBuilder fingers = rig.rows_ahead(gripper, arm_1);
    fingers.chunk.parts.clear();
    fingers.scalar(gripper, Mode::gripper_position, Row(16, 0.04));
    if (fingers_move) REQUIRE(rig.send_chunk(fingers).code == 0);
    (void)rig.begin(rig.tool_claim, fairlead::test::arm, arm_1);
    rig.advance(0.0, no_row, no_row);
    const std::vector<Verdict> verdicts = rig.verdicts();
    REQUIRE(verdicts.size() == (fingers_move ? 1 : 0));
    if (!fingers_move) continue;
    CHECK(verdicts[0].claim_id == rig.tool_claim);
    CHECK(verdicts[0].code == 30);
    CHECK(verdicts[0].axis == "queries");
    CHECK(verdicts[0].limit == 256.0);
  }
}

TEST_CASE("realtime: rows of a claim that has ended count until its parts are seen to hold") {
  TwoClaims rig(true, 0.55);  // the tool stands 0.35 m behind the sledge's way
  const std::uint64_t sledge = rig.begin(rig.sledge_claim, base, base_y);
  const auto tool_code = [&rig] {
    return rig.ask(rig.tool_claim, fairlead::test::arm, arm_1).code;
  };
  rig.advance(0.0, no_row, no_row);  // the sledge's first row acts in this tick
  SUBCASE("it goes on") { CHECK(tool_code() == 32); }
  SUBCASE("it has ended") {
    rig.send(EventKind::release, Release{"runner", rig.sledge_claim});
    CHECK(tool_code() == 32);
    rig.positions[base_y] += 0.025;
    rig.advance(0.0, Acted{0, sledge, 0}, no_row);
    CHECK(tool_code() == 32);
    SUBCASE("and holds") {
      rig.advance(0.0, no_row, no_row);
      CHECK(tool_code() == 0);
    }
    SUBCASE("and its last grant is over") {
      for (int i = 1; i < 12; ++i) rig.advance(0.0, Acted{0, sledge, 1}, no_row);
      CHECK(tool_code() == 0);
    }
    SUBCASE("and the gate is armed anew") {
      rig.send(EventKind::disarm, Disarm{"me"});
      std::uint32_t code = 32;
      SUBCASE("at once") {}
      SUBCASE("a tick later") { rig.advance(0.0, Acted{0, sledge, 1}, no_row); }
      SUBCASE("after it is seen to hold") {
        rig.advance(0.0, no_row, no_row);
        code = 0;
      }
      SUBCASE("after its last grant") {
        for (int i = 1; i < 12; ++i) rig.advance(0.0, Acted{0, sledge, 1}, no_row);
        code = 0;
      }
      rig.epoch = rig.arm().epoch;
      rig.tool_claim = rig.claim_of({"arm"});
      rig.seq = 0;
      CHECK(tool_code() == code);
    }
  }
}

TEST_CASE("realtime: rows of a claim that has ended count for the next claim of one of its parts") {
  // Sledge and fingers are one claim, tool and fingers the next. Rows that move the fingers are
  // taken after a hold of these: if the former rows moved them, not before those are over.
  bool moved_fingers = false, moves_fingers = false;
  SUBCASE("fingers, then not") { moved_fingers = true; }
  SUBCASE("no fingers, then fingers") { moves_fingers = true; }
  SUBCASE("no fingers") {}
  SUBCASE("fingers twice") { moved_fingers = moves_fingers = true; }
  TwoClaims rig(true, 0.55);
  for (const std::uint64_t claim : {rig.tool_claim, rig.sledge_claim})
    rig.send(EventKind::release, Release{"runner", claim});
  const auto with_fingers = [](ChunkBuilder builder, bool fingers) {
    if (fingers) builder.scalar(gripper, Mode::gripper_position, Row(16, 0.04));
    return builder;
  };
  rig.claim_id = rig.sledge_claim = rig.claim_of({"base", "gripper"});
  rig.seq = 0;
  const Verdict sledge = rig.send_chunk(with_fingers(rig.rows_ahead(base, base_y), moved_fingers));
  REQUIRE(sledge.code == 0);
  bool acts = false, goes_on = false;
  SUBCASE("the first row acts already") { acts = true; }
  SUBCASE("the first row acts, and the next ones are of a chunk that moves the fingers") {
    acts = goes_on = true;
  }
  SUBCASE("the first row acts in the next tick") {}
  if (acts) rig.advance(0.0, no_row, no_row);
  if (goes_on) {
    rig.positions[base_y] = 0.145;  // the row that acts takes it to where the tool must not pass
    rig.advance(0.0, Acted{0, sledge.verdict_id, 0}, no_row);
    REQUIRE(rig.send_chunk(with_fingers(rig.rows_ahead(base, base_y), true)).code == 0);
  }
  rig.send(EventKind::release, Release{"runner", rig.sledge_claim});
  rig.claim_id = rig.tool_claim = rig.claim_of({"arm", "gripper"});
  rig.seq = 0;
  const ChunkBuilder next = with_fingers(rig.rows_ahead(fairlead::test::arm, arm_1), moves_fingers);
  CHECK(rig.send_chunk(next).code == (moved_fingers && moves_fingers ? 0 : 32));
}

TEST_CASE("realtime: rows of a claim that has ended are not judged again, wherever they lead") {
  for (const bool tool_first : {true, false}) {
    for (const bool ended : {false, true}) {
      CAPTURE(tool_first);
      CAPTURE(ended);
      Crossing rig(tool_first);
      rig.advance(0.025, Acted{0, rig.sledge, 0}, Acted{0, rig.tool, 0});
      if (ended) rig.send(EventKind::release, Release{"runner", rig.sledge_claim});
      rig.positions[base_x] = 0.3;  // pushed to the side, towards the pillar
      rig.advance(0.05, Acted{0, rig.sledge, 1}, Acted{0, rig.tool, 1});
      bool is_answered = false;
      for (const Verdict& verdict : rig.verdicts())
        is_answered |= verdict.claim_id == rig.sledge_claim;
      CHECK(is_answered == !ended);
    }
  }
}

TEST_CASE("realtime: the last row that an ended claim was granted counts while it may act") {
  // 75 ms of 8 ms each: ten ticks from its end on. The sledge's ball is 0.33 m beside the tool's
  // way; one row more takes it to 0.28 m.
  for (const int ticks : {9, 10, 11}) {
    CAPTURE(ticks);
    TwoClaims rig(true, 0.55);
    const std::uint64_t sledge = rig.begin(rig.sledge_claim, base, base_y);
    rig.advance(0.0, no_row, no_row);
    rig.send(EventKind::release, Release{"runner", rig.sledge_claim});
    for (int i = 0; i < ticks; ++i) {
      if (i == ticks - 1) rig.positions[base_y] = 0.12;
      rig.advance(0.0, Acted{0, sledge, static_cast<std::uint32_t>(i)}, no_row);
    }
    CHECK(rig.ask(rig.tool_claim, fairlead::test::arm, arm_1).code == (ticks <= 10 ? 32 : 0));
  }
}
