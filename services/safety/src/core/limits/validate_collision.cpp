// Is the robot's shape whole: capsules of finite size on its links, and pairs of them to keep
// apart?

#include "core/limits/validation_text.hpp"

namespace fairlead {
namespace {

Text check_capsule(const Limits& limits, std::size_t index) {
  const Capsule& capsule = limits.collision.capsules[index];
  const Text key = phrase("collision.capsules[", index, "]");
  if (capsule.link >= limits.kinematics.links.size()) return phrase(key, ".link: no such link");
  if (!all_finite(capsule.a)) return phrase(key, ".a: expected finite numbers");
  if (!all_finite(capsule.b)) return phrase(key, ".b: expected finite numbers");
  return positive(phrase(key, ".radius"), capsule.radius);
}

bool same(const CapsulePair& one, const CapsulePair& other) {
  return one.first == other.first && one.second == other.second;
}

// Two capsules of one link are as near as they are: no motion of the robot changes it.
Text check_pair(const CollisionLimits& shape, std::size_t index) {
  const CapsulePair& pair = shape.pairs[index];
  const Text key = phrase("collision.pairs[", index, "]");
  if (!(pair.first < pair.second && pair.second < shape.capsules.size()))
    return phrase(key, ": expected two capsules in ascending order below ", shape.capsules.size(),
                  ", got ", int{pair.first}, " and ", int{pair.second});
  if (shape.capsules[pair.first].link == shape.capsules[pair.second].link)
    return phrase(key, ": expected capsules of two links, got ", int{pair.first}, " and ",
                  int{pair.second}, " of one");
  for (std::size_t i = 0; i < index; ++i)
    if (same(shape.pairs[i], pair))
      return phrase(key, ": ", int{pair.first}, " and ", int{pair.second}, " are there twice");
  return {};
}

}  // namespace

Text check_collision(const Limits& limits) {
  const CollisionLimits& shape = limits.collision;
  if (shape.capsules.empty()) return "collision.capsules: expected at least one";
  if (shape.pairs.empty() && has_tool(limits))
    return "collision.pairs: expected at least one for a robot with a tool";
  Text fault = positive("collision.clearance", shape.clearance);
  for (std::size_t i = 0; i < shape.capsules.size(); ++i)
    if (fault.empty()) fault = check_capsule(limits, i);
  for (std::size_t i = 0; i < shape.pairs.size(); ++i)
    if (fault.empty()) fault = check_pair(shape, i);
  return fault;
}

}  // namespace fairlead
