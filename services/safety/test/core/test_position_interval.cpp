// G024: the share of a row that happens may be another one in each row. From each row the joint
// goes on from the furthest that any share of those before can have left it at. A tick is 0.05 s;
// what the slides take to brake from 1 m/s is next to nothing.

#include <doctest/doctest.h>

#include "free_arm.hpp"
#include "predicted.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

Limits quarter_to_all(double lower, double upper) {
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.joint_velocity.gain = {0.25, 1.0};
  limits.parts[arm].modes.cartesian_delta.gain = {0.25, 1.0};
  limits.joints[slide_y].bounds = {lower, upper, 0.0};
  return limits;
}

Judgement path_of(const Limits& limits, const ChunkBuilder& chunk, const RowBefore& before = {}) {
  const RobotModel model(limits);
  return judge_path(model, whole_robot(limits), at_rest(), chunk.chunk, 0, chunk.chunk.horizon,
                    before, {});
}

}  // namespace

TEST_CASE("G024 to and fro: little of the one row, all of the next") {
  // Back by 0.0125 to 0.05 m, then ahead by as much: 0.0375 m at most, by equal shares 0.
  const ChunkBuilder ahead = one_joint(Mode::joint_velocity, slide_y, {-1.0, 1.0});
  CHECK(path_of(quarter_to_all(-1.0, 0.0375 + 1e-9), ahead).evidence.ok());
  const Limits tight = quarter_to_all(-1.0, 0.0375 - 1e-9);  // evidence points into it
  const Judgement cut = path_of(tight, ahead);
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.evidence.code == 24);
  CHECK(cut.evidence.row == 1);
  CHECK(cut.evidence.axis == "slide_y");
  CHECK(cut.evidence.value == doctest::Approx(0.0375));
  CHECK(cut.evidence.limit == 0.0375 - 1e-9);
  const ChunkBuilder back = one_joint(Mode::joint_velocity, slide_y, {1.0, -1.0});
  CHECK(path_of(quarter_to_all(-0.0375 - 1e-9, 1.0), back).evidence.ok());
  const Limits low = quarter_to_all(-0.0375 + 1e-9, 1.0);
  const Judgement below = path_of(low, back);
  CHECK(below.evidence.code == 24);
  CHECK(below.evidence.value == doctest::Approx(-0.0375));
  Limits unknown = quarter_to_all(not_a_number, 1.0);
  unknown.collision.pairs.clear();  // how far such a joint moves anything is unknown, too: G030
  unknown.workspace.volumes.clear();
  CHECK(path_of(unknown, back).evidence.code == 24);
}

TEST_CASE("G024 one way only: nothing is further than by all of each row") {
  const ChunkBuilder ahead = one_joint(Mode::joint_velocity, slide_y, {1.0, 1.0, 1.0});
  CHECK(path_of(quarter_to_all(-1.0, 0.15 + 1e-9), ahead).evidence.ok());
  CHECK(path_of(quarter_to_all(-1.0, 0.15 - 1e-9), ahead).row_count == 2);
}

TEST_CASE("G024 deltas to and fro spread as well, and rows away from a bound may go on") {
  const ChunkBuilder ahead = ChunkBuilder().along(arm, Mode::cartesian_delta, 1, {-0.04, 0.04});
  // Back by 0.01 m at least, ahead by 0.04.
  CHECK(path_of(quarter_to_all(-1.0, 0.03 + 1e-6), ahead).evidence.ok());
  CHECK(path_of(quarter_to_all(-1.0, 0.03 - 1e-6), ahead).evidence.code == 24);
  const ChunkBuilder leaving = one_joint(Mode::joint_velocity, slide_y, {-1.0, -1.0});
  CHECK(path_of(quarter_to_all(-1.0, -0.2), leaving).evidence.ok());
}

TEST_CASE("G024 a target is where it says, whatever came before") {
  const ChunkBuilder targets = one_joint(Mode::joint_position, slide_y, {-0.05, 0.03});
  CHECK(path_of(quarter_to_all(-1.0, 0.03 + 1e-9), targets).evidence.ok());
  CHECK(path_of(quarter_to_all(-1.0, 0.03 - 1e-9), targets).evidence.code == 24);
}

TEST_CASE("G024 the row that acts and is not measured yet spreads what follows") {
  const ChunkBuilder acts = one_joint(Mode::joint_velocity, slide_y, {-1.0});
  const ChunkBuilder next = one_joint(Mode::joint_velocity, slide_y, {1.0});
  RowBefore before{&acts.chunk, 0};
  before.measured = false;
  CHECK(path_of(quarter_to_all(-1.0, 0.0375 + 1e-9), next, before).evidence.ok());
  CHECK(path_of(quarter_to_all(-1.0, 0.0375 - 1e-9), next, before).evidence.code == 24);
  before.measured = true;
  CHECK(path_of(quarter_to_all(-1.0, 0.0375 - 1e-9), next, before).evidence.code == 24);
  CHECK(path_of(quarter_to_all(-1.0, 0.05 + 1e-9), next, before).evidence.ok());
}

TEST_CASE("G024 the first of the joints spreads like the others") {
  Limits limits = quarter_to_all(-1.0, 1.0);
  const ChunkBuilder ahead = one_joint(Mode::joint_velocity, turn_z, {-1.0, 1.0});
  limits.joints[turn_z].bounds.upper = 0.0375 + 1e-9;
  CHECK(path_of(limits, ahead).evidence.ok());
  limits.joints[turn_z].bounds.upper = 0.0375 - 1e-9;
  CHECK(path_of(limits, ahead).evidence.code == 24);
}

TEST_CASE("G033 what shares leave open is an angle: a slide counts as the turn that moves as far") {
  const auto open = [](const Limits& limits, std::uint8_t joint) {
    const ChunkBuilder chunk = one_joint(Mode::joint_velocity, joint, {0.8, 0.8});
    Predicted predicted(limits, at_rest(), chunk.chunk);
    (void)predicted.after_a_row();
    (void)predicted.after_a_row();
    return predicted.all.interval_width(arm);
  };
  Limits limits = quarter_to_all(-10.0, 10.0);
  const double reach = RobotModel(limits).tools[arm].reach;
  CHECK(reach == RobotModel(limits).frames[1].reach);
  CHECK(reach > 0.7);
  CHECK(open(limits, turn_y) == doctest::Approx(0.75 * 0.8 * 0.05));
  CHECK(open(limits, slide_y) == doctest::Approx(0.75 * 0.8 * 0.05 / reach));
  limits.parts[arm].joints.clear();
  for (const std::size_t j : {slide_x, slide_y, slide_z})
    (void)limits.parts[arm].joints.push_back(j);
  CHECK(open(limits, slide_y) == 0.0);  // its Jacobian is the same everywhere
}
