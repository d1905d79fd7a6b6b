// G031, G032 and G034 between the two ends of a gain: straight from where one share of the rows
// leads to where the other does, and from where braking ends for one to where it does for the
// other. What stands there is on the way of neither, nor of the middle.

#include <doctest/doctest.h>

#include "predicted.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// The test robot's arm slides along x and y, its gripper's joint lifts it; half to all of its
// velocities happen. At 5 m/s2 along y the slower share brakes in 25 mm, the faster in 100 mm.
Limits sliding() {
  Limits limits = test_limits();
  Kinematics& tree = limits.kinematics;
  for (const std::size_t j : {arm_1, arm_2}) {
    limits.joints[j].kind = JointKind::prismatic;
    tree.links[j == arm_1 ? 2 : 3].motion = LinkMotion::slide;
  }
  tree.links[2].axis = {1, 0, 0};
  limits.joints[arm_2].acceleration_limit = 5.0;
  limits.parts[arm].modes.joint_velocity = joint_mode({arm_1, arm_2}, 3.0);
  limits.parts[arm].modes.joint_velocity.gain = {0.5, 1.0};
  limits.parts[base].modes.joint_velocity.gain = {1.0, 1.0};
  tree.links[1].joint = gripper_joint;
  limits.joints[gripper_joint].velocity_limit = 1.5;
  limits.joints[gripper_joint].acceleration_limit = 1e18;
  limits.parts[gripper].modes.joint_velocity = joint_mode({gripper_joint}, 3.0);
  limits.parts[gripper].modes.joint_velocity.gain = {0.5, 1.0};
  return limits;
}

// What moves beside the arm: nothing, a base that does all it is told, or what lifts the arm, whose
// gain is the first of two.
enum class MovesToo { nothing, base, lift };
constexpr std::array everything{MovesToo::nothing, MovesToo::base, MovesToo::lift};

// 0.05 m ahead in one row, 0.05 m aside in the next.
ChunkBuilder& ahead_and_aside(ChunkBuilder& chunk, std::uint8_t part, std::uint8_t x,
                              std::uint8_t y) {
  Row ahead(joint_count, 0.0), aside(joint_count, 0.0);
  ahead[x] = aside[y] = 1.0;
  return chunk.add(part, Mode::joint_velocity, {ahead, aside}, {x, y});
}

Evidence judged(const Limits& limits, const ChunkBuilder& chunk) {
  return judge_rows(limits, whole_robot(limits), state_at_rest(), chunk.chunk, 0, {}).evidence;
}

// A post of 4 mm, so far ahead and aside of where the tool rests.
Evidence past_volume(double x, double y, MovesToo beside) {
  static Limits limits;  // evidence points into it
  limits = sliding();
  (void)limits.workspace.volumes.push_back(
      {"post", true, {0.7 + x - 0.002, y - 0.002, 0}, {0.7 + x + 0.002, y + 0.002, 1}});
  ChunkBuilder chunk;
  if (beside == MovesToo::lift)
    chunk.joint(gripper, Mode::joint_velocity, gripper_joint, {0.01, 0.01});
  ahead_and_aside(chunk, arm, arm_1, arm_2);
  if (beside == MovesToo::base) chunk.joint(base, Mode::joint_velocity, base_x, {0.01, 0.01});
  return judged(limits, chunk);
}

FixedVec<Corner, max_corners> box(double x, double y, double half) {
  FixedVec<Corner, max_corners> corners = square(half);
  for (Corner& corner : corners) corner = {corner[0] + x, corner[1] + y};
  return corners;
}

// A floor with a post to keep out of, and a base no larger than that. It stops where it is.
Limits floor_with_post(double x, double y, double half, Gain gain) {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_velocity.gain = gain;
  limits.base.reaction_s = 1e-9;
  limits.base.footprint = square(half);
  (void)limits.base.zones.push_back({"post", true, box(x, y, half)});
  return limits;
}

}  // namespace

TEST_CASE("G031 a post that only shares between both ends of the gain lead to") {
  for (const MovesToo beside : everything) {
    CAPTURE(static_cast<int>(beside));
    // The rows lead to between (25 mm, 25 mm) and (50 mm, 50 mm).
    const Evidence hit = past_volume(0.03125, 0.03125, beside);
    CHECK(hit.code == 31);
    CHECK(hit.row == 1);
    CHECK(hit.part == "arm");
    CHECK(past_volume(0.1, 0.05, beside).ok());
  }
}

TEST_CASE("G031 a post that only the stop after a share between both ends leads to") {
  for (const MovesToo beside : everything) {
    CAPTURE(static_cast<int>(beside));
    // Braking ends between (25 mm, 50 mm) and (50 mm, 150 mm).
    const Evidence hit = past_volume(0.03125, 0.075, beside);
    CHECK(hit.code == 31);
    CHECK(hit.row == 1);
    CHECK(past_volume(0.1, 0.11, beside).ok());
  }
}

namespace {

// A row of 50 mm by a slide of the arm and 25 mm up by the lift; a post of 4 mm there and that
// high.
std::uint32_t code_of_post(std::uint8_t slide, double way, double up, bool moves_base) {
  Limits limits = sliding();
  const double height = 0.54 + up;  // the lift is at 40 mm
  Volume post{"post", true, {-1, -1, height - 0.002}, {2, 1, height + 0.002}};
  const std::size_t axis = slide == arm_1 ? 0 : 1;
  const double at = (slide == arm_1 ? 0.7 : 0.0) + way;
  post.lower[axis] = at - 0.002;
  post.upper[axis] = at + 0.002;
  (void)limits.workspace.volumes.push_back(post);
  ChunkBuilder chunk;
  chunk.joint(gripper, Mode::joint_velocity, gripper_joint, {0.5});
  chunk.joint(arm, Mode::joint_velocity, slide, {1.0});
  if (moves_base) chunk.joint(base, Mode::joint_velocity, base_x, {0.01});
  return judged(limits, chunk).code;
}

}  // namespace

TEST_CASE("G031 a post on the way between one part's shares, with either end of another's") {
  // 25 to 50 mm ahead and 12.5 to 25 mm up: any corner of that rectangle, and its sides.
  for (const bool moves_base : {false, true}) {
    CAPTURE(moves_base);
    const auto code = [&](double x, double z) { return code_of_post(arm_1, x, z, moves_base); };
    for (const double end : {0.025, 0.05}) CHECK(code(end, 0.01875) == 31);
    for (const double end : {0.0125, 0.025}) CHECK(code(0.0375, end) == 31);
    CHECK(code(0.055, 0.01875) == 0);
    CHECK(code(0.0375, 0.03) == 0);
  }
}

TEST_CASE("G031 a post on the way between the stops after one part's shares") {
  // Aside the arm brakes within 25 to 100 mm: it rests at 50 to 150 mm.
  for (const bool moves_base : {false, true}) {
    CAPTURE(moves_base);
    CHECK(code_of_post(arm_2, 0.15, 0.01875, moves_base) == 31);
    CHECK(code_of_post(arm_2, 0.155, 0.01875, moves_base) == 0);
    // One where the row ends, 25 to 50 mm aside, is not on the way between the stops.
    CHECK(code_of_post(arm_2, 0.025, 0.01875, moves_base) == 31);
  }
}

TEST_CASE("G034 a post on the floor that only shares between both ends of the gain lead to") {
  const auto hit_at = [](double x, double y, bool moves_arm) {
    Limits limits = floor_with_post(x, y, 0.002, {0.5, 1.0});
    limits.parts[arm].modes.joint_velocity.gain = {0.5, 1.0};
    ChunkBuilder chunk;
    if (moves_arm) chunk.joint(arm, Mode::joint_velocity, arm_1, {0.1, 0.1});
    ahead_and_aside(chunk, base, base_x, base_y);
    const Evidence found = judged(limits, chunk);
    CHECK((found.ok() || found.row == 1));
    return found.code == 34;
  };
  for (const bool moves_arm : {false, true}) {
    CAPTURE(moves_arm);
    CHECK(hit_at(0.03125, 0.03125, moves_arm));
    CHECK(hit_at(0.04375, 0.04375, moves_arm));
    CHECK_FALSE(hit_at(0.1, 0.045, moves_arm));
  }
}

TEST_CASE(
    "G034 shares between both ends of the gain are looked at where the base goes ahead only") {
  // After four rows of 8 mm it is 9.6 to 32 mm ahead. A post thinner than the resolution stands at
  // 26.4 mm, a quarter of the way between the ends, where no row ends.
  const auto found_at = [](double x) {
    const Limits limits = floor_with_post(x, 0.0, 0.00005, {0.3, 1.0});
    const Evidence found = judged(
        limits, ChunkBuilder().joint(base, Mode::joint_velocity, base_x, Row(4, 0.008 / 0.05)));
    return found.code == 34 ? found.row : -1;
  };
  CHECK(found_at(0.0264) == 3);
  CHECK(found_at(0.0500) == -1);
}

namespace {

// The arm's two joints and a lift, each in a part of its own, with a gain; the tool hangs on the
// yaw of the base.
struct ThreeGains {
  ThreeGains() {
    (void)state.acted.resize(limits.parts.size() + 2);
    limits.parts[arm].joints.erase_at(1);
    limits.parts[gripper].joints.clear();
    wrist = add("wrist", arm_2);
    lift = add("lift", gripper_joint);
    limits.joints[gripper_joint].velocity_limit = 1.5;
    limits.kinematics.links[1].joint = gripper_joint;
    Link& tool = limits.kinematics.links[4];
    tool.motion = LinkMotion::turn;
    tool.joint = base_yaw;
    const std::array<std::pair<std::uint8_t, std::size_t>, 3> moved{
        {{arm, arm_1}, {wrist, arm_2}, {lift, gripper_joint}}};
    for (const auto& [part, j] : moved) {
      limits.parts[part].modes.joint_velocity.gain = {0.25, 1.0};
      chunk.joint(part, Mode::joint_velocity, static_cast<std::uint8_t>(j), {0.4, 0.4});
    }
  }
  std::uint8_t add(const char* name, std::size_t j) {
    PartLimits added = test::part(name, {j});
    added.modes.joint_velocity = joint_mode({j}, 3.0);
    widen(added);
    limits.joints[j].part = limits.parts.size();
    (void)limits.parts.push_back(added);
    return static_cast<std::uint8_t>(limits.joints[j].part);
  }
  Limits limits = test_limits();
  MeasuredState state = state_at_rest();
  ChunkBuilder chunk;
  std::uint8_t wrist = 0, lift = 0;
};

}  // namespace

TEST_CASE("branches hold the ends of three gains in every combination, and know their partners") {
  // Each gain is one bit, in the order of the chunk's parts: the lower ends come first.
  const ThreeGains robot;
  Predicted predicted(robot.limits, robot.state, robot.chunk.chunk);
  REQUIRE(predicted.all.share_count() == 9);
  REQUIRE(predicted.all.branch_count() == 9);
  (void)predicted.after_a_row();
  constexpr std::array moved{arm_1, arm_2, gripper_joint};
  for (std::size_t branch = 1; branch < 9; ++branch)
    for (std::size_t bit = 0; bit < moved.size(); ++bit) {
      CAPTURE(branch);
      CAPTURE(bit);
      const std::size_t j = moved[bit];
      const bool is_upper = ((branch - 1) >> bit & 1U) != 0;
      CHECK(predicted.all.branch(branch).now[j] - robot.state.positions[j] ==
            doctest::Approx(is_upper ? 0.02 : 0.005));
      CHECK(predicted.all.has_lower_end(branch, std::size_t{1} << bit) == !is_upper);
    }
  for (const std::size_t bit : {1U, 2U, 4U}) CHECK_FALSE(predicted.all.has_lower_end(0, bit));
  for (std::size_t branch = 0; branch < 9; ++branch)
    for (const std::size_t bit : {8U, 16U})
      CHECK_FALSE(predicted.all.has_lower_end(branch, bit));  // there is no fourth gain
}

TEST_CASE("three gains while something else coasts fill all the branches that there are") {
  ThreeGains robot;
  robot.state.velocities[base_yaw] = 0.5;
  Predicted predicted(robot.limits, robot.state, robot.chunk.chunk);
  REQUIRE(predicted.all.branch_count() == max_branches);
  for (int row = 0; row < 2; ++row) (void)predicted.after_a_row();
  const Branch& last = predicted.all.branch(max_branches - 1);
  for (const std::size_t j : {arm_1, arm_2, gripper_joint})
    CHECK(last.now[j] - robot.state.positions[j] == doctest::Approx(0.04));
}

TEST_CASE("a robot of as many parts as there is room for is predicted like any other") {
  Limits limits = test_limits();
  for (const char* name : {"five", "six", "seven", "eight"}) {
    PartLimits extra = limits.parts[composite];
    extra.name = name;
    (void)limits.parts.push_back(extra);
  }
  REQUIRE(limits.parts.size() == max_parts);
  limits.parts[arm].modes.joint_velocity = joint_mode({arm_1}, 3.0);
  limits.parts[arm].modes.joint_velocity.gain = {1.0, 1.0};
  const ChunkBuilder chunk = ChunkBuilder().joint(arm, Mode::joint_velocity, arm_1, {0.4});
  PartMemories memories;
  RowBefore before;
  before.memories = &memories;
  Predicted predicted(limits, state_at_rest(), chunk.chunk, before);
  CHECK(predicted.after_a_row().now[arm_1] == doctest::Approx(0.02));
}
