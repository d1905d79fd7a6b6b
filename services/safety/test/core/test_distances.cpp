// Distances that the geometric checks measure, against numbers worked out by hand.

#include <doctest/doctest.h>

#include <cmath>

#include "boundary.hpp"
#include "core/geometry/distances.hpp"
#include "core/geometry/zones.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

using Point = Eigen::Vector3d;

// In both orders and from either end it is the same distance.
void check_distance(const Segment& one, const Segment& other, double distance) {
  const Segment one_back{one.b, one.a}, other_back{other.b, other.a};
  for (const Segment& first : {one, one_back})
    for (const Segment& second : {other, other_back}) {
      CHECK(std::abs(segment_distance(first, second) - distance) < 1e-9);
      CHECK(std::abs(segment_distance(second, first) - distance) < 1e-9);
    }
}

}  // namespace

TEST_CASE("segments: crossing, skew, end to side, end to end") {
  const Segment along_x{{-1, 0, 0}, {1, 0, 0}};
  check_distance(along_x, {{0, -1, 0}, {0, 1, 0}}, 0.0);
  check_distance(along_x, {{0.3, -1, 0.5}, {0.3, 1, 0.5}}, 0.5);
  check_distance(along_x, {{0.3, 0.2, 0}, {0.3, 1, 0}}, 0.2);
  check_distance(along_x, {{4, 4, 0}, {4, 9, 0}}, 5.0);
  check_distance(along_x, {{1.3, 0, 0.4}, {2, 0, 1}}, 0.5);
  check_distance(along_x, {{1, 0, 0}, {1, 5, 5}}, 0.0);
}

TEST_CASE("segments: parallel, on one line, almost parallel") {
  const Segment along_x{{0, 0, 0}, {1, 0, 0}};
  check_distance(along_x, {{0.5, 0.3, 0}, {2, 0.3, 0}}, 0.3);
  check_distance(along_x, {{1.3, 0.4, 0}, {2, 0.4, 0}}, 0.5);
  check_distance(along_x, {{-0.5, 0, 0}, {0.5, 0, 0}}, 0.0);
  check_distance(along_x, {{1.25, 0, 0}, {2, 0, 0}}, 0.25);
  for (const double tilt : {1e-4, 1e-6, 1e-8, 1e-10, 1e-15})
    check_distance(along_x, {{0, 0.3, -tilt}, {1, 0.3, tilt}}, 0.3);
  for (const double tilt : {1e-4, 1e-6, 1e-8, 1e-10})  // they cross in the middle
    CHECK(segment_distance(along_x, {{0, -tilt, 0}, {1, tilt, 0}}) < 1e-7);
}

TEST_CASE("segments whose directions differ by a ten-millionth still cross in the middle") {
  const Segment along_x{{0, 0, 0}, {1, 0, 0}};
  CHECK(segment_distance(along_x, {{0, -6e-8, 0}, {1, 6e-8, 0}}) < 5e-9);
}

TEST_CASE("segments: what counts as parallel does not depend on their lengths") {
  // A millimetre crosses a metre at its middle, at an angle of 0.04.
  check_distance({{0, 0, 0}, {1, 0, 0}}, {{0.4995, -0.00002, 0}, {0.5005, 0.00002, 0}}, 0.0);
  check_distance({{0, 0, 0}, {1000, 0, 0}}, {{0, -20, 0}, {1000, 20, 0}}, 0.0);
}

TEST_CASE("segments that are points") {
  const Segment point{{1, 2, 3}, {1, 2, 3}};
  check_distance(point, {{1, 2, 5}, {1, 2, 5}}, 2.0);
  check_distance(point, {{-4, 2, 3}, {9, 2, 3}}, 0.0);
  check_distance(point, {{1, 5, 7}, {1, 9, 7}}, 5.0);
}

TEST_CASE("a distance of what is no number is none") {
  for (const double bad : {not_a_number, infinite})
    for (Eigen::Index i = 0; i < 6; ++i) {
      Segment one{{0, 0, 0}, {1, 0, 0}};
      (i < 3 ? one.a[i] : one.b[i - 3]) = bad;
      const Segment other{{0, 1, 0}, {1, 1, 1}}, point{{0, 1, 0}, {0, 1, 0}};
      for (const Segment& second : {other, point}) {
        CHECK_FALSE(std::isfinite(segment_distance(one, second)));
        CHECK_FALSE(std::isfinite(segment_distance(second, one)));
      }
      if (std::isnan(bad)) CHECK(std::isnan(box_distance(one, {{2, 2, 2}, {3, 3, 3}})));
    }
  CHECK(std::isnan(box_distance({{0, 0, 0}, {1, 0, 0}}, {{2, 2, 2}, {3, not_a_number, 3}})));
  CHECK(std::isnan(box_distance({{0, 0, 0}, {1, 0, 0}}, {{2, not_a_number, 2}, {3, 3, 3}})));
}

TEST_CASE("a segment and a box: beside a face, an edge and a corner, and passing by") {
  const Box box{{0, 0, 0}, {1, 2, 3}};
  const auto check = [&box](const Point& a, const Point& b, double distance) {
    CHECK(std::abs(box_distance({a, b}, box) - distance) < 1e-12);
    CHECK(std::abs(box_distance({b, a}, box) - distance) < 1e-12);
  };
  check({1.5, 1, 1}, {3, 1, 1}, 0.5);
  check({1.5, -1, 1}, {1.5, 5, 1}, 0.5);
  check({1.3, 2.4, 0}, {1.3, 2.4, 2}, 0.5);
  check({2, 4, 5}, {2, 4, 5}, 3.0);
  check({2, 1, 1}, {1, 3, 1}, 1.0 / std::sqrt(5.0) * 0.0 + std::hypot(0.4, 0.2));
  check({-3, 1, -1}, {4, 1, -1}, 1.0);
  check({1, 1, 1}, {2, 1, 1}, 0.0);  // touches a face
}

TEST_CASE("a plate without thickness is a box") {
  const Box plate{{0, 0, 1}, {1, 2, 1}};
  CHECK(box_distance({{0.5, 1, 1.25}, {0.5, 1, 1.25}}, plate) == 0.25);
  CHECK(box_distance({{0.5, 1, 0.5}, {0.5, 1, -3}}, plate) == 0.5);
  CHECK(std::isnan(box_distance({{0.5, 1, 0.5}, {0.5, 1, -3}}, {{0, 0, 1}, {1, 2, 0.5}})));
}

TEST_CASE("a segment that only falls towards a box, or only rises, is nearest at its end") {
  const Box box{{0, 0, 0}, {1, 2, 3}};
  CHECK(box_distance({{4, 1, 1}, {2, 1, 1}}, box) == 1.0);
  CHECK(box_distance({{2, 1, 1}, {4, 1, 1}}, box) == 1.0);
  CHECK(box_distance({{4, 6, 3}, {4, 6, 3}}, box) == 5.0);      // beside an edge, a point: 3 and 4
  CHECK(box_distance({{1.5, 0, 0}, {1.5, 0, 3}}, box) == 0.5);  // along a face, at every share
  CHECK(box_distance({{3, 4, 1}, {2, 3, 1}}, box) == doctest::Approx(std::sqrt(2.0)));
}

TEST_CASE("a segment that falls towards one face of a box and then leaves another") {
  // Above the box until share 0.5, then beside it, too: nearest 0.3 beside and 0.6 above.
  const double distance = std::sqrt(0.45);
  const Box in_x{{0, 0, 0}, {1, 2, 3}}, in_y{{0, 0, 0}, {2, 1, 3}}, in_z{{0, 0, 0}, {2, 3, 1}};
  CHECK(box_distance({{0.5, 3, 1}, {1.5, 2.5, 1}}, in_x) == doctest::Approx(distance));
  CHECK(box_distance({{3, 0.5, 1}, {2.5, 1.5, 1}}, in_y) == doctest::Approx(distance));
  CHECK(box_distance({{3, 1, 0.5}, {2.5, 1, 1.5}}, in_z) == doctest::Approx(distance));
}

TEST_CASE("a box whose lower face is above its upper one is none, in any direction") {
  const Segment far{{5, 5, 5}, {6, 5, 5}};
  CHECK(box_distance(far, {{0, 0, 0}, {1, 1, 1}}) > 0.0);
  CHECK(std::isnan(box_distance(far, {{1, 0, 0}, {0, 1, 1}})));
  CHECK(std::isnan(box_distance(far, {{0, 1, 0}, {1, 0, 1}})));
  CHECK(std::isnan(box_distance(far, {{0, 0, 1}, {1, 1, 0}})));
}

TEST_CASE("a segment that reaches into a box lies as deep as its nearest way out") {
  const Box box{{0, 0, 0}, {1, 2, 3}};
  CHECK(box_distance({{0.25, 1, 1}, {0.25, 1, 1}}, box) == doctest::Approx(-0.25));
  CHECK(box_distance({{0.9, 1, 1}, {5, 1, 1}}, box) == doctest::Approx(-0.1));
  CHECK(box_distance({{-1, 1, 1}, {5, 1, 1}}, box) == doctest::Approx(-1.0));
  CHECK(box_distance({{0.5, 1, 1.5}, {0.5, 1, 1.6}}, box) == doctest::Approx(-0.5));
}

namespace {

Polygon polygon(std::initializer_list<Corner> corners) {
  Polygon shape;
  for (const Corner& corner : corners) (void)shape.push_back(corner);
  return shape;
}

Polygon unit_square(double x, double y) {
  return polygon({{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}});
}

}  // namespace

TEST_CASE("polygons apart, touching and overlapping") {
  CHECK(separation(unit_square(0, 0), unit_square(1.5, 0)) == doctest::Approx(0.5));
  CHECK(separation(unit_square(0, 0), unit_square(-3, 0.5)) == doctest::Approx(2.0));
  CHECK(separation(unit_square(0, 0), unit_square(1, 0)) == doctest::Approx(0.0));
  CHECK(separation(unit_square(0, 0), unit_square(0.75, 0.5)) == doctest::Approx(-0.25));
  // A diamond before the square's corner: only its own edge parts them.
  const Polygon diamond = polygon({{1.2, 1.0}, {2.2, 2.0}, {1.2, 3.0}, {0.2, 2.0}});
  CHECK(separation(unit_square(0, 0), diamond) == doctest::Approx(0.2 / std::sqrt(2.0)));
  CHECK(separation(diamond, unit_square(0, 0)) == doctest::Approx(0.2 / std::sqrt(2.0)));
  CHECK(std::isnan(separation(unit_square(0, 0), unit_square(not_a_number, 0))));
}

TEST_CASE("corners inside a polygon") {
  const Polygon hall = polygon({{-2, -2}, {3, -2}, {3, 3}, {-2, 3}});
  CHECK(inside(unit_square(0, 0), hall) == doctest::Approx(2.0));
  CHECK(inside(unit_square(1.75, 0), hall) == doctest::Approx(0.25));
  CHECK(inside(unit_square(2.5, 0), hall) == doctest::Approx(-0.5));
  CHECK(std::isnan(inside(unit_square(0, not_a_number), hall)));
}

TEST_CASE("out of a box it is along the gap, or from inside through the nearest face") {
  const Box box{{0, 0, 0}, {1, 1, 1}};
  const auto out = [&](const Point& a, const Point& b) { return box_direction({a, b}, box); };
  const Point up = Point::UnitX(), down = -Point::UnitY(), apart(0.6, 0.0, 0.8);
  CHECK((out(Point(1.3, 0.2, 1.4), Point(1.3, 0.7, 1.4)) - apart).norm() < 1e-12);
  CHECK(out(Point(0.9, 0.5, 0.5), Point(0.9, 0.5, 0.4)) == up);
  CHECK(out(Point(0.5, 0.2, 0.5), Point(0.6, 0.2, 0.5)) == down);
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      Point near = Point::Constant(0.5);
      near[axis] += 0.4 * side;
      CHECK(out(near, near) == side * Point::Unit(axis));
    }
}
