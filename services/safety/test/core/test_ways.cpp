// How far shapes move at most: what lets G031 and G032 look at few configurations. On the free arm,
// with a plate on its tool and one on its column.

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <utility>

#include "core/trajectory/displacement_bound.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr std::size_t column_link = 1;

Limits with_plates() {
  Limits limits = free_arm::limits();
  limits.collision.capsules[0] = {column_link, {0.2, 0, 0.1}, {0, 0.1, 0.3}, 0.01};
  limits.collision.capsules[1] = {tool_link, {0, 0.3, 0.4}, {0.1, 0, 0}, 0.01};
  return limits;
}

Joints anywhere(std::mt19937& random) {
  Joints joints{};
  for (std::size_t j = 0; j < 6; ++j)
    joints[j] = std::uniform_real_distribution<>(-1.0, 1.0)(random);
  return joints;
}

// An end of the tool's plate as the column sees it.
Eigen::Vector3d seen_from_column(const PathPlan& plan, const FramePoses& poses,
                                 const Eigen::Vector3d& end) {
  const FramePose& column = poses[plan.places[column_link].frame];
  const Eigen::Vector3d point = point_in_root(poses[plan.capsules[1].frame], end);
  return column.rotation.transpose() * (point - column.position);
}

}  // namespace

TEST_CASE("ways by hand: the wrist's turns reach 0.5 m, a slide goes as far as it is told") {
  const Limits limits = with_plates();
  const PathPlan plan(limits);
  const Joints rest{};
  const auto way = [&](std::uint8_t joint, double change) {
    Joints there{};
    there[joint] = change;
    return DisplacementBound(plan, rest, there).of(plan.pairs[0]);
  };
  CHECK(way(turn_x, 0.2) == doctest::Approx(0.1));
  CHECK(way(turn_y, -0.1) == doctest::Approx(0.05));
  CHECK(way(slide_x, 0.03) == doctest::Approx(0.03));
  CHECK(way(turn_z, 1.0) == 0.0);  // carries both plates
  Joints one{}, other{};
  one[turn_x] = 0.2;
  other[turn_x] = 0.1;
  other[slide_y] = -0.5;
  const DisplacementBound larger(DisplacementBound(plan, rest, one),
                                 DisplacementBound(plan, rest, other));
  CHECK(larger.of(plan.pairs[0]) == doctest::Approx(0.1 + 0.5));
}

TEST_CASE("ways: nothing goes further than they say, and none is longer than the longest") {
  const Limits limits = with_plates();
  const PathPlan plan(limits);
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    const Joints from = anywhere(random), to = anywhere(random);
    const DisplacementBound ways(plan, from, to);
    FramePoses start, end;
    start.place(plan, from);
    end.place(plan, to);
    for (const Eigen::Vector3d& point : {plan.capsules[1].a, plan.capsules[1].b}) {
      const Eigen::Vector3d moved =
          seen_from_column(plan, end, point) - seen_from_column(plan, start, point);
      CHECK(moved.norm() <= ways.of(plan.pairs[0]) + 1e-12);
      const std::size_t frame = plan.capsules[1].frame;
      const Eigen::Vector3d in_root =
          point_in_root(end[frame], point) - point_in_root(start[frame], point);
      CHECK(in_root.norm() <= ways.of(frame, plan.capsules[1].extent) + 1e-12);
    }
    CHECK(ways.longest() >= ways.of(plan.pairs[0]) - 1e-12);
    CHECK(ways.longest() >= ways.of(plan.capsules[1].frame, plan.capsules[1].extent) - 1e-12);
  }
}

TEST_CASE("ways of a joint that is nowhere are no number, and a margin covers none of them") {
  const Limits limits = with_plates();
  const PathPlan plan(limits);
  Joints nowhere{};
  nowhere[turn_x] = unset;
  const DisplacementBound ways(plan, Joints{}, nowhere), none(plan, Joints{}, Joints{});
  for (const DisplacementBound& lost :
       {ways, DisplacementBound(ways, none), DisplacementBound(none, ways)}) {
    CHECK(std::isnan(lost.longest()));
    CHECK(std::isnan(lost.of(plan.pairs[0])));
    CHECK(clear_fraction(1.0, lost.longest()) == 0.0);
  }
  CHECK(clear_fraction(0.25, 0.5) == 0.5);
  CHECK(clear_fraction(0.5, 0.5) == 1.0);
  CHECK(clear_fraction(0.0, 0.0) == 1.0);
  CHECK(clear_fraction(-0.1, 0.5) == 0.0);
  CHECK(clear_fraction(-0.1, -1e-17) == 0.0);  // a way of nothing, rounded
  CHECK(clear_fraction(unset, 0.5) == 0.0);
}

TEST_CASE("ways by hand: what turns and slides below both of a pair moves neither of them") {
  Limits limits = with_plates();
  limits.kinematics.links[column_link].translation = {0, 0, 0.25};
  limits.collision.capsules[0].link = tool_link - 2;  // on the last slide, before the wrist
  const PathPlan plan(limits);
  Joints there{};
  there[turn_z] = 1.0;
  there[slide_x] = 0.5;
  CHECK(DisplacementBound(plan, Joints{}, there).of(plan.pairs[0]) == doctest::Approx(0.0));
  there[turn_x] = 0.2;
  CHECK(DisplacementBound(plan, Joints{}, there).of(plan.pairs[0]) == doctest::Approx(0.1));
}

TEST_CASE("ways by hand: a point goes as far as its frame turns it, from the first frame on") {
  Limits limits = with_plates();
  limits.kinematics.links[column_link].translation = {0, 0, 0.25};
  const PathPlan plan(limits);
  Joints one{}, other{};
  one[turn_z] = 0.5;
  other[turn_z] = -0.25;
  for (const auto& [from, to] : {std::pair{one, other}, std::pair{other, one}}) {
    const DisplacementBound larger(DisplacementBound(plan, Joints{}, from),
                                   DisplacementBound(plan, Joints{}, to));
    CHECK(larger.of(1, 2.0) == doctest::Approx(1.0));  // 0.5 rad, 2 m from the axis
    CHECK(larger.of(1, 0.0) == doctest::Approx(0.0));
    CHECK(larger.of(0, 2.0) == 0.0);
  }
}
