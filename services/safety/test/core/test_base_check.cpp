// The footprint's corners, how far they move and how clear they are: what the check of zones is
// made of. The test robot's footprint is a square of 1 m about its origin.

#include <doctest/doctest.h>

#include <cmath>

#include "core/geometry/zones.hpp"
#include "test_robot.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

const double half_pi = std::acos(0.0);

Polygon polygon(std::initializer_list<Corner> corners) {
  Polygon shape;
  for (const Corner& corner : corners) (void)shape.push_back(corner);
  return shape;
}

Joints at(double x, double y, double yaw) {
  Joints joints{};
  joints[base_x] = x;
  joints[base_y] = y;
  joints[base_yaw] = yaw;
  return joints;
}

// The base stands in a hall of 6 m by 4 m, a pillar behind it.
Limits hall_with_pillar() {
  Limits limits = test_limits();
  limits.base.zones.clear();
  (void)limits.base.zones.push_back({"hall", false, polygon({{-3, -2}, {3, -2}, {3, 2}, {-3, 2}})});
  (void)limits.base.zones.push_back(
      {"pillar", true, polygon({{-2, -0.25}, {-1, -0.25}, {-1, 0.25}, {-2, 0.25}})});
  return limits;
}

}  // namespace

TEST_CASE("two polygons that only one edge parts, whichever edge of which one it is") {
  const Polygon square = polygon({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  // The tip of each points at the middle of an edge, 0.25 m away; no edge of its own parts them.
  for (const Polygon& wedge :
       {polygon({{0, -1.25}, {1, -1.25}, {0.5, -0.25}}),
        polygon({{2.25, 0}, {2.25, 1}, {1.25, 0.5}}), polygon({{1, 2.25}, {0, 2.25}, {0.5, 1.25}}),
        polygon({{-1.25, 1}, {-1.25, 0}, {-0.25, 0.5}})}) {
    CHECK(separation(square, wedge) == doctest::Approx(0.25));
    CHECK(separation(wedge, square) == doctest::Approx(0.25));
  }
}

TEST_CASE("a footprint turns about the yaw axis, which the slides carry") {
  Limits limits = test_limits();
  limits.base.yaw_axis = {0.5, -0.25};
  const Polygon turned = footprint_at(limits.base, at(2.0, 1.0, half_pi));
  // (-0.5, -0.5) is (-1, -0.25) from the axis, turned (0.25, -1); the axis is at (2.5, 0.75).
  CHECK(turned[0][0] == doctest::Approx(2.75));
  CHECK(turned[0][1] == doctest::Approx(-0.25));
  CHECK(turned[2][0] == doctest::Approx(1.75));  // (0.5, 0.5): (0, 0.75), turned (-0.75, 0)
  CHECK(turned[2][1] == doctest::Approx(0.75));
}

TEST_CASE("a base's way: how far each slide goes, and what the turn adds at the furthest corner") {
  Limits limits = test_limits();
  limits.base.footprint = polygon({{-1, -1}, {2, -1}, {2, 3}, {-1, 3}});
  limits.base.yaw_axis = {-1.0, -2.0};  // 3 m and 5 m from the furthest corner
  const RobotModel model(limits);
  CHECK(model.base_extent == doctest::Approx(std::sqrt(34.0)));
  const Joints from = at(0.25, -1.0, 0.5), to = at(3.25, 3.0, -1.5);
  CHECK(base_way(model, from, to) == doctest::Approx(3.0 + 4.0 + 2.0 * std::sqrt(34.0)));
  CHECK(base_way(model, to, from) == base_way(model, from, to));
}

TEST_CASE("the slack of a base is what it is clear by in the zone where that is least") {
  const Limits limits = hall_with_pillar();
  const RobotModel model(limits);
  double slack = 0.0;
  const auto look = [&](const Joints& joints) {
    return check_base(model, joints, joints, {}, slack);
  };
  CHECK(look(at(0, 0, 0)).ok());
  CHECK(slack == doctest::Approx(0.5));  // from the pillar
  CHECK(look(at(2.25, 0, 0)).ok());
  CHECK(slack == doctest::Approx(0.25));  // from the wall
  CHECK(look(at(2.75, 0, 0)).ok());       // stands in the wall already
  CHECK(slack == 0.0);
}

TEST_CASE("the part that is named for a zone is the one that the base's x belongs to") {
  Limits limits = hall_with_pillar();
  limits.joints[base_y].part = arm;
  const RobotModel model(limits);
  double slack = 0.0;
  const Evidence wall = check_base(model, at(2.75, 0, 0), at(2.5, 0, 0), {}, slack);
  CHECK(wall.code == 34);
  CHECK(wall.part == "base");
  CHECK(wall.value == doctest::Approx(-0.25));
}
