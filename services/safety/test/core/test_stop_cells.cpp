// G031: in a box of configurations, wherever joints stop, whichever of them first.

#include <doctest/doctest.h>

#include <random>

#include "core/trajectory/stop_cells.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

// The column turns and all slides go on, each by a way of its own: the tool is anywhere in a box
// that turns. A post stands in its way.
struct Stops {
  explicit Stops(std::uint64_t seed) : rng(seed) {
    for (const std::size_t j : {turn_z, slide_x, slide_y, slide_z})
      to[j] = std::uniform_real_distribution<double>(-0.2, 0.2)(rng);
  }

  Joints anywhere() {
    Joints joints{};
    for (std::size_t j = 0; j < joints.size(); ++j)
      joints[j] = std::uniform_real_distribution<double>(0.0, 1.0)(rng) * to[j];
    return joints;
  }

  static Eigen::Vector3d tool_at(const Joints& joints) {
    const RobotModel model(free_arm::limits());
    FramePoses poses;
    poses.place(model, joints);
    return point_in_root(poses[model.tools[arm].place.frame], model.tools[arm].place.position);
  }

  // Between standing and where all come to rest, with a post of such a size around a point.
  std::uint32_t code(const Eigen::Vector3d& post, double half) const {
    Limits limits = free_arm::limits();
    limits.collision.pairs.clear();
    limits.collision.capsules.clear();
    Volume volume{"post", true, {}, {}};
    for (std::size_t i = 0; i < 3; ++i) {
      volume.lower[i] = post[static_cast<Eigen::Index>(i)] - half;
      volume.upper[i] = post[static_cast<Eigen::Index>(i)] + half;
    }
    (void)limits.workspace.volumes.push_back(volume);
    const RobotModel model(limits);
    FramePoses before, middle, corner;
    before.place(model, Joints{});
    ShapeCheck check(model, 0xF);
    QueryBudget budget(100'000);
    return StopCells(model, check, before, budget, middle, corner).certify(Joints{}, to).code;
  }

  std::mt19937_64 rng;
  Joints to{};
};

}  // namespace

TEST_CASE("G031 a post anywhere in the way of a stop is found") {
  std::size_t looked = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    Stops stops(seed);
    const Eigen::Vector3d post = Stops::tool_at(stops.anywhere());
    if ((post - Stops::tool_at(Joints{})).norm() < 0.01) continue;  // there it was before
    CHECK(stops.code(post, 0.002) == 31);
    ++looked;
  }
  CHECK(looked > 50);
}

TEST_CASE("G031 a post beside the way of a stop does not matter") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    Stops stops(seed);
    Joints beside = stops.anywhere();
    // As far up as no stop leads, and 5 mm more.
    beside[slide_z] = std::max(0.0, stops.to[slide_z]) + 0.007;
    CHECK(stops.code(Stops::tool_at(beside), 0.002) == 0);
  }
}
