// G033 on the test robot's two joints. Their columns of the tool's Jacobian are square to each
// other: about z, 0.4 + 0.3 cos(arm_2) m from the axis, so sqrt(1 + (0.4 + 0.3 cos arm_2)^2) long;
// about y, sqrt(1.09). The first one is the shorter once arm_2 is beyond acos(-1/3) = 1.911.

#include <doctest/doctest.h>

#include <cmath>

#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

double measure(double angle) { return std::hypot(1.0, 0.4 + 0.3 * std::cos(angle)); }

Limits limits_at(double singular_value) {
  Limits limits = test_limits();
  limits.parts[arm].singularity_limit = singular_value;
  limits.parts[arm].modes.cartesian_delta.gain = {1.0, 1.0};
  limits.parts[arm].modes.cartesian_twist.gain = {1.0, 1.0};
  return limits;
}

// What a rotation vector about y makes of arm_2: its column is (1.09 + damping)^-1 of it; a second
// step makes up for what the damping took.
double turned(double by) {
  constexpr double damping = 0.02 * 0.02;
  const double first = by / (1.09 + damping);
  return first + (by - 1.09 * first) / (1.09 + damping);
}

Judgement turn(const Limits& limits, double from, const Row& by,
               Mode mode = Mode::cartesian_delta) {
  MeasuredState state = state_at_rest();
  state.positions[arm_2] = from;
  return judge_rows(limits, whole_robot(limits), state,
                    ChunkBuilder().along(arm, mode, 4, by).chunk, 0, {});
}

}  // namespace

TEST_CASE("G033 the smallest singular value, from above") {
  const double there = 1.95 + turned(0.02);
  CHECK(turn(limits_at(measure(there + 1e-6)), 1.95, {0.02}).evidence.ok());
  const Limits above = limits_at(measure(there - 1e-6));  // evidence points into it
  const Judgement refused = turn(above, 1.95, {0.02});
  CHECK(refused.outcome == Outcome::refused);
  CHECK(refused.evidence.code == 33);
  CHECK(refused.evidence.part == "arm");
  CHECK(refused.evidence.axis == "singular value");
  CHECK(refused.evidence.value == doctest::Approx(measure(there)));
  CHECK(refused.evidence.limit == measure(there - 1e-6));
  CHECK(refused.evidence.unit == "1");
  CHECK(refused.evidence.margin < 0.0);
  // sqrt(1.09) = 1.044, wherever arm_2 is: already below, and no row makes it worse.
  CHECK(turn(limits_at(1.05), 0.0, {0.01}).evidence.ok());
  CHECK(turn(limits_at(1.04), 0.0, {0.01}).evidence.ok());
}

TEST_CASE("G033 cuts the rows that lead on") {
  const Judgement cut = turn(limits_at(measure(1.97)), 1.92, {0.02, 0.02, 0.02, 0.02});
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.row_count == 2);
  CHECK(cut.evidence.code == 33);
}

TEST_CASE("G033 leaving, and staying, is always allowed") {
  const Limits limits = limits_at(measure(1.93));
  CHECK(turn(limits, 1.97, {-0.02, -0.02, -0.02, -0.02}).evidence.ok());
  CHECK(turn(limits, 1.97, {0.0}).evidence.ok());
  CHECK(turn(limits, 1.97, {0.01}).evidence.code == 33);
  CHECK(turn(limits, 1.97, {-0.02, 0.01}).evidence.row == 1);
}

TEST_CASE("G033 from less than half of the limit no tool moves, to leave it either") {
  const double start = measure(1.97), limit = 2.0 * start;
  CHECK(turn(limits_at(limit * (1.0 - 1e-5)), 1.97, {-0.02, -0.02}).evidence.ok());
  const Limits below = limits_at(limit * (1.0 + 1e-5));  // evidence points into it
  const Judgement refused = turn(below, 1.97, {-0.02});
  CHECK(refused.evidence.code == 33);
  CHECK(refused.evidence.part == "arm");
  CHECK(refused.evidence.value == doctest::Approx(start));
  CHECK(refused.evidence.limit == doctest::Approx(start * (1.0 + 1e-5)).epsilon(1e-9));
  CHECK(turn(below, 1.97, {0.0, 0.0}).evidence.ok());  // it holds
  const Judgement after = turn(below, 1.97, {0.0, -0.02});
  CHECK(after.outcome == Outcome::truncated);
  CHECK(after.row_count == 1);
}

TEST_CASE("G033 twists, by their period; and where braking ends") {
  Limits limits = limits_at(measure(1.97));
  CHECK(turn(limits, 1.95, {0.4}, Mode::cartesian_twist).evidence.ok());  // 0.02 rad in a period
  CHECK(turn(limits, 1.95, {0.6}, Mode::cartesian_twist).evidence.code == 33);
  limits.joints[arm_2].acceleration_limit = 5.0;  // 0.37 rad/s: 14 mrad
  CHECK(turn(limits, 1.95, {0.4}, Mode::cartesian_twist).evidence.code == 33);
}

TEST_CASE("G033 joint modes are not asked") {
  const Limits limits = limits_at(100.0);
  MeasuredState state = state_at_rest();
  const ChunkBuilder chunk = ChunkBuilder().joint(arm, Mode::joint_position, arm_2, {0.1});
  CHECK(judge_rows(limits, whole_robot(limits), state, chunk.chunk, 0, {}).evidence.ok());
}

TEST_CASE("G033 a limit that is no number refuses") {
  CHECK(turn(limits_at(not_a_number), 0.5, {0.01}).evidence.code == 33);
  CHECK(turn(limits_at(infinite), 0.5, {-0.01}).evidence.code == 33);
}

TEST_CASE("G033 the limit grows by 1.25 times itself for each radian that shares leave open") {
  // 0.02 rad in the first row, of which 0.005 to 0.02 happen: 0.015 rad are open in the second.
  const auto turned_by = [](double gain, double limit) {
    Limits limits = limits_at(limit);
    limits.parts[arm].modes.cartesian_delta.gain = {gain, 1.0};
    return limits;
  };
  const double there = 1.92 + turned(0.02) + turned(0.02);
  const double limit = measure(there) / (1.0 + 1.25 * (turned(0.02) - turned(0.005)));
  CHECK(turn(turned_by(1.0, limit + 1e-4), 1.92, {0.02, 0.02}).evidence.ok());
  CHECK(turn(turned_by(0.25, limit - 1e-6), 1.92, {0.02, 0.02}).evidence.ok());
  const Limits open = turned_by(0.25, limit + 1e-6);  // evidence points into it
  const Judgement cut = turn(open, 1.92, {0.02, 0.02});
  CHECK(cut.outcome == Outcome::truncated);
  CHECK(cut.row_count == 1);
  CHECK(cut.evidence.code == 33);
  CHECK(cut.evidence.value == doctest::Approx(measure(there)));
  CHECK(cut.evidence.limit == doctest::Approx(measure(there) + 1e-6).epsilon(1e-6));
  CHECK(turn(turned_by(0.25, not_a_number), 1.92, {0.02, 0.02}).evidence.code == 33);
}
