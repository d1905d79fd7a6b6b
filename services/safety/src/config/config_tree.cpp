#include "config/config_tree.hpp"

#include "config/config_values.hpp"

namespace fairlead {
namespace {

using nlohmann::json;

LinkMotion read_motion(Section& section) {
  const std::string kind = section.text("kind", 64);
  if (kind == "fixed") return LinkMotion::fixed;
  if (kind == "revolute" || kind == "continuous") return LinkMotion::turn;
  if (kind == "prismatic") return LinkMotion::slide;
  refuse(section.path_of("kind"), "fixed, revolute, continuous or prismatic", kind);
}

// A fixed link has no joint: null. Any other has one that the robot measures.
std::size_t read_joint(Section& section, const Limits& limits, LinkMotion motion) {
  const json& name = section.any("joint");
  const bool fixed = motion == LinkMotion::fixed;
  if (fixed && name.is_null()) return max_measured;
  for (std::size_t i = 0; i < limits.joints.size(); ++i)
    if (!fixed && json(limits.joints[i].name.view()) == name) return i;
  for (std::size_t i = 0; i < limits.passive_joints.size(); ++i)
    if (!fixed && json(limits.passive_joints[i].name.view()) == name)
      return limits.joints.size() + i;
  refuse(section.path_of("joint"), fixed ? "null for a fixed link" : "the name of a measured joint",
         name);
}

Link read_link(Section section, const Limits& limits, const Kinematics& before) {
  Link link;
  link.name = name_in(section, "name");
  link.parent = before.find(name_in(section, "parent"));
  if (link.parent == no_link)
    refuse(section.path_of("parent"), "a link that comes before it", section.node().at("parent"));
  link.motion = read_motion(section);
  link.joint = read_joint(section, limits, link.motion);
  link.axis = numbers_in<3>(section, "axis");
  link.translation = numbers_in<3>(section, "translation");
  link.rotation_xyzw = numbers_in<4>(section, "rotation_xyzw");
  section.refuse_unknown_keys();
  return link;
}

}  // namespace

Kinematics read_tree(Section section, const Limits& limits) {
  Kinematics tree;
  Link root;
  root.name = name_in(section, "root");
  append(tree.links, root, section.path_of("root"));
  const json& links = section.list("links");
  for (std::size_t i = 0; i < links.size(); ++i) {
    const std::string path = section.path_of("links", i);
    append(tree.links, read_link(Section(links[i], path), limits, tree), path);
  }
  section.refuse_unknown_keys();
  return tree;
}

std::size_t read_tool(Section& part, const Kinematics& kinematics) {
  const json& name = part.any("tool_frame");
  if (name.is_null()) return no_link;
  for (std::size_t i = 0; i < kinematics.links.size(); ++i)
    if (json(kinematics.links[i].name.view()) == name) return i;
  refuse(part.path_of("tool_frame"), "null or the name of a link of `kinematics`", name);
}

}  // namespace fairlead
