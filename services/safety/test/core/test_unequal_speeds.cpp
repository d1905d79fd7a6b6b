// Switch up, where of each row another share happens: after rows of which little did, the next is
// faster than either end of the gain says, and stops later.

#include <doctest/doctest.h>

#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr std::uint8_t switch_part = 1;
constexpr double row = 0.05;  // along x [m], in a tick of 0.05 s
constexpr double eps = 1e-4;  // what damping takes

// A tenth to three tenths of a motion happen in its tick; slide_x brakes at 0.5 m/s2.
struct Told {
  Limits limits = free_arm::limits();
  PartMemories memories;

  Told() {
    limits.parts[arm].modes.cartesian_delta.gain = {0.1, 0.3};
    limits.joints[slide_x].acceleration_limit = 0.5;
    PartLimits part = test::part("switch", {});
    part.modes.composite_mode = scalar_mode(-1.0, 1.0, 2.0);
    (void)limits.parts.push_back(part);
    memories[arm].goal = Pose{Eigen::Matrix3d::Identity(), {0.7, 0, 0.5}};
  }
  [[nodiscard]] Evidence of(const Row& steps, double value = 1.0) const {
    return judged(steps, steps.size(), value).evidence;
  }
  // Rows from `certified_end` on are only forecast.
  [[nodiscard]] Judgement judged(const Row& steps, std::size_t certified_end,
                                 double value = 1.0) const {
    Rows rows;
    for (const double step : steps) rows.push_back({step, 0, 0, 0, 0, 0});
    ChunkBuilder chunk;
    chunk.add(arm, Mode::cartesian_delta, rows, {}, "base_link");
    chunk.scalar(switch_part, Mode::composite_mode, Row(steps.size(), value));
    RowBefore before;
    before.memories = &memories;
    MeasuredState state = at_rest();
    (void)state.acted.resize(2);
    const RobotModel model(limits);
    return judge_path(shared_room(), model, whole_robot(limits), state, chunk.chunk,
                      {0, steps.size(), certified_end}, before, {});
  }
};

// The upper end takes it by 0.3, then 0.51 rows a tick; after a tenth of the first row, by 0.57;
// where braking ends.
constexpr double furthest = (0.3 + 0.51) * row + 0.57 * 0.57;

// From `at` it takes that much room ahead, and as much back.
template <class Code>
void check_edges(const Code& code, double at, double room, std::uint32_t refused) {
  CHECK(code(at - 1.0, at + room + eps, row) == 0);
  CHECK(code(at - 1.0, at + room - eps, row) == refused);
  CHECK(code(at - room - eps, at + 1.0, -row) == 0);
  CHECK(code(at - room + eps, at + 1.0, -row) == refused);
}

}  // namespace

TEST_CASE("G026 switch up: as fast as the shares of the rows before can make it") {
  Told told;
  const auto code = [&](double limit, const Gain& gain) {
    told.limits.joints[slide_x].velocity_limit = limit;
    told.limits.parts[arm].modes.cartesian_delta.gain = gain;
    return told.of({row, row}).code;
  };
  CHECK(code(0.57 + eps, {0.1, 0.3}) == 0);
  CHECK(code(0.57 - eps, {0.1, 0.3}) == 26);
  CHECK(code(0.51 + eps, {0.3, 0.3}) == 0);  // one share is certain
  CHECK(code(0.51 - eps, {0.3, 0.3}) == 26);
  told.limits.joints[slide_x].velocity_limit = 0.55;
  told.limits.parts[arm].modes.cartesian_delta.gain = {0.1, 0.3};
  for (const double way : {row, -row}) {
    const Evidence found = told.of({way, way});
    CHECK(found.code == 26);
    CHECK(found.row == 1);
    CHECK(found.part == "arm");
    CHECK(found.axis == "slide_x");
    CHECK(found.value == doctest::Approx(0.57).epsilon(1e-3));
    told.limits.joints[slide_x].velocity_limit = found.value;
    CHECK(told.of({way, way}).ok());
    told.limits.joints[slide_x].velocity_limit = 0.55;
  }
  CHECK(told.of({row, row}, -1.0).ok());
}

TEST_CASE("G024 switch up: it stops within its bounds however fast the shares make it") {
  const auto code = [](double lower, double upper, double way) {
    Told told;
    told.limits.joints[slide_x].bounds = {lower, upper, 0.0};
    return told.of({way, way}).code;
  };
  check_edges(code, 0.0, furthest, 24);
}

TEST_CASE("G024 switch up: a row that turns around goes on with what the ones before left") {
  // Half of each happens, or all. Of 0.05 and -0.01 m the upper end makes that, the lower one 0.025
  // and 0.0075 m; all of the second after half of the first is 0.015 m, at 0.3 m/s.
  const auto code = [](double lower, double upper, double way) {
    Told told;
    told.limits.parts[arm].modes.cartesian_delta.gain = {0.5, 1.0};
    told.limits.joints[slide_x].acceleration_limit = 100.0;
    told.limits.joints[slide_x].bounds = {lower, upper, 0.0};
    return told.of({way, -0.2 * way}).code;
  };
  check_edges(code, 0.0, row + 0.0075 + 0.3 * 0.3 / 200.0, 24);
}

TEST_CASE("G031 switch up: the tool stops in its volume however fast the shares make it") {
  const auto code = [](double lower, double upper, double way) {
    Told told;
    (void)told.limits.workspace.volumes.push_back({"shelf", false, {lower, -1, 0}, {upper, 1, 1}});
    return told.of({way, way}).code;
  };
  check_edges(code, 0.7, furthest, 31);
}

TEST_CASE("G026 switch up: what the first row left counts, switch down it does not") {
  Told told;
  told.limits.joints[slide_x].velocity_limit = 0.31;  // as fast as one row alone
  CHECK(told.of({row, row}, -1.0).ok());
  CHECK(told.of({row, row}, 1.0).code == 26);
}

TEST_CASE("G024 switch up: forecast rows go by the middle of their gain, whatever came before") {
  Told told;
  told.limits.joints[slide_x].bounds = {-1.0, furthest + eps, 0.0};
  CHECK(told.judged({row, row, 0.0, 0.0}, 2).row_count == 4);
}
