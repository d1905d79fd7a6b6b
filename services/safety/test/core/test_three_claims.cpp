// Three claims whose ways cross: what one loses costs the next, and what that loses the third.
//
// The crosser goes along y, through the runner's way at the origin before the runner comes there.
// The runner goes along x, through the way of the last, which goes along y at x = -0.06, before the
// last comes there. Balls of 0.01 m, a clearance of 0.03 m: centres stay 0.05 m apart. The claims
// were taken last first: each is judged again only in the round after the one before it was cut.

#include "acted_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr Acted no_row{2, 0, 0};
enum Part : std::uint8_t { crosser, runner, last };
enum Joint : std::uint8_t { crosser_y, crosser_x, runner_x, last_y };  // nobody tells crosser_x
constexpr std::array<std::uint8_t, 3> told{crosser_y, runner_x, last_y};

void add_part(Limits& limits, const char* name, std::initializer_list<std::size_t> joints) {
  PartLimits made = part(name, joints);
  made.modes.joint_velocity = joint_mode(joints, 10.0);
  made.modes.joint_velocity.gain = {1.0, 1.0};
  widen(made);
  (void)limits.parts.push_back(made);
}

void add_shapes(Limits& limits) {
  for (const std::size_t moved : {2UL, 3UL, 4UL})
    (void)limits.collision.capsules.push_back({moved, {0, 0, 0}, {0, 0, 0}, 0.01});
  (void)limits.collision.pairs.push_back({0, 1});
  (void)limits.collision.pairs.push_back({1, 2});
  limits.collision.clearance = 0.03;
  limits.collision.source = "test shape";
  limits.workspace = wide_workspace();
  // Beside the crosser's way, and in it once it has been pushed aside.
  (void)limits.workspace.volumes.push_back({"post", true, {0.015, 0.03, -1}, {0.1, 0.1, 1}});
}

Limits crossing() {
  constexpr auto slide = LinkMotion::slide;
  Limits limits;
  limits.robot = "test_robot";
  limits.profile = "sim";
  limits.robot_hash = hash_of(7);
  limits.config_hash = hash_of(9);
  limits.period_ns = 8'000'000;  // so twelve rows can act before the next judgement
  limits.lockstep_allowed = true;
  const auto add_joint = [&limits](const char* name, std::size_t of) {
    (void)limits.joints.push_back(joint(name, of, JointKind::prismatic, true));
    limits.joints[limits.joints.size() - 1].velocity_limit = 10.0;
  };
  add_joint("crosser_y", crosser);
  add_joint("crosser_x", crosser);
  add_joint("runner_x", runner);
  add_joint("last_y", last);
  Link root;
  root.name = "base_link";
  limits.kinematics = tree_of({root, link("aside", 0, slide, crosser_x, {1, 0, 0}, {0, -0.2, 0}),
                               link("crosser", 1, slide, crosser_y, {0, 1, 0}, {0, 0, 0}),
                               link("runner", 0, slide, runner_x, {1, 0, 0}, {-0.4, 0, 0}),
                               link("last", 0, slide, last_y, {0, 1, 0}, {-0.06, -0.6, 0})});
  add_part(limits, "crosser", {crosser_y, crosser_x});
  add_part(limits, "runner", {runner_x});
  add_part(limits, "last", {last_y});
  add_shapes(limits);
  limits.protocol = protocol();
  return limits;
}

// All three are told to go ahead by 0.05 m a row, for sixteen rows.
struct Queue : GateRig {
  Queue() : GateRig(false) {
    limits = crossing();
    part_count = 3;
    positions = velocities = efforts = std::vector<double>(4, 0.0);
    restart(BootInfo{true, false, {}});
    connect_and_arm();
    claims[last] = claim_of("last");
    claims[runner] = claim_of("runner");
    claims[crosser] = claim_of("crosser");
    advance(0.0, {no_row, no_row, no_row});
    for (const Part part : {crosser, runner, last}) begin(part);
    advance(0.0, {no_row, no_row, no_row});
  }
  std::uint64_t claim_of(const char* part) {
    send(EventKind::claim, claim_request({part}));
    return reply<ClaimReply>().claim_id;
  }
  void begin(Part part) {
    claim_id = claims[part];
    ChunkBuilder builder = chunk();
    builder.chunk.parts.clear();
    Row speeds(4, 0.0);
    speeds[told[part]] = 6.25;
    builder.add(part, Mode::joint_velocity, Rows(16, speeds), {told[part]});
    ++builder.chunk.start_tick;
    const Verdict verdict = send_chunk(builder);
    REQUIRE(verdict.code == 0);
    released[part] = verdict.verdict_id;
  }
  void advance(double way, const std::vector<Acted>& did) {
    for (const std::uint64_t claim : claims) send(EventKind::heartbeat, Heartbeat{claim}, "runner");
    for (const std::uint8_t j : told) positions[j] += way;
    next_tick_of(did);
  }
  [[nodiscard]] std::vector<Acted> row(std::uint32_t number) const {
    return {Acted{0, released[crosser], number}, Acted{0, released[runner], number},
            Acted{0, released[last], number}};
  }
  [[nodiscard]] std::vector<Verdict> verdicts() const {
    std::vector<Verdict> found;
    for (const Output& output : out->items()) {
      if (output.kind != OutputKind::verdict) continue;
      Verdict& message = found.emplace_back();
      REQUIRE(decode(out->payload(output), message) == FrameFault::none);
    }
    return found;
  }
  std::array<std::uint64_t, 3> claims{}, released{};
};

}  // namespace

TEST_CASE("what is cut because of what was cut, twice over, loses its whole rest") {
  constexpr auto number_of = [](Outcome outcome) { return static_cast<std::uint8_t>(outcome); };
  Queue rig;
  rig.advance(0.05, rig.row(0));
  CHECK(rig.verdicts().empty());
  // Pushed aside by 0.02 m, the crosser ends before the post, on the origin: after row 3. The
  // runner ends 0.05 m before it, after row 6, and the last would meet it there in row 11.
  rig.positions[crosser_x] = 0.02;
  rig.advance(0.05, rig.row(1));
  const std::vector<Verdict> verdicts = rig.verdicts();
  REQUIRE(verdicts.size() == 3);
  CHECK(verdicts[0].claim_id == rig.claims[crosser]);
  CHECK(verdicts[0].code == 31);
  CHECK(verdicts[0].row == 4);
  CHECK(verdicts[0].outcome == number_of(Outcome::truncated));
  CHECK(verdicts[1].claim_id == rig.claims[runner]);
  CHECK(verdicts[1].code == 32);
  CHECK(verdicts[1].row == 7);
  CHECK(verdicts[1].outcome == number_of(Outcome::truncated));
  CHECK(verdicts[2].claim_id == rig.claims[last]);
  CHECK(verdicts[2].code == 32);
  CHECK(verdicts[2].row == 11);
  CHECK(verdicts[2].outcome == number_of(Outcome::refused));
  CHECK(verdicts[2].released_last == 0);
}
