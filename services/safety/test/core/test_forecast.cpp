// Rows that can act before the gate judges anew, and those after them: by what is they are judged.

#include <doctest/doctest.h>

#include "core/chunk/judgement.hpp"
#include "free_arm.hpp"
#include "predicted.hpp"
#include "two_arms.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// slide_x by rows of 1 m/s, 0.05 m each: 0.025 to 0.05 m of it happen, 0.0375 m by the forecast.
Judgement ahead(double upper, std::size_t certified, const Row& speeds = Row(8, 1.0)) {
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.joint_velocity.gain = {0.5, 1.0};
  limits.joints[free_arm::slide_x].bounds.upper = upper;
  const ChunkBuilder chunk = free_arm::one_joint(Mode::joint_velocity, free_arm::slide_x, speeds);
  return judge_rows(shared_room(), RobotModel(limits), whole_robot(limits), free_arm::at_rest(),
                    chunk.chunk, {0, 8, certified}, {}, {});
}

}  // namespace

TEST_CASE("G024 up to the last row that can act all of each may happen, then the middle") {
  for (const std::size_t certified : {1UL, 3UL, 8UL, 9UL}) {
    const double certain = 0.05 * static_cast<double>(std::min<std::size_t>(certified, 8));
    CHECK(ahead(certain - 0.001, certified).evidence.row <
          static_cast<std::int64_t>(std::min<std::size_t>(certified, 8)));
    const double forecast = std::max(certain, 8 * 0.0375);
    CHECK(ahead(forecast + 0.001, certified).evidence.ok());
    if (forecast == certain) continue;
    const Judgement cut = ahead(forecast - 0.001, certified);
    CHECK(cut.row_count == 7);
    CHECK(cut.evidence.code == 24);
    CHECK(cut.evidence.value == doctest::Approx(0.3));
  }
}

TEST_CASE("the forecast begins where the middle of the rows before it leads") {
  const Judgement back = ahead(0.15 + 0.001, 3, {1, 1, 1, -1, -1, -1, 0, 1});
  CHECK(back.evidence.ok());
  CHECK(ahead(0.15 + 0.001, 3, {1, 1, 1, 1, 0, 0, 0, 0}).evidence.ok());
  const Judgement cut = ahead(0.15 + 0.001, 3, {1, 1, 1, 1, 1, 0, 0, 0});
  CHECK(cut.evidence.row == 4);
  CHECK(cut.evidence.value == doctest::Approx(5 * 0.0375));
}

TEST_CASE("that other claims' parts may hold from now on counts in rows that can act alone") {
  const Limits limits = two_arms::limits();
  ChunkBuilder own, other;
  two_arms::command(own, two_arms::left, Mode::joint_position, two_arms::left_1, Row(4, 0.0));
  two_arms::command(other, two_arms::right, Mode::joint_position, two_arms::right_1, Row(4, 0.1));
  const Companion companion{{}, &other.chunk, 0, 4};
  Predicted predicted(limits, two_arms::at_rest(), own.chunk, {}, Companions(&companion, 1));
  CHECK(predicted.all.branch_count() == 2);
  CHECK(predicted.all.advance().ok());
  CHECK(predicted.all.branch(0).now[two_arms::right_1] > 0.0);
  predicted.all.only_forecast();
  CHECK(predicted.all.branch_count() == 1);
  CHECK(predicted.all.advance().ok());
  const Interval& interval = predicted.all.interval();
  CHECK(interval.lowest[two_arms::right_1] == predicted.all.branch(0).now[two_arms::right_1]);
  CHECK(interval.highest[two_arms::right_1] == predicted.all.branch(0).now[two_arms::right_1]);
}

TEST_CASE("G031 what is certified is clear wherever between the ends of a gain the robot gets to") {
  // 0.05 m ahead, then 0.05 m aside, of each the half at least: the tool ends between (0.025,
  // 0.025) and (0.05, 0.05). A post of 4 mm stands at `place` of both, on neither way there nor in
  // the middle.
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.joint_velocity.gain = {0.5, 1.0};
  Row ahead(6, 0.0), aside(6, 0.0);
  ahead[free_arm::slide_x] = aside[free_arm::slide_y] = 1.0;
  const auto judged = [&](double place, std::size_t certified) {
    Limits posted = limits;
    (void)posted.workspace.volumes.push_back({"post",
                                              true,
                                              {0.7 + place - 0.002, place - 0.002, 0},
                                              {0.7 + place + 0.002, place + 0.002, 1}});
    ChunkBuilder chunk;
    chunk.add(arm, Mode::joint_velocity, {ahead, aside}, {free_arm::slide_x, free_arm::slide_y});
    return judge_rows(shared_room(), RobotModel(posted), whole_robot(posted), free_arm::at_rest(),
                      chunk.chunk, {0, 2, certified}, {}, {});
  };
  for (const double place : {0.03125, 0.04375}) {
    CHECK(judged(place, 2).evidence.code == 31);
    CHECK(judged(place, 2).evidence.row == 1);
    CHECK(judged(place, 1).evidence.ok());  // by the forecast alone
  }
  CHECK(judged(0.09, 2).evidence.ok());
  CHECK(judged(0.0375, 1).evidence.code == 31);
}

TEST_CASE("G024 a robot without volumes and capsules is certified by its bounds") {
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.joint_velocity.gain = {0.5, 1.0};
  limits.collision.pairs.clear();
  limits.workspace.volumes.clear();
  limits.joints[free_arm::slide_x].bounds.upper = 0.12;
  const ChunkBuilder chunk =
      free_arm::one_joint(Mode::joint_velocity, free_arm::slide_x, Row(4, 1.0));
  const Judgement cut = free_arm::judge(limits, chunk.chunk);
  CHECK(cut.evidence.code == 24);
  CHECK(cut.evidence.row == 2);
}
