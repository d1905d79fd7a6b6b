// Where a cell of configurations comes nearest to a limit. A cell of one configuration leaves what
// that leaves, whatever drifts, deviates or was broken before; a wider one no more than any in it.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "core/geometry/shape_check.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr JointSet turning = JointSet{1} << turn_z;

// A flag on the column, a tool of its own, at (2, 0, 0); two capsules beside it. Where the column
// turns to, they leave a room and come near a post, a shelf and a ball that stand there.
Limits flag() {
  Limits limits = with_flag();
  limits.collision.capsules[0] = {0, {1.5, 1.5, 0}, {1.5, 1.5, 0.5}, 0.2};
  limits.collision.capsules[1] = {column_link, {2, 0, -0.25}, {2, 0.1, 0.25}, 0.125};
  (void)limits.collision.capsules.push_back({column_link, {1.5, 0.5, 0}, {1.6, 0.6, 0}, 0.25});
  limits.collision.clearance = 0.02;
  limits.workspace.volumes[0] = {"room", false, {-10, -10, -10}, {10, 1.2, 10}};
  (void)limits.workspace.volumes.push_back({"shelf", true, {1, 1.4, -1}, {3, 4, 1}});
  (void)limits.workspace.volumes.push_back({"post", true, {2.6, 0.6, 0.1}, {2.7, 0.8, 0.2}});
  return limits;
}

Joints turned(double turn, double slide = 0.0) {
  Joints joints{};
  joints[turn_z] = turn;
  joints[slide_x] = slide;
  return joints;
}

struct Case {
  Joints deviation_before{};
  Joints deviation{};
  double tool_drift = 0.0, clearance_drift = 0.0;
};

// A row of a check, which begins at `before`.
struct CheckedRow {
  CheckedRow(const RobotModel& robot, const Case& one) : model(robot), check(robot, turning) {
    check.drift_by(one.tool_drift, one.clearance_drift);
    check.deviate_by(one.deviation_before);
    check.begin_row();
    check.deviate_by(one.deviation);
  }

  // What each shape is clear by [m].
  std::map<std::size_t, double> margins(const Joints& joints, const FramePoses& before) {
    FramePoses poses;
    poses.place(model, joints);
    Clearance found;
    const DisplacementBound far(model, Joints{}, turned(3.0, 10.0));
    CHECK(check.check(poses, before, far, found).ok());
    std::map<std::size_t, double> margins;
    for (std::size_t i = 0; i < found.near_count; ++i)
      margins[found.near[i].shape] = found.near[i].margin;
    CHECK(margins.size() == 5);
    return margins;
  }

  CellCorner corner(std::size_t shape, const Joints& middle, const Joints& half,
                    const FramePoses& before) {
    FramePoses poses;
    poses.place(model, middle);
    const DisplacementBound bound(model, half);
    return check.worst_corner(shape, before, {middle, half, poses, bound});
  }

  const RobotModel& model;
  ShapeCheck check;
};

void check_single(const Case& one) {
  const Limits limits = flag();
  const RobotModel model(limits);
  FramePoses before;
  before.place(model, Joints{});
  CheckedRow row(model, one);
  const Joints here = turned(0.1);
  for (const auto& [shape, margin] : row.margins(here, before)) {
    CAPTURE(shape);
    const CellCorner corner = row.corner(shape, here, Joints{}, before);
    CHECK(corner.margin == doctest::Approx(margin).epsilon(1e-9));
    CHECK(corner.bend == 0.0);
  }
}

}  // namespace

TEST_CASE("a cell of one configuration leaves what that leaves") {
  check_single({});
  check_single({turned(0.03), turned(0.01)});
  check_single({turned(0.03), turned(0.01), 0.03, 0.05});
  check_single({{}, {}, 0.03, 0.0});
  check_single({{}, {}, 0.0, 0.05});
}

TEST_CASE(
    "what was broken before may stay, off by what was said of that row; but not if it drifts") {
  // Everything on the column is in, or beyond, what it should keep out of or in.
  const Limits limits = flag();
  const RobotModel model(limits);
  const Joints here = turned(0.75);
  FramePoses poses;
  poses.place(model, here);
  const double flag_tool = 2.0, first = std::hypot(2.0, 0.1, 0.25), second = std::hypot(1.6, 0.6);
  for (const auto& [shape, extent] :
       {std::pair{0U, first}, {2U, flag_tool}, {3U, first}, {4U, second}}) {
    CAPTURE(shape);
    const auto left = [&](const Case& one) {
      return CheckedRow(model, one).corner(shape, here, Joints{}, poses).margin;
    };
    CHECK(left({}) == doctest::Approx(0.0).epsilon(1e-9));
    CHECK(left({turned(0.03), turned(0.01)}) == doctest::Approx(0.02 * extent));
    CHECK(left({turned(0.01), turned(0.03)}) == doctest::Approx(-0.02 * extent));
    CHECK(left({turned(0.03), turned(0.01), 0.02, 0.02}) < -0.03);
  }
}

TEST_CASE("G031 a tool in a volume may stay as far in as it may have been") {
  Limits limits = flag();
  limits.collision.pairs.clear();
  limits.collision.capsules[1] = {column_link, {1, 0, 0}, {1, 0, 0}, 0.1};
  limits.collision.capsules.erase_at(2);
  limits.workspace.volumes.erase_at(1);
  limits.workspace.volumes[1] = {"post", true, {1.9, -0.1, -0.1}, {2.1, 0.1, 0.1}};
  const RobotModel model(limits);
  FramePoses poses;
  poses.place(model, Joints{});
  const auto code = [&](const Case& one) {
    const DisplacementBound far(model, Joints{}, turned(3.0, 10.0));
    Clearance found;
    return CheckedRow(model, one).check.check(poses, poses, far, found).code;
  };
  CHECK(code({turned(0.03), turned(0.01)}) == 0);
  CHECK(code({turned(0.01), turned(0.03)}) == 31);
}

TEST_CASE("no configuration of a cell leaves less than its worst corner, but by its bend") {
  const Limits limits = flag();
  const RobotModel model(limits);
  FramePoses before;
  before.place(model, Joints{});
  CheckedRow row(model, {{}, turned(0.002), 0.01, 0.01});
  Joints half{};
  half[turn_z] = 0.08;
  half[slide_x] = 0.05;
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  const Joints middle = turned(0.15);
  for (const auto& entry : row.margins(middle, before)) {
    const std::size_t shape = entry.first;
    CAPTURE(shape);
    const CellCorner corner = row.corner(shape, middle, half, before);
    CHECK(corner.bend > 0.0);
    CHECK(std::abs(corner.ways[turn_z]) == half[turn_z]);
    for (std::size_t j = 1; j < half.size(); ++j)
      if (j != slide_x) CHECK(corner.ways[j] == 0.0);
    double least = entry.second;
    for (int i = 0; i < 200; ++i) {
      Joints joints = middle;
      for (const std::size_t j : {turn_z, slide_x}) joints[j] += share(rng) * half[j];
      least = std::min(least, row.margins(joints, before).at(shape));
    }
    CHECK(least >= corner.least());
  }
}
