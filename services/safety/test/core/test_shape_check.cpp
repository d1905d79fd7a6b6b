// What a look at the shapes says of how clear they are, and of which share of their ways: numbers
// that decide where else is looked. On the free arm, whose column turns about z.

#include <doctest/doctest.h>

#include <cmath>

#include "core/geometry/shape_check.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr JointSet turning = JointSet{1} << turn_z;

// A look at rest, from where each joint goes as far as `there`; maybe after another one.
struct Look {
  Look(const Limits& limits, const Joints& there, double share, double share_before = 0.0)
      : model(limits), check(model, turning), bound(model, Joints{}, there) {
    FramePoses poses;
    poses.place(model, Joints{});
    if (share_before > 0.0) (void)check.check(poses, poses, bound, share_before, found);
    evidence = check.check(poses, poses, bound, share, found);
  }

  RobotModel model;
  ShapeCheck check;
  DisplacementBound bound;
  Clearance found;
  Evidence evidence;
};

Joints going(double turn, double slide) {
  Joints there{};
  there[turn_z] = turn;
  there[slide_x] = slide;
  return there;
}

// A ball of 0.5 m on the column, 4 m ahead, and one that stands `apart` further on; 0.5 m of
// clearance: their middles may be 1.5 m apart.
Limits balls(double apart) {
  Limits limits = free_arm::limits();
  limits.workspace.volumes.clear();
  limits.collision.capsules[0] = {0, {4.0 + apart, 0, 0}, {4.0 + apart, 0, 0}, 0.5};
  limits.collision.capsules[1] = {column_link, {4, 0, 0}, {4, 0, 0}, 0.5};
  limits.collision.clearance = 0.5;
  return limits;
}

// A flag on the column, a tool of its own, at (2, 0, 0) in a room that ends at 2.25; two capsules
// beside it, before a shelf that begins at 3. The arm's tool is at (0.7, 0, 0.5).
Limits flag() {
  Limits limits = with_flag();
  limits.collision.capsules[1] = {column_link, {2, 0, -0.25}, {2, 0, 0.25}, 0.125};
  (void)limits.collision.capsules.push_back({column_link, {2, 0.5, 0}, {2, 0.5, 0}, 0.25});
  limits.workspace.volumes[0] = {"room", false, {-10, -10, -10}, {2.25, 10, 10}};
  (void)limits.workspace.volumes.push_back({"shelf", true, {3, -1, -1}, {4, 1, 1}});
  return limits;
}

void check_near(const Look& look, std::size_t i, std::size_t shape, double margin) {
  CHECK(look.found.near[i].shape == shape);
  CHECK(look.found.near[i].margin == doctest::Approx(margin));
}

}  // namespace

TEST_CASE("a pair further apart than anything goes is not near") {
  const Limits limits = balls(4.0);
  const Look look(limits, going(0.0, 1.0), 0.5);
  CHECK(look.evidence.ok());
  CHECK(look.found.others == doctest::Approx(0.5));
  CHECK(look.found.near_count == 0);
  CHECK(look.check.clear_fraction_of(look.found, look.bound) == doctest::Approx(0.5));
}

TEST_CASE(
    "a pair whose spheres are clear by its own way is near by that, one nearer by its margin") {
  // The column's ball goes 4 m times 0.125 rad; the slide carries others much further.
  const Limits far = balls(4.0);
  const Look look(far, going(0.125, 4.0), 0.8);
  CHECK(look.evidence.ok());
  CHECK(look.found.others > 0.8 * 4.0);
  CHECK(look.found.near_count == 1);
  check_near(look, 0, 0, 0.4);
  CHECK(look.check.clear_fraction_of(look.found, look.bound) == doctest::Approx(0.8));
  const Limits beside = balls(1.75);
  const Look near(beside, going(0.125, 4.0), 0.8);
  CHECK(near.found.near_count == 1);
  check_near(near, 0, 0, 0.25);
  CHECK(near.check.clear_fraction_of(near.found, near.bound) == doctest::Approx(0.5));
}

TEST_CASE("a pair is clear up to and including its clearance, and that of its spheres") {
  const Limits at = balls(1.5);
  const Look look(at, Joints{}, 1.0);
  CHECK(look.evidence.ok());
  CHECK(look.found.near_count == 0);
  const Limits below = balls(1.25);  // evidence points into it
  const RobotModel model(below);
  ShapeCheck check(model, turning);
  FramePoses here, away;
  here.place(model, Joints{});
  away.place(model, going(0.5, 0.0));
  Clearance found;
  const Evidence hit =
      check.check(here, away, DisplacementBound(model, Joints{}, Joints{}), 1.0, found);
  CHECK(hit.code == 32);
  CHECK(hit.value == doctest::Approx(0.25));
}

TEST_CASE("a pair is looked at that is clear by what anything goes, but not if it is off as well") {
  const Limits limits = balls(2.5);  // clear by 1 m
  const RobotModel model(limits);
  FramePoses poses;
  poses.place(model, Joints{});
  const auto near_count = [&](double off) {
    ShapeCheck check(model, turning);
    check.deviate_by(going(off, 0.0));
    Clearance found;
    CHECK(
        check.check(poses, poses, DisplacementBound(model, Joints{}, going(0.1, 0.0)), found).ok());
    return found.near_count;
  };
  CHECK(near_count(0.0) == 0);
  CHECK(near_count(0.2) == 1);  // 0.8 m
}

TEST_CASE("tools and capsules are near by what they are clear by in the nearest volume") {
  const Limits limits = flag();
  const Look look(limits, going(1.0, 0.0), 1.0);
  CHECK(look.evidence.ok());
  CHECK(look.found.near_count == 4);
  check_near(look, 0, 1, 1.55);  // after the one pair: the arm's tool, in the room
  check_near(look, 1, 2, 0.25);
  check_near(look, 2, 3, 0.875);  // 1 m before the shelf, as thick as it is
  check_near(look, 3, 4, 0.75);
  CHECK(look.check.clear_fraction_of(look.found, look.bound) ==
        doctest::Approx(0.125));  // the flag goes 2 m
}

TEST_CASE(
    "tools and capsules clear by as much as anything goes are not near, whatever was before") {
  Limits limits = flag();
  limits.collision.pairs.clear();
  const Look look(limits, going(0.1, 0.0), 1.0, 0.5);
  CHECK(look.evidence.ok());
  CHECK(look.found.others > 0.25);
  CHECK(look.found.others < 0.75);
  CHECK(look.found.near_count == 1);
  check_near(look, 0, 1, 0.25);
}

TEST_CASE("a capsule is not near if its sphere is clear by as much as anything goes, up to that") {
  Limits limits = free_arm::limits();
  limits.parts[arm].tool = no_link;
  limits.collision.pairs.clear();
  // The sphere is clear by 1.5 m; by its end, with a rounding error, the capsule would be nearer.
  limits.collision.capsules[1] = {column_link, {1.1, 0, 0}, {1.2, 0, 0}, 0.1};
  (void)limits.workspace.volumes.push_back({"shelf", true, {2.8, -1, -1}, {4, 1, 1}});
  CHECK(Look(limits, going(0.0, 1.5), 1.0).found.near_count == 0);
  const Look further(limits, going(0.0, just_above(1.5)), 1.0);
  CHECK(further.found.near_count == 1);
  check_near(further, 0, 0, 1.5);
}

TEST_CASE("the share of its way that a capsule is clear by") {
  const Limits limits = flag();
  const Look look(limits, going(0.5, 0.0), 1.0);
  Clearance clearance;
  clearance.others = look.bound.longest();
  CHECK(look.check.clear_fraction_of(clearance, look.bound) == 1.0);
  clearance.add(3, 0.25);  // its ends are 2.0156 m from the axis
  CHECK(look.check.clear_fraction_of(clearance, look.bound) ==
        doctest::Approx(0.5 / std::hypot(2.0, 0.25)));
}

TEST_CASE("without a tool, a pair and a volume to keep out of there is nothing to look at") {
  Limits limits = flag();
  limits.collision.pairs.clear();
  for (PartLimits& part : limits.parts) part.tool = no_link;
  limits.workspace.volumes[1].keep_out = false;
  const RobotModel none(limits);
  CHECK(ShapeCheck(none, turning).has_nothing());
  limits.workspace.volumes[0].keep_out = true;
  const RobotModel some(limits);
  CHECK_FALSE(ShapeCheck(some, turning).has_nothing());
  CHECK(ShapeCheck(some, JointSet{1} << slide_x).has_nothing());
}

TEST_CASE("a tool that nothing commanded moves is not looked at, whatever it is clear by") {
  // The flag hangs on the column and is 0.25 m from the wall; the slide moves the arm's tool only.
  Limits limits = flag();
  limits.collision.pairs.clear();
  limits.workspace.volumes.erase_at(1);
  const RobotModel model(limits);
  const DisplacementBound bound(model, Joints{}, going(0.0, 1.0));
  FramePoses poses;
  poses.place(model, Joints{});
  const auto near_count = [&](JointSet commanded) {
    ShapeCheck check(model, commanded);
    Clearance found;
    CHECK(check.check(poses, poses, bound, found).ok());
    return found.near_count;
  };
  CHECK(near_count(JointSet{1} << slide_x) == 0);
  CHECK(near_count(turning) == 1);
}
