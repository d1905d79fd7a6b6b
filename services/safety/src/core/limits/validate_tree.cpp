// Is the robot's description one tree, root first, that measured joints move?

#include "core/limits/validation_text.hpp"

namespace fairlead {
namespace {

template <std::size_t N>
double norm_of(const std::array<double, N>& numbers) {
  double sum = 0.0;
  for (const double number : numbers) sum += number * number;
  return std::sqrt(sum);
}

template <std::size_t N>
Text check_unit(const Text& key, const std::array<double, N>& numbers) {
  const double norm = norm_of(numbers);
  if (std::round(norm * 1e9) == 1e9) return {};
  return phrase(key, ": expected a unit length, got ", norm);
}

// A commanded joint says itself whether it turns or slides; of a passive one only the tree does.
Text check_joint(const Limits& limits, const Link& link, const Text& key) {
  if (link.motion == LinkMotion::fixed) return {};
  if (link.joint >= limits.measured_count()) return phrase(key, ".joint: no such measured joint");
  if (link.joint >= limits.joints.size()) return {};
  const bool slides = limits.joints[link.joint].kind == JointKind::prismatic;
  if (slides == (link.motion == LinkMotion::slide)) return {};
  return phrase(key, ".kind: not that of joint ", limits.joints[link.joint].name);
}

Text check_link(const Limits& limits, std::size_t index) {
  const Link& link = limits.kinematics.links[index];
  if (link.name.empty()) return "kinematics: a link without a name";
  if (index == 0) return {};  // the root hangs on nothing
  const Text key = phrase("kinematics.", link.name);
  if (link.parent >= index) return phrase(key, ".parent: expected a link that comes before it");
  if (!std::isfinite(norm_of(link.translation)))
    return phrase(key, ".translation: expected finite numbers");
  return first_of({check_joint(limits, link, key), check_unit(phrase(key, ".axis"), link.axis),
                   check_unit(phrase(key, ".rotation_xyzw"), link.rotation_xyzw)});
}

}  // namespace

Text check_tree(const Limits& limits) {
  const auto& links = limits.kinematics.links;
  if (links.empty()) return "kinematics: expected a root";
  Text fault = check_names(links, "kinematics");
  for (std::size_t i = 0; i < links.size(); ++i)
    if (fault.empty()) fault = check_link(limits, i);
  return fault;
}

}  // namespace fairlead
