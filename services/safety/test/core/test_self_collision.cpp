// G032: capsules that may not come near each other. A ball on the tool of the free arm, at
// (0.7, 0, 0.5) with radius 0.05, and a post beside it, 0.4 m ahead: between them 0.3 m.

#include <doctest/doctest.h>

#include <algorithm>

#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr double eps = 1e-9;

Limits with_post(double clearance = 0.1) {
  Limits limits = free_arm::limits();
  limits.collision.capsules[0] = {0, {1.1, 0, 0.3}, {1.1, 0, 0.7}, 0.05};
  limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.05};
  limits.collision.clearance = clearance;
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

TEST_CASE("G032 the clearance, up to and including it") {
  CHECK(slid(with_post(), slide_x, {0.2 - eps}).evidence.ok());
  CHECK(slid(with_post(), slide_x, {0.2 + eps}).evidence.code == 32);
  const Limits post = with_post();  // evidence points into it
  const Judgement cut = slid(post, slide_x, {0.1, 0.2 - eps, 0.25});
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.row_count == 2);
  CHECK(cut.evidence.row == 2);
  CHECK(cut.evidence.part == "arm");
  CHECK(cut.evidence.axis == "base_link / tool");
  CHECK(cut.evidence.value == doctest::Approx(0.05));
  CHECK(cut.evidence.limit == 0.1);
  CHECK(cut.evidence.unit == "m");
  CHECK(cut.evidence.margin == doctest::Approx(-0.05));
  CHECK(cut.evidence.limit_source == "test shape");
}

TEST_CASE("G032 where braking ends counts, too") {
  Limits limits = with_post();
  limits.joints[slide_x].acceleration_limit = 5.0;  // 1 m/s: 0.1 m
  CHECK(slid(limits, slide_x, {0.05, 0.1 - eps}).evidence.ok());
  CHECK(slid(limits, slide_x, {0.05 + 3 * eps, 0.1 + 4 * eps}).evidence.row == 1);
}

TEST_CASE(
    "G032 where braking ends counts beside fingers that move: those declare no deceleration") {
  Limits limits = with_post();
  limits.joints[slide_x].acceleration_limit = 5.0;
  limits.joints[turn_x].acceleration_limit = limits.joints[turn_x].velocity_limit = unset;
  (void)limits.kinematics.links.push_back(
      link("finger", tool_link, LinkMotion::slide, turn_x, {0, 1, 0}, {0, 0, 0}));
  MeasuredState state = at_rest();
  for (const double speed : {0.0, 0.06, -0.06}) {
    state.velocities[turn_x] = speed;
    CHECK(slid(limits, slide_x, {0.05, 0.1 - eps}, state).evidence.ok());
    CHECK(slid(limits, slide_x, {0.05 + 3 * eps, 0.1 + 4 * eps}, state).evidence.row == 1);
  }
}

TEST_CASE("G032 what is too near already may leave or stay, not come nearer") {
  const Limits limits = with_post();
  CHECK(slid(limits, slide_x, {0.22}, at(slide_x, 0.22)).evidence.ok());
  CHECK(slid(limits, slide_x, {0.21, 0.1}, at(slide_x, 0.22)).evidence.ok());
  CHECK(slid(limits, slide_x, {0.22 + 1e-5}, at(slide_x, 0.22)).evidence.code == 32);
  CHECK(slid(limits, slide_x, {0.21, 0.215}, at(slide_x, 0.22)).evidence.row == 1);
}

TEST_CASE("G032 realtime: what the row that acts leads out of, the next one may not enter again") {
  const Limits limits = with_post();
  ChunkBuilder acts = one_joint(Mode::joint_position, slide_x, {0.19});
  RowBefore before{&acts.chunk, 0};
  before.measured = false;
  const auto code_of = [&](double target) {
    return free_arm::judge(limits, one_joint(Mode::joint_position, slide_x, {target}).chunk,
                           at(slide_x, 0.22), before)
        .evidence.code;
  };
  CHECK(code_of(0.2 - eps) == 0);
  CHECK(code_of(0.21) == 32);  // nearer than 0.19, though not than what is measured
}

TEST_CASE("G032 nothing is jumped over between two rows") {
  Limits limits = with_post(0.001);
  limits.collision.capsules[0].radius = limits.collision.capsules[1].radius = 0.005;
  limits.collision.capsules[0].a[0] = limits.collision.capsules[0].b[0] = 0.8;
  CHECK(slid(limits, slide_x, {0.08}).evidence.ok());
  CHECK(slid(limits, slide_x, {0.2}).evidence.code == 32);
  CHECK(slid(limits, turn_z, {0.2}, at(slide_y, 0.1)).evidence.ok());
  limits.collision.capsules[0].a = {0.7, 0.07, 0.3};  // in the way of the turn about z
  limits.collision.capsules[0].b = {0.7, 0.07, 0.7};
  CHECK(slid(limits, turn_z, {0.2}).evidence.code == 32);
}

TEST_CASE("G032 nothing is jumped over by what hangs on a slide without bounds") {
  Limits limits = with_post(0.001);
  limits.collision.capsules[0] = {0, {0.7, 0.07, 0.3}, {0.7, 0.07, 0.7}, 0.005};
  limits.collision.capsules[1].radius = 0.005;
  CHECK(slid(limits, turn_z, {0.2}).evidence.code == 32);
  limits.joints[slide_x].bounded = false;
  CHECK(slid(limits, turn_z, {0.2}).evidence.code == 32);
  // A short link beside it, on the same turning one, does not hide how far the other reaches.
  auto& links = limits.kinematics.links;
  (void)links.push_back(link("flag", 1, LinkMotion::turn, turn_x, {1, 0, 0}, {0, 0, 0}));
  std::rotate(links.begin() + 2, links.end() - 1, links.end());
  for (std::size_t i = 3; i < links.size(); ++i) links[i].parent += i == 3 ? 0 : 1;
  limits.parts[arm].tool = limits.collision.capsules[1].link = tool_link + 1;
  CHECK(slid(limits, turn_z, {0.2}).evidence.code == 32);
}

TEST_CASE("G032 only pairs that are declared, and only what the chunk moves") {
  Limits limits = with_post();
  limits.collision.pairs.clear();
  CHECK(slid(limits, slide_x, {0.25}).evidence.ok());
  limits = with_post();
  limits.collision.capsules[1].link = 0;
  limits.collision.capsules[1].a = limits.collision.capsules[1].b = {1.1, 0, 0.5};
  CHECK(slid(limits, slide_x, {0.25}).evidence.ok());
}

TEST_CASE("G032 a shape or a measurement that is no number is a hit") {
  for (const double bad : {not_a_number, infinite, -infinite}) {
    Limits limits = with_post();
    limits.collision.capsules[1].a[0] = bad;
    CHECK(slid(limits, slide_x, {0.01}).evidence.code == 32);
    limits = with_post();
    limits.collision.capsules[0].a[1] = bad;
    CHECK(slid(limits, slide_x, {0.01}).evidence.code == 32);
  }
  CHECK(slid(with_post(not_a_number), slide_x, {0.01}).evidence.code == 32);
  Limits limits = with_post();
  limits.collision.capsules[0].radius = not_a_number;
  CHECK(slid(limits, slide_x, {0.01}).evidence.code == 32);
  limits = with_post();
  limits.workspace.volumes.clear();
  CHECK(slid(limits, slide_x, {0.01}, at(turn_z, not_a_number)).evidence.code == 32);
}

TEST_CASE("G032 a hidden joint: all velocities of the chunk move at once") {
  // One slide alone stays clear, the two together do not.
  Limits limits = with_post();
  limits.collision.capsules[0] = {0, {0.8, 0.1, 0.3}, {0.8, 0.1, 0.7}, 0.01};
  limits.collision.capsules[1].radius = 0.01;
  limits.collision.clearance = 0.03;
  const auto code = [&](double x, double y) {
    const ChunkBuilder chunk =
        ChunkBuilder().add(arm, Mode::joint_velocity, {{0, x, y, 0, 0, 0}}, {slide_x, slide_y});
    return free_arm::judge(limits, chunk.chunk).evidence.code;
  };
  CHECK(code(1.4, 0.0) == 0);
  CHECK(code(0.0, 1.4) == 0);
  CHECK(code(1.4, 1.4) == 32);
}
