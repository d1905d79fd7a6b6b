// What the plan lays out: how far frames and what hangs on them reach, spheres around capsules,
// names. A tower: a column at 0.25 m turns about z; from 0.5 m on it three slides, each 0.625 m
// long at most; then the wrist, and 0.125 m ahead the tool with its tip 0.375 m on.

#include <doctest/doctest.h>

#include <cmath>

#include "core/trajectory/displacement_bound.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr std::size_t column = 1, ahead = 2, aside = 3, up = 4, wrist = 5, tool = 6;  // frames

Limits tower() {
  Limits limits = free_arm::limits();
  auto& links = limits.kinematics.links;
  links[column].translation = {0, 0, 0.25};
  links[ahead].translation = {0.3, 0, 0.4};
  links[tool].translation = {0.125, 0, 0};
  (void)links.push_back(
      link("tip", tool, LinkMotion::fixed, max_measured, {1, 0, 0}, {0, 0, 0.375}));
  limits.parts[arm].tool = links.size() - 1;
  limits.joints[slide_x].bounds = {-0.5, 0.25, 0.125};
  limits.joints[slide_y].bounds = {-0.25, 0.5, 0.125};
  limits.joints[slide_z].bounds = {0.25, 0.5, 0.125};
  limits.collision.capsules[0] = {column, {0, 0, 1}, {0, 0, 2}, 0.25};
  limits.collision.capsules[1] = {tool, {0.25, 0, 0}, {0, 0, 0}, 0.5};
  limits.collision.clearance = 0.125;
  return limits;
}

}  // namespace

TEST_CASE("a frame is as far from the root as links and slides between them are long at most") {
  const Limits limits = tower();
  const RobotModel model(limits);
  const double distances[] = {0.0, 0.25, 1.375, 2.0, 2.625, 2.625, 2.75};
  for (std::size_t f = 0; f < model.frames.size(); ++f)
    CHECK(model.frames[f].distance == doctest::Approx(distances[f]));
}

TEST_CASE("a slide without bounds is a thousand kilometres long") {
  Limits limits = tower();
  limits.joints[slide_y].bounded = false;
  const RobotModel model(limits);
  CHECK(model.frames[ahead].distance == doctest::Approx(1.375));
  CHECK(model.frames[aside].distance == doctest::Approx(1e6 + 1.375).epsilon(1e-12));
}

TEST_CASE("what hangs on a turning frame reaches no further than its furthest tool or capsule") {
  const Limits limits = tower();
  const RobotModel model(limits);
  CHECK(model.frames[tool].reach == doctest::Approx(0.375));    // the tip, not the capsule
  CHECK(model.frames[wrist].reach == doctest::Approx(0.5));     // 0.125 m before the tool
  CHECK(model.frames[column].reach == doctest::Approx(2.875));  // 0.5, three slides, and 0.5
  for (const std::size_t f : {ahead, aside, up}) CHECK(model.frames[f].reach == 1.0);
  Limits tall = limits;
  tall.collision.capsules[0].b[2] = 4.0;
  const RobotModel taller(tall);
  CHECK(taller.frames[column].reach == 4.0);
}

TEST_CASE("the longest way: each turn times its reach, and each slide") {
  const Limits limits = tower();
  const RobotModel model(limits);
  Joints there{};
  there[turn_z] = -0.1;
  there[slide_x] = 0.2;
  there[turn_x] = 0.3;
  CHECK(DisplacementBound(model, Joints{}, there).longest() ==
        doctest::Approx(0.2875 + 0.2 + 0.1125));
}

TEST_CASE("the sphere around a capsule, and where two of them have the clearance left") {
  const Limits limits = tower();
  const RobotModel model(limits);
  CHECK(model.capsules[0].reach == doctest::Approx(0.75));
  CHECK(model.capsules[1].reach == doctest::Approx(0.625));
  CHECK(model.capsules[0].middle.z() == doctest::Approx(1.5));
  CHECK(model.capsules[0].extent == doctest::Approx(2.0));
  CHECK(model.pairs[0].near == doctest::Approx(1.5));
}

TEST_CASE("what keeps out of a volume has a name: every capsule, and the tool") {
  Limits limits = tower();
  (void)limits.workspace.volumes.push_back({"shelf", true, {5, 5, 5}, {6, 6, 6}});
  const RobotModel model(limits);
  CHECK(model.volumes[1].capsules[0].view() == "column / shelf");
  CHECK(model.volumes[1].capsules[1].view() == "tool / shelf");
  CHECK(model.volumes[1].tool.view() == "tool / shelf");
}

TEST_CASE("the frames between the root and a tool, root side first, and those of them it moves") {
  Limits limits = tower();
  PartLimits flag = part("flag", {turn_z});
  flag.tool = ahead;
  (void)limits.parts.push_back(flag);
  const RobotModel model(limits);
  CHECK(model.tools[arm].chain.size() == 6);
  for (std::size_t i = 0; i < model.tools[arm].chain.size(); ++i) {
    CHECK(model.tools[arm].chain[i] == i + 1);
    CHECK(model.tools[arm].own[i] == i + 1);
  }
  CHECK(model.tools[1].chain.size() == 2);
  CHECK(model.tools[1].chain[0] == column);
  CHECK(model.tools[1].chain[1] == ahead);
  CHECK(model.tools[1].own.size() == 1);
  CHECK(model.tools[1].own[0] == column);
}
