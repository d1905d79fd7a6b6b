// What holds is asked like all else: the zones of a base (G034), and how near to a singularity an
// arm is (G033).

#include <doctest/doctest.h>

#include <cmath>

#include "core/chunk/judgement.hpp"
#include "core/trajectory/prediction.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// The test robot's base in a hall from (-2, -2) to (right, 2); its footprint is a square of 1 m.
Limits hall(double right) {
  Limits limits = test_limits();
  limits.parts[base].modes.joint_velocity.gain = {1.0, 1.0};
  Zone zone{"hall", false, {}};
  for (const Corner& corner : {Corner{-2, -2}, Corner{right, -2}, Corner{right, 2}, Corner{-2, 2}})
    (void)zone.corners.push_back(corner);
  limits.base.zones.clear();
  (void)limits.base.zones.push_back(zone);
  limits.collision.pairs.clear();
  limits.workspace.volumes.clear();
  return limits;
}

Judgement drive(const Limits& limits, const ChunkBuilder& chunk,
                const MeasuredState& state = state_at_rest()) {
  const RobotModel model(limits);
  return judge_path(model, whole_robot(limits), state, chunk.chunk, 0, chunk.chunk.horizon, {}, {});
}

ChunkBuilder slide(const Row& values) {
  return ChunkBuilder().joint(base, Mode::joint_velocity, base_x, values);
}

// Of six joints in the order of the free arm, three make a chain: about z, then about x (of a part
// of its own), then about z again, 0.5 m out; the tool is 0.5 m further. With the middle joint at
// 0 both turn about the same axis: singular value 0.22; at a right angle it is 1.
constexpr std::uint8_t outer = 1;

Limits interleaved() {
  constexpr auto turn = LinkMotion::turn;
  Limits limits = free_arm::limits();
  Link root;
  root.name = "base_link";
  limits.kinematics =
      tree_of({root, link("inner", 0, turn, free_arm::turn_z, {0, 0, 1}, {0, 0, 0}),
               link("middle", 1, turn, free_arm::turn_x, {1, 0, 0}, {0, 0, 0}),
               link("last", 2, turn, free_arm::turn_y, {0, 0, 1}, {0.5, 0, 0}),
               link("tool", 3, LinkMotion::fixed, max_measured, {1, 0, 0}, {0.5, 0, 0})});
  limits.collision.pairs.clear();
  limits.collision.capsules.clear();
  limits.workspace.volumes.clear();
  limits.parts[arm].tool = 4;
  limits.parts[arm].joints.clear();
  (void)limits.parts[arm].joints.push_back(free_arm::turn_z);
  (void)limits.parts[arm].joints.push_back(free_arm::turn_y);
  limits.parts[arm].singularity_limit = 0.5;
  PartLimits part = test::part("middle", {free_arm::turn_x});
  part.modes.joint_position = joint_mode({free_arm::turn_x}, 0.25);
  widen(part);
  (void)limits.parts.push_back(part);
  limits.joints[free_arm::turn_x].part = outer;
  return limits;
}

}  // namespace

TEST_CASE("G034 a base that holds takes one look a row, wherever it is, and passes where it was") {
  const Judgement inside = drive(hall(2), slide({0.0, 0.0, 0.0}));
  CHECK(inside.evidence.ok());
  CHECK(inside.configurations == 3);
  CHECK(drive(hall(0.25), slide({0.0, 0.0, 0.0})).evidence.ok());  // it sticks out
}

TEST_CASE("G034 where a base comes to rest is looked at, unless all of the way there is clear") {
  const ChunkBuilder row = slide({0.1});
  CHECK(drive(hall(2), row).configurations == 1);
  double refused = 0.4, passes = 2.0;
  for (int i = 0; i < 50; ++i) {
    const double right = 0.5 * (refused + passes);
    (drive(hall(right), row).evidence.ok() ? passes : refused) = right;
  }
  CHECK(drive(hall(passes), row).configurations == 1);  // straight on: as far as it is clear
  const Judgement cut = drive(hall(refused), row);
  CHECK(cut.evidence.code == 34);
  CHECK(cut.evidence.value == doctest::Approx(0.0));  // at rest, where it first sticks out
  CHECK(cut.configurations == 2);
}

TEST_CASE("G034 a base that moves after it held is asked") {
  const Judgement cut = drive(hall(0.6), slide({0.0, 0.0, 0.0, 3.0}));
  CHECK(cut.row_count == 3);
  CHECK(cut.evidence.code == 34);
}

TEST_CASE("G034 a zone that is nowhere refuses the first row, also of a base that holds") {
  CHECK(drive(hall(not_a_number), slide({0.0, 0.0})).evidence.code == 34);
  CHECK(drive(hall(not_a_number), slide({0.0, 0.0})).row_count == 0);
}

TEST_CASE(
    "G034 a base that is told to hold and is measured to turn is asked where it comes to rest") {
  // 1 rad/s takes it round by 0.1 rad in its reaction, and a corner 0.05 m out.
  Limits limits = hall(0.52);
  MeasuredState state = state_at_rest();
  state.velocities[base_yaw] = 1.0;
  Row rows{0.0, 0.0};
  CHECK(drive(limits, slide(rows), state).evidence.code == 34);
  limits = hall(0.6);
  CHECK(drive(limits, slide(rows), state).evidence.ok());
}

TEST_CASE("G033 an arm that holds is asked where another part's joint among its own moves") {
  const Limits limits = interleaved();
  MeasuredState state = free_arm::at_rest();
  state.positions[free_arm::turn_x] = 1.5;
  ChunkBuilder chunk;
  chunk.along(arm, Mode::cartesian_delta, 0, Row(7, 0.0));
  chunk.joint(outer, Mode::joint_position, free_arm::turn_x, {1.5, 1.4, 1.2, 0.9, 0.6, 0.3, 0.0});
  const Judgement cut = drive(limits, chunk, state);
  CHECK(cut.evidence.code == 33);
  CHECK(cut.row_count > 3);
  CHECK(cut.row_count < 7);
}

TEST_CASE("G033 an arm that holds is asked where a joint that is told to stop coasts to") {
  Limits limits = interleaved();
  limits.joints[free_arm::turn_x].acceleration_limit = 0.5;
  MeasuredState state = free_arm::at_rest();
  state.positions[free_arm::turn_x] = 1.5;
  ChunkBuilder chunk;
  chunk.along(arm, Mode::cartesian_delta, 0, Row(3, 0.0));
  chunk.joint(outer, Mode::joint_position, free_arm::turn_x, {1.49, 1.49, 1.49});
  state.velocities[free_arm::turn_x] = -0.5;  // to 1.25 rad
  CHECK(drive(limits, chunk, state).evidence.ok());
  state.velocities[free_arm::turn_x] = -1.4;  // to -0.46 rad
  CHECK(drive(limits, chunk, state).evidence.code == 33);
}

TEST_CASE("G033 an arm whose joints all move, and stop at once, is asked in each row") {
  Limits limits = test_limits();  // see test_singularity.cpp for its numbers
  limits.parts[arm].singularity_limit = std::hypot(1.0, 0.4 + 0.3 * std::cos(1.97));
  limits.parts[arm].modes.cartesian_delta.gain = {1.0, 1.0};
  MeasuredState state = state_at_rest();
  state.positions[arm_2] = 1.92;
  const Row both{0, 0, 0, 0, 0.02, 0.005};
  const auto chunk =
      ChunkBuilder().add(arm, Mode::cartesian_delta, {both, both, both, both}, {}, "base_link");
  const Judgement cut = drive(limits, chunk, state);
  CHECK(cut.row_count == 2);
  CHECK(cut.evidence.code == 33);
}

TEST_CASE("G033 a limit that is no number refuses the first row, also of an arm that holds") {
  Limits limits = interleaved();
  limits.parts[arm].singularity_limit = not_a_number;
  ChunkBuilder chunk;
  chunk.along(arm, Mode::cartesian_delta, 0, Row(3, 0.0));
  CHECK(drive(limits, chunk, free_arm::at_rest()).evidence.code == 33);
}
