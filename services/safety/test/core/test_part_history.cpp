// What is remembered of each part, without the gate: where the goal of its tool is after what
// acted, and what a row or a lost state makes of the modes it may move in.

#include <doctest/doctest.h>

#include <deque>
#include <memory>

#include "core/kinematics/forward_kinematics.hpp"
#include "core/release/part_history.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

constexpr double eps = 1e-12;

// The history of a robot on which one claim of all parts has released one chunk.
struct Remembered {
  Remembered(const Limits& robot, MeasuredState first) : limits(robot), state(first) {
    LiveClaim& claim = *claims->free_place();
    claim.id = 1;
    for (std::size_t i = 0; i < limits.parts.size(); ++i) (void)claim.limits.parts.push_back(i);
    history->begin(state);
  }
  void release(const ChunkBuilder& chunk) {
    Released release;
    release.verdict_id = verdict;
    release.first_tick = state.tick;
    release.row_count = chunk.chunk.horizon;
    claims->places()[0].plan.release(release, Bytes(frames.emplace_back(chunk.frame())));
  }
  /// A later state, before which those parts executed that row and all others held.
  void act(std::initializer_list<std::size_t> parts, std::uint32_t row, std::uint64_t ticks = 1) {
    const MeasuredState before = state;
    state.tick += ticks;
    for (Acted& act : state.acted) act = Acted{2, 0, 0};
    for (const std::size_t part : parts) state.acted[part] = Acted{0, verdict, row};
    history->end_tick(before.tick);
    history->update(before, state, *claims);
  }
  [[nodiscard]] const std::optional<Pose>& goal(std::size_t part) const {
    return history->memories()[part].goal;
  }
  void check_goal(std::size_t part, double x, double y, double z) const {
    REQUIRE(goal(part).has_value());
    const Eigen::Vector3d missed = goal(part)->position - Eigen::Vector3d(x, y, z);
    CHECK(missed.norm() < eps);
  }
  static constexpr std::uint64_t verdict = 77;
  Limits limits;
  MeasuredState state;
  std::deque<std::vector<std::uint8_t>> frames;
  std::unique_ptr<ClaimTable> claims = std::make_unique<ClaimTable>();
  RobotModel model{limits};
  std::unique_ptr<PartHistory> history = std::make_unique<PartHistory>(model);
};

// A motion of the tool along x, and the switch beside it.
ChunkBuilder ahead(Mode mode, double x, double value) {
  return ChunkBuilder()
      .along(arm, mode, 0, {x, x})
      .scalar(composite, Mode::composite_mode, {value, value});
}

ActionPart command(Mode mode, const char* frame = "") {
  ActionPart action;
  action.mode = static_cast<std::uint8_t>(mode);
  action.frame_id = frame;
  return action;
}

}  // namespace

TEST_CASE("arming at standstill, the goal of a tool is where it is; where it moves nobody knows") {
  MeasuredState state = state_at_rest();
  state.positions[torso] = 0.1;  // which nothing commands
  Remembered rests(test_limits(), state);
  rests.check_goal(arm, 0.7, 0.0, 0.6);
  state.velocities[arm_1] = 0.5;
  const Remembered moves(test_limits(), state);
  CHECK_FALSE(moves.goal(arm).has_value());
  CHECK(moves.goal(gripper).has_value());
}

TEST_CASE("with the switch up a goal goes on by what is told in a tick; held, it is the tool") {
  for (const Mode mode : {Mode::cartesian_delta, Mode::cartesian_twist}) {
    const double told = mode == Mode::cartesian_twist ? 0.01 / 0.05 : 0.01;
    Remembered robot(test_limits(), state_at_rest());
    robot.release(ahead(mode, told, 1.0));
    robot.act({arm, composite}, 0);
    robot.check_goal(arm, 0.71, 0.0, 0.5);
    robot.act({arm, composite}, 1);
    robot.check_goal(arm, 0.72, 0.0, 0.5);
    robot.act({}, 0);
    robot.check_goal(arm, 0.7, 0.0, 0.5);
  }
}

TEST_CASE("a part that holds switches nothing: the goal begins anew where the tool is") {
  Remembered robot(test_limits(), state_at_rest());
  robot.release(ahead(Mode::cartesian_delta, 0.01, 1.0));
  robot.act({arm}, 0);
  robot.check_goal(arm, 0.71, 0.0, 0.5);
  robot.act({arm}, 1);
  robot.check_goal(arm, 0.71, 0.0, 0.5);
}

TEST_CASE("the switch counts wherever the robot lists it, first as well") {
  // The switch's part and the arm change places.
  for (const double value : {1.0, -1.0}) {
    Limits limits = test_limits();
    std::swap(limits.parts[0], limits.parts[composite]);
    const auto moved_arm = static_cast<std::uint8_t>(composite);
    for (const std::size_t j : {arm_1, arm_2}) limits.joints[j].part = moved_arm;
    Remembered robot(limits, state_at_rest());
    robot.release(ChunkBuilder()
                      .along(moved_arm, Mode::cartesian_delta, 0, {0.01, 0.01})
                      .scalar(0, Mode::composite_mode, {value, value}));
    robot.act({0, moved_arm}, 0);
    robot.check_goal(moved_arm, 0.71, 0.0, 0.5);
    robot.act({0, moved_arm}, 1);
    robot.check_goal(moved_arm, value > 0.0 ? 0.72 : 0.71, 0.0, 0.5);
  }
}

TEST_CASE("a goal goes on along the axes of the frame that it is told in, as the root has them") {
  // The column has turned to the left by a right angle: the tool is at (0, 0.7, 0.5).
  for (const char* frame : {"base_link", "column"}) {
    MeasuredState state = free_arm::at_rest();
    state.positions[free_arm::turn_z] = std::acos(0.0);
    Remembered robot(free_arm::limits(), state);
    robot.release(
        ChunkBuilder().add(arm, Mode::cartesian_delta, {{0.01, 0, 0, 0, 0, 0.1}}, {}, frame));
    robot.act({arm}, 0);
    const bool root = std::string_view(frame) == "base_link";
    robot.check_goal(arm, root ? 0.01 : 0.0, root ? 0.7 : 0.71, 0.5);
    const Eigen::AngleAxisd turned(std::acos(0.0) + 0.1, Eigen::Vector3d::UnitZ());
    CHECK((robot.goal(arm)->rotation - turned.toRotationMatrix()).norm() < eps);
  }
}

TEST_CASE("a goal is forgotten where a tick that was held began unseen, unless the part stands") {
  for (const bool stands : {true, false}) {
    Remembered robot(test_limits(), state_at_rest());
    robot.release(ahead(Mode::cartesian_delta, 0.01, 1.0));
    robot.act({arm, composite}, 0);
    robot.state.velocities[arm_1] = stands ? 0.0 : 0.5;
    robot.act({}, 0, 2);
    CHECK(robot.goal(arm).has_value() == stands);
    if (stands) robot.check_goal(arm, 0.7, 0.0, 0.5);
  }
}

TEST_CASE("a row that acted is all that can act on, whatever else had been released") {
  ReleasedRows released;
  released.add(command(Mode::joint_velocity), 100, 110);
  released.add(command(Mode::body_twist, "base_link"), 103, 108);
  CHECK(released.moving.kind == MovingMode::Kind::unknown);
  const ActionPart acts = command(Mode::body_twist, "base_link");
  released.act(acts);
  CHECK(released.moving.kind == MovingMode::Kind::known);
  CHECK_FALSE(released.moving.differs(acts));
  CHECK(released.moving.differs(command(Mode::joint_velocity)));
  CHECK(released.modes == MovingMode::mode_bit(acts.mode));
}

TEST_CASE("after a row that nobody remembers nobody knows which way a switch was turned") {
  PartMemory memory;
  memory.composite = Switch::positive;
  memory.note_forgotten(0b110);
  CHECK(memory.composite == Switch::unknown);
  CHECK(memory.kind == MovingMode::Kind::unknown);
  CHECK(memory.acted_modes == 0b110);
}

TEST_CASE("rows of which no state told leave a switch as it was, where none of them was a switch") {
  for (const Mode mode : {Mode::joint_velocity, Mode::composite_mode}) {
    PartMemory memory;
    memory.composite = Switch::positive;
    memory.released.add(command(mode), 100, 110);
    memory.note_unseen();
    CHECK(memory.composite == (mode == Mode::composite_mode ? Switch::unknown : Switch::positive));
    CHECK(memory.acted_modes == MovingMode::mode_bit(static_cast<std::uint8_t>(mode)));
  }
}
