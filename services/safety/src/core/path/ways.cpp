#include "ways.hpp"

#include <algorithm>
#include <cmath>

namespace fairlead {

Ways::Ways(const PathPlan& plan, const Joints& from, const Joints& to) : plan_(plan) {
  for (std::size_t f = 1; f < plan.frames.size(); ++f) {
    const std::size_t j = plan.frames[f].joint;
    change_[f] = std::abs(to[j] - from[j]);
  }
  add_up();
}

Ways::Ways(const Ways& one, const Ways& other) : plan_(one.plan_) {
  for (std::size_t f = 1; f < plan_.frames.size(); ++f)
    change_[f] = one.change_[f] > other.change_[f] || std::isnan(one.change_[f]) ? one.change_[f]
                                                                                 : other.change_[f];
  add_up();
}

void Ways::add_up() {
  sums_[0] = Sums{};
  for (std::size_t f = 1; f < plan_.frames.size(); ++f) {
    const PlanFrame& frame = plan_.frames[f];
    Sums& sums = sums_[f];
    sums = sums_[frame.parent];
    longest_ += frame.reach * change_[f];
    if (!frame.turns) {
      sums.slid += change_[f];
      continue;
    }
    sums.turned += change_[f];
    sums.leverage += change_[f] * frame.distance;
  }
}

double Ways::of(std::size_t frame, double extent, std::size_t base) const {
  const Sums &far = sums_[frame], &near = sums_[base];
  return (plan_.frames[frame].distance + extent) * (far.turned - near.turned) -
         (far.leverage - near.leverage) + (far.slid - near.slid);
}

double Ways::of(const PlanPair& pair) const {
  const PlanCapsule &first = plan_.capsules[pair.first], &second = plan_.capsules[pair.second];
  return of(first.frame, first.extent, pair.common) + of(second.frame, second.extent, pair.common);
}

}  // namespace fairlead
