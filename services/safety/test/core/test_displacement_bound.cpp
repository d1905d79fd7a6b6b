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
Eigen::Vector3d seen_from_column(const RobotModel& model, const FramePoses& poses,
                                 const Eigen::Vector3d& end) {
  const Pose& column = poses[model.places[column_link].frame];
  const Eigen::Vector3d point = point_in_root(poses[model.capsules[1].frame], end);
  return column.rotation.transpose() * (point - column.position);
}

}  // namespace

TEST_CASE("ways by hand: the wrist's turns reach 0.5 m, a slide goes as far as it is told") {
  const Limits limits = with_plates();
  const RobotModel model(limits);
  const Joints rest{};
  const auto way = [&](std::uint8_t joint, double change) {
    Joints there{};
    there[joint] = change;
    return DisplacementBound(model, rest, there).of(model.pairs[0]);
  };
  CHECK(way(turn_x, 0.2) == doctest::Approx(0.1));
  CHECK(way(turn_y, -0.1) == doctest::Approx(0.05));
  CHECK(way(slide_x, 0.03) == doctest::Approx(0.03));
  CHECK(way(turn_z, 1.0) == 0.0);  // carries both plates
  Joints one{}, other{};
  one[turn_x] = 0.2;
  other[turn_x] = 0.1;
  other[slide_y] = -0.5;
  const DisplacementBound larger(DisplacementBound(model, rest, one),
                                 DisplacementBound(model, rest, other));
  CHECK(larger.of(model.pairs[0]) == doctest::Approx(0.1 + 0.5));
}

TEST_CASE("ways: nothing goes further than they say, and none is longer than the longest") {
  const Limits limits = with_plates();
  const RobotModel model(limits);
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    const Joints from = anywhere(random), to = anywhere(random);
    const DisplacementBound bound(model, from, to);
    FramePoses start, end;
    start.place(model, from);
    end.place(model, to);
    for (const Eigen::Vector3d& point : {model.capsules[1].a, model.capsules[1].b}) {
      const Eigen::Vector3d moved =
          seen_from_column(model, end, point) - seen_from_column(model, start, point);
      CHECK(moved.norm() <= bound.of(model.pairs[0]) + 1e-12);
      const std::size_t frame = model.capsules[1].frame;
      const Eigen::Vector3d in_root =
          point_in_root(end[frame], point) - point_in_root(start[frame], point);
      CHECK(in_root.norm() <= bound.of(frame, model.capsules[1].extent) + 1e-12);
    }
    CHECK(bound.longest() >= bound.of(model.pairs[0]) - 1e-12);
    CHECK(bound.longest() >= bound.of(model.capsules[1].frame, model.capsules[1].extent) - 1e-12);
  }
}

TEST_CASE("ways of a joint that is nowhere are no number, and a margin covers none of them") {
  const Limits limits = with_plates();
  const RobotModel model(limits);
  Joints nowhere{};
  nowhere[turn_x] = unset;
  const DisplacementBound bound(model, Joints{}, nowhere), none(model, Joints{}, Joints{});
  for (const DisplacementBound& lost :
       {bound, DisplacementBound(bound, none), DisplacementBound(none, bound)}) {
    CHECK(std::isnan(lost.longest()));
    CHECK(std::isnan(lost.of(model.pairs[0])));
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
  const RobotModel model(limits);
  Joints there{};
  there[turn_z] = 1.0;
  there[slide_x] = 0.5;
  CHECK(DisplacementBound(model, Joints{}, there).of(model.pairs[0]) == doctest::Approx(0.0));
  there[turn_x] = 0.2;
  CHECK(DisplacementBound(model, Joints{}, there).of(model.pairs[0]) == doctest::Approx(0.1));
}

TEST_CASE("ways by hand: a point goes as far as its frame turns it, from the first frame on") {
  Limits limits = with_plates();
  limits.kinematics.links[column_link].translation = {0, 0, 0.25};
  const RobotModel model(limits);
  Joints one{}, other{};
  one[turn_z] = 0.5;
  other[turn_z] = -0.25;
  for (const auto& [from, to] : {std::pair{one, other}, std::pair{other, one}}) {
    const DisplacementBound larger(DisplacementBound(model, Joints{}, from),
                                   DisplacementBound(model, Joints{}, to));
    CHECK(larger.of(1, 2.0) == doctest::Approx(1.0));  // 0.5 rad, 2 m from the axis
    CHECK(larger.of(1, 0.0) == doctest::Approx(0.0));
    CHECK(larger.of(0, 2.0) == 0.0);
  }
}

TEST_CASE("bends by hand: a turn's is half its square, a slide's on it its product, else none") {
  const Limits limits = with_plates();
  const RobotModel model(limits);
  const ModelCapsule& plate = model.capsules[1];  // 0.5 m from the wrist's axes
  const std::size_t column = model.places[column_link].frame;
  const auto bend = [&](double wrist, double slid, double turned, std::size_t base) {
    Joints ways{};
    ways[turn_x] = wrist;
    ways[slide_y] = slid;
    ways[turn_z] = turned;
    return DisplacementBound(model, ways).bend(plate.frame, plate.extent, base);
  };
  CHECK(bend(0.2, 0.0, 0.0, 0) == doctest::Approx(0.5 * 0.2 * 0.2 * 0.5));
  CHECK(bend(0.0, 0.3, 0.0, 0) == 0.0);
  // The slide carries the wrist's turn: that bends no more than without. Its own turn is the
  // base's.
  CHECK(bend(0.0, 0.3, 0.1, 0) >= 0.1 * 0.3);
  CHECK(bend(0.0, 0.3, 0.1, 0) - bend(0.0, 0.0, 0.1, 0) == doctest::Approx(0.1 * 0.3));
  CHECK(bend(0.2, 0.3, 0.1, column) == doctest::Approx(bend(0.2, 0.3, 0.0, 0)));
  CHECK(bend(0.2, 0.3, 0.1, model.places[4].frame) == doctest::Approx(bend(0.2, 0.0, 0.0, 0)));
}

TEST_CASE("bends: no way differs by more from what the velocities at its start say") {
  const Limits limits = with_plates();
  const RobotModel model(limits);
  const ModelCapsule& plate = model.capsules[1];
  std::mt19937 random(4);
  const FramePoses rest(model, Joints{});
  double least_left = 1.0;
  for (int i = 0; i < 2000; ++i) {
    const Joints from = anywhere(random);
    Joints ways = anywhere(random), to = from;
    const double scale = std::pow(10.0, -3.0 * (i % 3) / 2.0);
    for (std::size_t j = 0; j < 6; ++j) to[j] += ways[j] *= scale;
    const FramePoses poses(model, from), there(model, to);
    const Eigen::Vector3d point = point_in_root(poses[plate.frame], plate.a);
    Eigen::Vector3d told = point;
    for (std::size_t f = plate.frame; f != 0; f = model.frames[f].parent)
      told += ways[model.frames[f].joint] * motion_with(model.frames[f], poses[f], point).head<3>();
    for (double& way : ways) way = std::abs(way);
    const double bend = DisplacementBound(model, ways).bend(plate.frame, plate.extent);
    const double left = bend - (point_in_root(there[plate.frame], plate.a) - told).norm();
    CHECK(left >= 0.0);
    least_left = std::min(least_left, left / bend);
  }
  CHECK(least_left < 0.95);  // it is not without end
}
