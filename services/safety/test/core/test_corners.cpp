// Corners of the rules that no ordinary day reaches: each still has its one right answer.

#include <algorithm>
#include <string>

#include "acted_rows.hpp"
#include "gate_rig.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// The test robot, whose base may also be told joint positions: its yaw has no bounds.
Judgement judge_yaw(const Row& values, const Acted& acted = {}) {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_position = joint_mode({base_x, base_y, base_yaw}, 0.25);
  MeasuredState state = state_at_rest();
  state.positions[base_yaw] = 100.0;
  state.acted[base] = acted;
  return judge_rows(limits, whole_robot(limits), state,
                    ChunkBuilder().joint(base, Mode::joint_position, base_yaw, values).chunk, 0,
                    {});
}

}  // namespace

TEST_CASE("a continuous joint has no bounds to be outside of, and no tolerance to start with") {
  CHECK(judge_yaw({100.25}).evidence.ok());
  CHECK(judge_yaw({just_above(100.25)}).evidence.code == 21);
  CHECK(judge_yaw({99.75}).evidence.ok());
  CHECK(judge_yaw({just_below(99.75)}).evidence.code == 21);
}

TEST_CASE("a mode without a checker, or without a name, is refused by the judge of rows too") {
  for (const int mode : {2, 3, 8, 13, 255}) {
    ChunkBuilder builder;
    builder.add(arm, static_cast<Mode>(mode), {{0.0}});
    const Evidence evidence = judge(builder.chunk).evidence;
    CHECK(evidence.code == 9);
    CHECK(evidence.value == mode);
    CHECK(evidence.limit_source == "a mode that has a checker");
    CHECK(evidence.axis == mode_name(static_cast<std::uint8_t>(mode)));
  }
}

TEST_CASE("G021 a part that the acting row did not command starts from what is measured") {
  ChunkBuilder before;
  before.scalar(gripper, Mode::gripper_position, {0.04});
  const auto code = [&before](double speed) {
    return code_after(before, ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {speed}));
  };
  MeasuredState moving = state_at_rest();
  CHECK(code(1.5) == 0);
  moving.velocities[base_x] = -1.0;
  CHECK(code_after(before, ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {1.0}),
                   moving) == 0);
  CHECK(code_after(before, ChunkBuilder().joint(base, Mode::joint_velocity, base_x, {1.1}),
                   moving) == 21);
}

TEST_CASE("G011 a joint that the rows have brought back may stay inside") {
  MeasuredState state = state_at_rest();
  state.positions[arm_1] = 2.15;
  const Judgement judgement = judge(
      ChunkBuilder().joint(arm, Mode::joint_position, arm_1, {2.0, 1.95, 2.0, 2.05}).chunk, state);
  CHECK(judgement.row_count == 3);
  CHECK(judgement.evidence.row == 3);
}

TEST_CASE("G007 the gate's own room for rows counts where a claim says more") {
  const Limits limits = test_limits();
  ClaimLimits claim = whole_robot(limits);
  claim.horizon_max = 100;
  ChunkBuilder builder;
  builder.scalar(gripper, Mode::gripper_position, Row(65, 0.04));
  CHECK(check_shape(limits, claim, builder.chunk).code == 7);
  builder = ChunkBuilder();
  builder.scalar(gripper, Mode::gripper_position, Row(64, 0.04));
  CHECK(check_shape(limits, claim, builder.chunk).ok());
}

TEST_CASE("a source is spelled with the letters, digits and signs of a key chunk") {
  const auto admitted = [](const char* source) {
    GateRig rig;
    rig.connect_and_arm();
    Claim claim = rig.claim_request();
    claim.source = source;
    rig.send(EventKind::claim, claim);
    return rig.count(OutputKind::reply) == 1;
  };
  for (const char* good : {"a", "z9", "0", "9_a", "r.1-b_c", "a-", "abcz.0189"})
    CHECK(admitted(good));
  for (const char* bad : {"", "_a", ".a", "-a", "A", "aB", "a/b", "a:b", "a`b", "a{", "a b"})
    CHECK_FALSE(admitted(bad));
}

TEST_CASE("two parts in rows of one verdict are not the same act unless the row is the same") {
  CHECK(same_act(Acted{0, 5, 1}, Acted{0, 5, 1}));
  CHECK_FALSE(same_act(Acted{0, 5, 1}, Acted{0, 5, 2}));
  CHECK_FALSE(same_act(Acted{0, 5, 1}, Acted{0, 6, 1}));
}

TEST_CASE("a copy of a refused chunk repeats no older release; of the running one it does") {
  GateRig rig;
  rig.ready();
  const ChunkBuilder good = rig.chunk(Row(10, 0.5));
  CHECK(rig.send_chunk(good).code == 0);
  rig.next_tick();
  rig.next_tick(row_of(rig.safe_chunk(), 0));
  CHECK(rig.count(OutputKind::safe_chunk) == 0);  // seen
  CHECK(rig.send_chunk(good).code == 0);
  CHECK(rig.count(OutputKind::safe_chunk) == 1);
  const ChunkBuilder bad = rig.chunk({9.0});
  CHECK(rig.send_chunk(bad).code != 0);
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
  CHECK(rig.send_chunk(bad).code != 0);
  CHECK(rig.count(OutputKind::safe_chunk) == 0);
}

TEST_CASE("text that is full stays as it is, whatever follows") {
  Text full(std::string(256, 'a'));
  full.append("b").append("\x80");
  CHECK(full.size() == 256);
  CHECK(full == std::string(256, 'a').c_str());
}

TEST_CASE("a block of more than 64 KiB is written with its whole length") {
  const std::vector<double> numbers(10'000, 1.0);
  ActionPart part;
  part.values = NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers.data()),
                                 numbers.size() * sizeof(double)));
  ActionChunk chunk;
  (void)chunk.parts.push_back(part);
  const std::vector<std::uint8_t> frame = frame_of(chunk);
  const std::vector<std::uint8_t> head{0xC6, 0x00, 0x01, 0x38, 0x80};  // 80,000 bytes
  CHECK(std::search(frame.begin(), frame.end(), head.begin(), head.end()) != frame.end());
  CHECK(decode(frame, chunk) == FrameFault::oversized);
}

TEST_CASE("G010 the rate is still counted after hundreds of chunks") {
  GateRig rig;
  rig.ready();
  for (int i = 0; i < 300; ++i) {
    CHECK(rig.send_chunk(rig.chunk()).code == 0);
    rig.send_heartbeat();
    rig.next_tick();
  }
  std::size_t admitted = 0;
  while (admitted < 100 && rig.send_chunk(rig.chunk()).code == 0) ++admitted;
  CHECK(admitted < 100);
  CHECK(rig.verdict().code == 10);
}
