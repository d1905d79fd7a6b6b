// Which places between two clear ends are looked at, and when none is needed.

#include <doctest/doctest.h>

#include <vector>

#include "core/trajectory/sweep.hpp"

using namespace fairlead;

namespace {

struct Looks {
  Evidence evidence;
  std::vector<double> places;
};

// A way on which anything goes `longest` at most. Its ends are clear by `at_ends` of it, each place
// between by `between`; from `fault_at` on, something is at fault.
Looks sweep(double longest, double at_ends, double between = 0.0, double fault_at = 2.0) {
  Looks looks;
  const auto at = [](double place, Joints& joints) { joints[0] = place; };
  const auto part = [](const WayPoint& from, const WayPoint& to) { return to.place - from.place; };
  const auto look = [&](const Joints& joints, double, double& free) {
    looks.places.push_back(joints[0]);
    free = between;
    return joints[0] < fault_at ? Evidence{} : broken_rule(code::collision, "place", "", joints[0]);
  };
  const WayPoint start{0.0, Joints{}, at_ends}, end{1.0, Joints{}, at_ends};
  looks.evidence = check_way(start, end, Way{longest, at, part, look});
  return looks;
}

}  // namespace

TEST_CASE("a way is looked at every 10 mm of its longest") {
  CHECK(sweep(0.01, 0.0).places.empty());
  CHECK(sweep(0.02, 0.0).places == std::vector{0.5});
  CHECK(sweep(0.04, 0.0).places == std::vector{0.5, 0.25, 0.75});
}

TEST_CASE("a way is halved eight times at most, however long it is") {
  CHECK(sweep(0.64, 0.0).places.size() == 63);
  CHECK(sweep(2.56, 0.0).places.size() == 255);
  CHECK(sweep(100.0, 0.0).places.size() == 255);
}

TEST_CASE("a way whose ends are clear by all of it together is clear") {
  CHECK(sweep(100.0, 0.5).places.empty());
  CHECK(sweep(100.0, 0.49).places.size() > 1);
  CHECK(sweep(100.0, 0.25, 0.25).places == std::vector{0.5});  // both halves are, then
}

TEST_CASE("a way ends at the first fault that is found, in the first half or in the second") {
  CHECK(sweep(0.04, 0.0, 0.0, 0.5).places == std::vector{0.5});
  const Looks late = sweep(0.04, 0.0, 0.0, 0.7);
  CHECK(late.places == std::vector{0.5, 0.25, 0.75});
  CHECK(late.evidence.value == 0.75);
}
