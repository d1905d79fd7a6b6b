// G007, G008, G009: the shape of a chunk, its numbers, and what it addresses.

#include <doctest/doctest.h>

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "core/chunk/judgement.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

Evidence shape(const ActionChunk& chunk, std::uint32_t horizon_max = 64) {
  static const Limits limits = test_limits();
  ClaimLimits claim = whole_robot(limits);
  claim.horizon_max = horizon_max;
  return check_shape(limits, claim, chunk);
}

std::uint32_t code_of(const ChunkBuilder& builder) { return shape(builder.chunk).code; }

}  // namespace

TEST_CASE("G007 the horizon lies between 1 and the claim's maximum") {
  for (const std::uint32_t horizon : {1U, 63U, 64U}) {
    ChunkBuilder builder;
    builder.scalar(gripper, Mode::gripper_position, Row(horizon, 0.04));
    CHECK(shape(builder.chunk).ok());
  }
  for (const std::uint32_t horizon : {0U, 65U, 4'294'967'295U}) {
    ChunkBuilder builder;
    builder.scalar(gripper, Mode::gripper_position, Row(64, 0.04));
    builder.chunk.horizon = horizon;
    CHECK(shape(builder.chunk).code == 7);
    CHECK(shape(builder.chunk).limit == (horizon == 0 ? 1 : 64));
  }
  ChunkBuilder nine;
  nine.scalar(gripper, Mode::gripper_position, Row(9, 0.04));
  CHECK(shape(nine.chunk, 8).code == 7);
  CHECK(shape(nine.chunk, 8).limit == 8);
  CHECK(shape(nine.chunk, 9).ok());
}

TEST_CASE("G007 a block holds exactly horizon times width numbers") {
  CHECK(code_of(ChunkBuilder().add(gripper, Mode::gripper_position, {{0.04, 0.04}})) == 7);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::cartesian_delta, {{0, 0, 0, 0, 0}}, {},
                                   "base_link")) == 7);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::cartesian_delta, {{0, 0, 0, 0, 0, 0, 0}}, {},
                                   "base_link")) == 7);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {Row(joint_count - 1, 0.0)},
                                   {arm_1})) == 7);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {Row(joint_count + 1, 0.0)},
                                   {arm_1})) == 7);
  CHECK(code_of(ChunkBuilder().add(gripper, Mode::gripper_position, {{}})) == 7);
}

namespace {

// A good row of every mode of the test robot.
struct ModeRow {
  std::uint8_t part;
  Mode mode;
  Row row;
  std::vector<std::uint8_t> active;
  const char* frame;
};

const std::vector<ModeRow>& every_mode() {
  static const Row joints(joint_count, 0.0);
  static const Row six(6, 0.0);
  static const std::vector<ModeRow> rows{
      {arm, Mode::joint_position, joints, {arm_1}, ""},
      {arm, Mode::joint_velocity, joints, {arm_1}, ""},
      {arm, Mode::cartesian_pose, {0.7, 0, 0.5, 0, 0, 0, 1}, {}, "base_link"},
      {arm, Mode::cartesian_delta, six, {}, "base_link"},
      {arm, Mode::cartesian_twist, six, {}, "base_link"},
      {base, Mode::body_twist, six, {}, "base_link"},
      {gripper, Mode::gripper_binary, {1.0}, {}, ""},
      {gripper, Mode::gripper_position, {0.04}, {}, ""},
      {arm, Mode::dex_hand_joint, joints, {arm_1}, ""},
      {composite, Mode::composite_mode, {0.0}, {}, ""},
  };
  return rows;
}

// The code for two rows of a mode, changed by `change`; every mode declared.
std::uint32_t code_with(ModeRow item, const auto& change) {
  Limits limits = test_limits();
  limits.parts[arm].modes.dex_hand_joint = limits.parts[arm].modes.joint_position;
  change(item);
  ChunkBuilder builder;
  builder.add(item.part, item.mode, {item.row, item.row}, {}, item.frame);
  for (const std::uint8_t joint : item.active) (void)builder.chunk.parts[0].active.push_back(joint);
  return check_shape(limits, whole_robot(limits), builder.chunk).code;
}

}  // namespace

TEST_CASE("the shape of every mode: its width, its numbers, its mask, its frame") {
  for (const ModeRow& item : every_mode()) {
    CAPTURE(mode_name(static_cast<std::uint8_t>(item.mode)));
    CHECK(code_with(item, [](ModeRow&) {}) == 0);
    CHECK(code_with(item, [](ModeRow& it) { it.row.push_back(0.0); }) == 7);
    CHECK(code_with(item, [](ModeRow& it) { it.row.pop_back(); }) == 7);
    for (std::size_t i = 0; i < item.row.size(); ++i)
      for (const double bad : {not_a_number, infinite, -infinite, just_above(1e6)})
        CHECK(code_with(item, [=](ModeRow& it) { it.row[i] = bad; }) == 8);
    const bool masked = is_joint_mode(static_cast<std::uint8_t>(item.mode));
    CHECK(code_with(item, [=](ModeRow& it) {
            it.active = masked ? std::vector<std::uint8_t>{} : std::vector<std::uint8_t>{arm_1};
          }) == 9);
    if (masked) {
      CHECK(code_with(item, [](ModeRow& it) { it.row[arm_2] = 5e-324; }) == 9);
      CHECK(code_with(item, [](ModeRow& it) { it.active[0] = base_x; }) == 9);
    }
    const bool framed = !std::string_view(item.frame).empty();
    CHECK(code_with(item, [=](ModeRow& it) { it.frame = framed ? "" : "base_link"; }) == 9);
    CHECK(code_with(item, [](ModeRow& it) { it.frame = "odom"; }) == 9);
    CHECK(code_with(item, [](ModeRow& it) { it.part = it.part == base ? gripper : base; }) == 9);
  }
}

TEST_CASE("G007 a chunk without parts is refused") { CHECK(code_of(ChunkBuilder(1)) == 7); }

TEST_CASE("G008 every number of every row is finite and at most 1e6, and a breach stops") {
  for (const double bad :
       {not_a_number, infinite, -infinite, 1e308, just_above(1e6), -just_above(1e6)}) {
    for (const std::size_t row : {std::size_t{0}, std::size_t{2}}) {
      Row values(3, 0.04);
      values[row] = bad;
      const Evidence evidence =
          shape(ChunkBuilder().scalar(gripper, Mode::gripper_position, values).chunk);
      CHECK(evidence.code == 8);
      CHECK(evidence.row == static_cast<std::int64_t>(row));
      CHECK(evidence.part == "gripper");
      CHECK(evidence.raises_stop);
      CHECK(evidence.limit == (bad < 0.0 ? -1e6 : 1e6));
      CHECK_FALSE(evidence.margin >= 0.0);
    }
  }
  for (const double fine : {1e6, -1e6, just_below(1e6), 5e-324, -5e-324, 0.0, -0.0})
    CHECK(shape(ChunkBuilder().scalar(gripper, Mode::gripper_position, {fine}).chunk).ok());
}

TEST_CASE("G008 padding is not exempt") {
  Row row(joint_count, 0.0);
  row[base_x] = not_a_number;
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {row}, {arm_1})) == 8);
}

TEST_CASE("G009 modes without a checker are refused by name") {
  for (const Mode mode : {Mode::joint_torque, Mode::joint_trajectory, Mode::foot_placement}) {
    const std::size_t width = mode_width(static_cast<std::uint8_t>(mode), joint_count);
    ChunkBuilder builder;
    builder.add(arm, mode, {Row(width, 0.0)});
    const Evidence evidence = shape(builder.chunk);
    CHECK(evidence.code == 9);
    CHECK(evidence.axis == mode_name(static_cast<std::uint8_t>(mode)));
    CHECK(evidence.part == "arm");
  }
  CHECK(code_of(ChunkBuilder().add(arm, static_cast<Mode>(13), {{0.0}})) == 9);
  CHECK(code_of(ChunkBuilder().add(arm, static_cast<Mode>(255), {{0.0}})) == 9);
}

TEST_CASE("G008 stops also beside a mode that is refused by name, in either order") {
  for (const Mode unknown : {Mode::joint_trajectory, Mode::foot_placement, static_cast<Mode>(255)})
    for (const bool first : {false, true}) {
      ChunkBuilder builder;
      if (first) builder.add(arm, unknown, {{0.0}});
      builder.scalar(gripper, Mode::gripper_position, {not_a_number});
      if (!first) builder.add(arm, unknown, {{0.0}});
      const Evidence evidence = shape(builder.chunk);
      CHECK(evidence.code == 8);
      CHECK(evidence.raises_stop);
      CHECK(evidence.part == "gripper");
    }
  // What nothing can read the width of is not read.
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_trajectory, {{not_a_number}})) == 9);
}

TEST_CASE("G009 a mode the part does not declare is refused") {
  CHECK(code_of(ChunkBuilder().scalar(arm, Mode::gripper_position, {0.04})) == 9);
  CHECK(code_of(ChunkBuilder().along(gripper, Mode::cartesian_delta, 0, {0.01})) == 9);
  CHECK(code_of(ChunkBuilder().along(arm, Mode::body_twist, 0, {0.01})) == 9);
  CHECK(code_of(ChunkBuilder().joint(gripper, Mode::joint_position, gripper_joint, {0.04})) == 9);
  CHECK(code_of(ChunkBuilder().joint(base, Mode::joint_position, base_x, {0.0})) == 9);
  CHECK(code_of(ChunkBuilder().scalar(base, Mode::composite_mode, {0.0})) == 9);
}

TEST_CASE("G009 the mask names joints of the part, ascending, and is mandatory") {
  const Row zeros(joint_count, 0.0);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {zeros}, {arm_1, arm_2})) == 0);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {zeros}, {})) == 9);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {zeros}, {arm_2, arm_1})) == 9);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {zeros}, {arm_1, arm_1})) == 9);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {zeros}, {base_x, arm_1})) == 9);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {zeros}, {200})) == 9);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::cartesian_delta, {Row(6, 0.0)}, {arm_1},
                                   "base_link")) == 9);
}

TEST_CASE("G009 two slides that are told against the yaw are told together") {
  const Row zeros(joint_count, 0.0);
  for (const bool turned : {true, false}) {
    Limits limits = test_limits();
    limits.base.present = true;
    limits.base.against_yaw = turned;
    limits.base.joints = {base_x, base_y, base_yaw};
    const auto code = [&](std::initializer_list<std::uint8_t> active) {
      const ChunkBuilder rows = ChunkBuilder().add(base, Mode::joint_velocity, {zeros}, active);
      return check_shape(limits, whole_robot(limits), rows.chunk).code;
    };
    const std::uint32_t refused = turned ? 9 : 0;
    CHECK(code({base_x}) == refused);
    CHECK(code({base_y, base_yaw}) == refused);
    CHECK(code({base_yaw}) == 0);
    CHECK(code({base_x, base_y}) == 0);
  }
}

TEST_CASE("G009 what is not active is exactly zero, in every row") {
  Row dirty(joint_count, 0.0);
  dirty[arm_2] = 5e-324;
  const Row clean(joint_count, 0.0);
  const Evidence evidence =
      shape(ChunkBuilder().add(arm, Mode::joint_position, {clean, dirty}, {arm_1}).chunk);
  CHECK(evidence.code == 9);
  CHECK(evidence.row == 1);
  CHECK(evidence.axis == "arm_2");
  Row negative_zero(joint_count, 0.0);
  negative_zero[arm_2] = -0.0;
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {negative_zero}, {arm_1})) == 0);
}

TEST_CASE("G009 frames: declared ones for cartesian modes, none for the others") {
  CHECK(code_of(ChunkBuilder().add(arm, Mode::cartesian_delta, {Row(6, 0.0)}, {}, "base_link")) ==
        0);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::cartesian_delta, {Row(6, 0.0)}, {}, "odom")) == 9);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::cartesian_delta, {Row(6, 0.0)}, {}, "")) == 9);
  CHECK(code_of(ChunkBuilder().add(gripper, Mode::gripper_position, {{0.04}}, {}, "base_link")) ==
        9);
  CHECK(code_of(ChunkBuilder().add(arm, Mode::joint_position, {Row(joint_count, 0.0)}, {arm_1},
                                   "base_link")) == 9);
}

TEST_CASE("G009 a base twist is zero along axes the base does not have") {
  for (const std::size_t axis : {0U, 1U, 5U})
    CHECK(code_of(ChunkBuilder().along(base, Mode::body_twist, axis, {0.1})) == 0);
  for (const std::size_t axis : {2U, 3U, 4U}) {
    CHECK(code_of(ChunkBuilder().along(base, Mode::body_twist, axis, {5e-324})) == 9);
    CHECK(code_of(ChunkBuilder().along(base, Mode::body_twist, axis, {0.0, 0.1})) == 9);
  }
}

TEST_CASE("G009 no part is commanded twice in one tick") {
  CHECK(code_of(ChunkBuilder()
                    .joint(arm, Mode::joint_position, arm_1, {0.1})
                    .joint(arm, Mode::joint_velocity, arm_2, {0.1})) == 9);
}

TEST_CASE("G009 a number along an axis that is not free: axis, row and part, the first axis too") {
  Limits limits = test_limits();
  limits.parts[base].modes.body_twist.free_axes[0] = false;
  const ChunkBuilder along_x = ChunkBuilder().along(base, Mode::body_twist, 0, {0.0, 0.1});
  const Evidence evidence = check_shape(limits, whole_robot(limits), along_x.chunk);
  CHECK(evidence.code == 9);
  CHECK(evidence.axis == "x");
  CHECK(evidence.row == 1);
  CHECK(evidence.part == "base");
  CHECK(evidence.value == 0.1);
}

TEST_CASE("G009 a mask out of order says which joint comes behind which") {
  const Row zeros(joint_count, 0.0);
  const Evidence evidence =
      shape(ChunkBuilder().add(arm, Mode::joint_position, {zeros}, {arm_2, arm_1}).chunk);
  CHECK(evidence.value == arm_1);
  CHECK(evidence.limit == arm_2);
}
