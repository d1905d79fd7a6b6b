#include "core/trajectory/displacement_bound.hpp"

#include <cmath>

#include "core/geometry/distances.hpp"

namespace fairlead {

DisplacementBound::DisplacementBound(const RobotModel& model, const Joints& from, const Joints& to)
    : model_(model) {
  add_up([&](std::size_t frame) {
    const std::size_t j = model.frames[frame].joint;
    return std::abs(to[j] - from[j]);
  });
}

DisplacementBound::DisplacementBound(const RobotModel& model, const Joints& ways) : model_(model) {
  add_up([&](std::size_t frame) { return ways[model.frames[frame].joint]; });
}

DisplacementBound::DisplacementBound(const DisplacementBound& one, const DisplacementBound& other)
    : model_(one.model_) {
  add_up([&](std::size_t frame) { return larger(one.change_[frame], other.change_[frame]); });
}

template <class Change>
void DisplacementBound::add_up(const Change& change) {
  sums_[0] = {0.0, 0.0, 0.0};
  for (std::size_t f = 1; f < model_.frames.size(); ++f) {
    const ModelFrame& frame = model_.frames[f];
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
  return (model_.frames[frame].distance + extent) * (far.turned - near.turned) -
         (far.leverage - near.leverage) + (far.slid - near.slid);
}

// Half the second derivative. Of two joints that turn it is at most the point's distance from the
// outer one, which is the smaller of both bounds; of a turn and what slides on it, 1.
double DisplacementBound::bend(std::size_t frame, double extent, std::size_t base) const {
  const double turned = sums_[frame].turned - sums_[base].turned;
  const double slid = sums_[frame].slid - sums_[base].slid;
  return 0.5 * turned * (of(frame, extent, base) + slid);
}

double DisplacementBound::of(const ModelPair& pair) const {
  const ModelCapsule &first = model_.capsules[pair.first], &second = model_.capsules[pair.second];
  return of(first.frame, first.extent, pair.common) + of(second.frame, second.extent, pair.common);
}

}  // namespace fairlead
