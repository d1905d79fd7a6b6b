// G031: volumes that keep the tools in, or tools and capsules out. The free arm's tool is at
// (0.7, 0, 0.5) and goes where its slides go.

#include <doctest/doctest.h>

#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr double eps = 1e-9;

Limits with_volume(bool keep_out, std::array<double, 3> lower, std::array<double, 3> upper) {
  Limits limits = free_arm::limits();
  (void)limits.workspace.volumes.push_back({"shelf", keep_out, lower, upper});
  return limits;
}

Judgement slid(const Limits& limits, std::uint8_t joint, const Row& targets,
               const MeasuredState& state = at_rest()) {
  return free_arm::judge(limits, one_joint(Mode::joint_position, joint, targets).chunk, state);
}

MeasuredState at(std::size_t joint, double position) {
  MeasuredState state = at_rest();
  state.positions[joint] = position;
  return state;
}

}  // namespace

TEST_CASE("G031 the tool stays in: each face, up to and including it") {
  const auto code = [](double x, double y, double z, std::uint8_t joint, double target) {
    const Limits limits = with_volume(false, {0.7 - x, -y, 0.5 - z}, {0.7 + x, y, 0.5 + z});
    return slid(limits, joint, {target}).evidence.code;
  };
  for (const std::uint8_t joint : {slide_x, slide_y, slide_z}) {
    const auto half = [joint](std::size_t axis) { return joint == axis ? 0.1 : 1.0; };
    const double x = half(slide_x), y = half(slide_y), z = half(slide_z);
    CHECK(code(x, y, z, joint, 0.1 - eps) == 0);
    CHECK(code(x, y, z, joint, 0.1 + eps) == 31);
    CHECK(code(x, y, z, joint, -0.1 + eps) == 0);
    CHECK(code(x, y, z, joint, -0.1 - eps) == 31);
  }
}

TEST_CASE("G031 the verdict says which axis, where, and which limit") {
  const Limits limits = with_volume(false, {0, -1, 0}, {1, 1, 0.6});
  const Judgement cut = slid(limits, slide_z, {0.05, 0.1, 0.15, 0.2});
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.row_count == 2);
  CHECK(cut.evidence.code == 31);
  CHECK(cut.evidence.part == "arm");
  CHECK(cut.evidence.axis.starts_with("tool z / "));
  CHECK(cut.evidence.row == 2);
  CHECK(cut.evidence.value == doctest::Approx(0.65));
  CHECK(cut.evidence.limit == 0.6);
  CHECK(cut.evidence.unit == "m");
  CHECK(cut.evidence.margin == doctest::Approx(-0.05));
  CHECK(cut.evidence.limit_source == "test workspace");
  const Judgement low = slid(with_volume(false, {0.65, -1, 0}, {1, 1, 1}), slide_x, {-0.1});
  CHECK(low.evidence.axis.starts_with("tool x / "));
  CHECK(low.evidence.limit == 0.65);
  CHECK(low.evidence.margin == doctest::Approx(-0.05));
}

TEST_CASE("G031 where braking ends counts, too") {
  Limits limits = with_volume(false, {0, -1, 0}, {0.85 + eps, 1, 1});
  limits.joints[slide_x].acceleration_limit = 5.0;  // 1 m/s: 0.1 m
  CHECK(slid(limits, slide_x, {0.05}).evidence.ok());
  limits.workspace.volumes[1].upper[0] = 0.85 - eps;
  CHECK(slid(limits, slide_x, {0.05}).evidence.code == 31);
}

TEST_CASE("G031 what is out already may come back or stay, not go on") {
  const Limits limits = with_volume(false, {0, -1, 0}, {0.8, 1, 1});
  CHECK(slid(limits, slide_x, {0.2}, at(slide_x, 0.2)).evidence.ok());
  CHECK(slid(limits, slide_x, {0.19, 0.15, 0.1, 0.05}, at(slide_x, 0.2)).evidence.ok());
  CHECK(slid(limits, slide_x, {0.2 + 1e-5}, at(slide_x, 0.2)).evidence.code == 31);
  CHECK(slid(limits, slide_x, {0.15, 0.16}, at(slide_x, 0.2)).evidence.row == 1);
  CHECK(slid(limits, slide_x, {0.05, 0.1 + eps}, at(slide_x, 0.2)).evidence.row == 1);
}

TEST_CASE("G031 the tool stays out") {
  const Limits limits = with_volume(true, {0.8, -0.1, 0.4}, {1.0, 0.1, 0.6});
  CHECK(slid(limits, slide_x, {0.1 - eps}).evidence.ok());
  const Judgement refused = slid(limits, slide_x, {0.15});
  CHECK(refused.evidence.code == 31);
  CHECK(refused.evidence.axis == "tool / shelf");
  CHECK(refused.evidence.unit == "m");
  CHECK(refused.evidence.value == doctest::Approx(-0.05));
  CHECK(refused.evidence.limit == 0.0);
  CHECK(slid(limits, slide_x, {0.15, 0.1}, at(slide_x, 0.16)).evidence.ok());  // leaves it
  CHECK(slid(limits, slide_x, {0.15}, at(slide_x, 0.14)).evidence.code == 31);
}

TEST_CASE("G031 a capsule that the chunk moves stays out, as thick as it is") {
  Limits limits = with_volume(true, {0.8, 0.5, 0.4}, {1.0, 0.7, 0.6});
  limits.collision.capsules[1] = {tool_link, {0, 0.2, 0}, {0, 0.55, 0}, 0.04};
  CHECK(slid(limits, slide_x, {0.06 - eps}).evidence.ok());
  const Judgement refused = slid(limits, slide_x, {0.06 + eps});
  CHECK(refused.evidence.code == 31);
  CHECK(refused.evidence.axis == "tool / shelf");
  CHECK(refused.evidence.unit == "m");
  CHECK(refused.evidence.limit == 0.0);
  CHECK(refused.evidence.margin == doctest::Approx(-eps).epsilon(1e-3));
  CHECK(refused.evidence.part == "arm");
  limits.collision.capsules[1].link = 0;  // the root link stands still, whatever stands there
  limits.collision.capsules[1].a = limits.collision.capsules[1].b = {0.9, 0.6, 0.5};
  CHECK(slid(limits, slide_x, {0.06 + eps}).evidence.ok());
}

TEST_CASE("G031 a thin wall between two rows is not jumped over") {
  const Limits limits = with_volume(true, {0.8, -1, 0}, {0.82, 1, 1});
  CHECK(slid(limits, slide_x, {0.05}).evidence.ok());
  CHECK(slid(limits, slide_x, {0.2}).evidence.code == 31);
  CHECK(slid(limits, slide_x, {0.0}, at(slide_x, 0.2)).evidence.code == 31);
}

TEST_CASE("G031 a volume that is no number keeps nothing in and nothing free") {
  const Limits in = with_volume(false, {0, -1, 0}, {not_a_number, 1, 1});
  CHECK(slid(in, slide_x, {0.01}).evidence.code == 31);
  const Limits out = with_volume(true, {2, 2, 2}, {not_a_number, 3, 3});
  CHECK(slid(out, slide_x, {0.01}).evidence.code == 31);
}

TEST_CASE("G031 the first volume that is left is named, whatever comes after it") {
  Limits limits = with_volume(false, {0, -1, 0}, {1, 1, 1});
  limits.workspace.volumes[0] = {"room", false, {0, -1, 0}, {0.75, 1, 1}};
  limits.workspace.volumes[1].upper[0] = 0.74;
  const Judgement refused = slid(limits, slide_x, {0.1});
  CHECK(refused.evidence.code == 31);
  CHECK(refused.evidence.limit == 0.75);
}

TEST_CASE("G031 the first part whose tool leaves is named, though another has the same tool") {
  Limits limits = test_limits();  // its gripper moves the arm's tool, too
  limits.parts[arm].modes.joint_velocity.gain = {1.0, 1.0};
  limits.workspace.volumes[0] = {"room", false, {-1, -0.01, -1}, {1, 0.01, 1}};
  const ChunkBuilder turn = ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.5});
  const Judgement refused =
      judge_rows(limits, whole_robot(limits), state_at_rest(), turn.chunk, 0, {});
  CHECK(refused.evidence.code == 31);
  CHECK(refused.evidence.axis.starts_with("tool y / "));
  CHECK(refused.evidence.part == "arm");
}

TEST_CASE("G031 a capsule that is in a volume already may leave it or stay, not go on") {
  Limits limits = with_volume(true, {0.8, 0.5, 0.4}, {1.0, 0.7, 0.6});
  limits.collision.capsules[1] = {tool_link, {0, 0.55, 0}, {0, 0.55, 0}, 0.05};
  CHECK(slid(limits, slide_x, {0.1}, at(slide_x, 0.12)).evidence.ok());
  CHECK(slid(limits, slide_x, {0.12}, at(slide_x, 0.12)).evidence.ok());
  CHECK(slid(limits, slide_x, {0.13}, at(slide_x, 0.12)).evidence.code == 31);
}

TEST_CASE("G031 capsules stay out of volumes on a robot without a tool and without pairs") {
  Limits limits = with_volume(true, {0.8, -0.1, 0.4}, {1.0, 0.1, 0.6});
  limits.collision.pairs.clear();
  limits.parts[arm].tool = no_link;
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.05};
  CHECK(slid(limits, slide_x, {0.04}).evidence.ok());
  CHECK(slid(limits, slide_x, {0.06}).evidence.code == 31);
}
