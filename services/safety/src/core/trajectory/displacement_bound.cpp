#include "core/trajectory/displacement_bound.hpp"

#include <cmath>

#include "core/geometry/margin.hpp"

namespace fairlead {

DisplacementBound::DisplacementBound(const PathPlan& plan, const Joints& from, const Joints& to)
    : plan_(plan) {
  add_up([&](std::size_t frame) {
    const std::size_t j = plan.frames[frame].joint;
    return std::abs(to[j] - from[j]);
  });
}

DisplacementBound::DisplacementBound(const DisplacementBound& one, const DisplacementBound& other)
    : plan_(one.plan_) {
  add_up([&](std::size_t frame) { return larger(one.change_[frame], other.change_[frame]); });
}

template <class Change>
void DisplacementBound::add_up(const Change& change) {
  sums_[0] = {0.0, 0.0, 0.0};
  for (std::size_t f = 1; f < plan_.frames.size(); ++f) {
    const PlanFrame& frame = plan_.frames[f];
    Sums& sums = sums_[f];
    sums = sums_[frame.parent];
    change_[f] = change(f);
    longest_ += frame.reach * change_[f];
    if (!frame.turns) {
      sums.slid += change_[f];
      continue;
    }
    sums.turned += change_[f];
    sums.leverage += change_[f] * frame.distance;
  }
}

double DisplacementBound::of(std::size_t frame, double extent, std::size_t base) const {
  const Sums &far = sums_[frame], &near = sums_[base];
  return (plan_.frames[frame].distance + extent) * (far.turned - near.turned) -
         (far.leverage - near.leverage) + (far.slid - near.slid);
}

double DisplacementBound::of(const PlanPair& pair) const {
  const PlanCapsule &first = plan_.capsules[pair.first], &second = plan_.capsules[pair.second];
  return of(first.frame, first.extent, pair.common) + of(second.frame, second.extent, pair.common);
}

}  // namespace fairlead
