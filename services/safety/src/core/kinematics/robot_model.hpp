// What of a robot's limits the prediction needs, laid out once so that a row costs little: its
// moving links, what is around them, and which joints move what. The sum of G050 is over each of
// its bytes, so none lies between the fields: what fills a gap has a name.
#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// Measured joints by index, one bit each.
using JointSet = std::uint64_t;
static_assert(max_measured <= 64);

inline JointSet only(std::size_t joint) { return JointSet{1} << joint; }

inline Eigen::Vector3d vector(const std::array<double, 3>& xyz) { return {xyz[0], xyz[1], xyz[2]}; }

/// Frames of a model by index, one bit each.
using FrameSet = std::uint64_t;
static_assert(max_links <= 64);

/// A link that a joint moves, with the fixed links between it and the one before folded in. Its
/// pose in the one before: `still + cos q * cosine + sin q * sine`, `origin + q * slide`.
struct ModelFrame {
  std::size_t parent = 0;
  std::size_t joint = max_measured;
  bool turns = false;
  std::array<std::uint8_t, 7> gap{};
  Eigen::Matrix3d still = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d cosine = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d sine = Eigen::Matrix3d::Zero();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d slide = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  // in its own axes
  JointSet movers = 0;                             // joints between it and the root
  FrameSet children = 0;                           // frames that hang on it
  // Between its origin and the root's at most, from joint to joint [m].
  double distance = 0.0;
  double reach = 0.0;  // of what hangs on it from its origin at most; 1 if it slides
};

/// Where a link is fixed to a moving one. Nowhere, which every comparison refuses, unless it is one
/// of the tree's.
struct ModelPlace {
  std::size_t frame = 0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Constant(unset);
  Eigen::Vector3d position = Eigen::Vector3d::Constant(unset);
};

struct ModelCapsule {
  std::size_t frame = 0;
  // In the frame [m].
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double radius = unset;
  double reach = unset;   // of its bounding sphere about `middle`
  double extent = unset;  // of its axis from the frame's origin, at most
};

/// What a verdict calls a pair: "link5 / link0".
using ModelName = FixedText<136>;

/// Small: most of what a row costs is going through them.
struct ModelPair {
  std::uint8_t first = 0;
  std::uint8_t second = 0;
  std::uint8_t common = 0;  // the last frame that both hang on
  std::array<std::uint8_t, 5> gap{};
  JointSet movers = 0;  // joints that move one of them relative to the other
  double near = unset;  // distance of the middles at which their spheres have the clearance left
};

/// A part's tool and the frames from the root to it.
struct ModelTool {
  bool present = false;
  std::array<std::uint8_t, 7> gap{};
  ModelPlace place;
  JointSet movers = 0;
  FixedVec<std::uint8_t, max_links> chain;  // frames from the root on, the root left out
  FixedVec<std::uint8_t, max_links> own;    // those of them that the part's joints move
  // How far from the axis of one of the part's joints it moves something at most: a turn of the
  // tool by an angle is as large as a shift by that times this [m/rad]. 0 where none of them turns.
  double reach = 0.0;
};

/// What keeps out of a volume is called: "link5 / shelf", by capsule, and "tool / shelf"; what
/// keeps in, by axis: "tool x / table".
struct ModelVolume {
  std::array<ModelName, max_capsules> capsules;
  ModelName tool;
  std::array<ModelName, 3> axes;
};

/// Made when the gate starts. `limits` must outlive it.
struct RobotModel {
  explicit RobotModel(const Limits& robot_limits);

  const Limits& limits;
  double period_s = unset;
  std::array<ModelPlace, no_link + 1> places;  // by link of the description
  FixedVec<ModelFrame, max_links> frames;      // parents first; the first is the root
  FixedVec<ModelCapsule, max_capsules> capsules;
  FixedVec<ModelPair, max_capsule_pairs> pairs;
  FixedVec<ModelName, max_capsule_pairs> pair_names;
  FixedVec<ModelVolume, max_volumes> volumes;
  std::array<ModelTool, max_parts> tools;
  std::array<JointSet, max_parts> part_joints{};
  std::array<double, max_joints> fastest{};  // that a joint can be commanded (`fastest_command`)
  double base_extent = 0.0;                  // of the footprint from the yaw axis [m]
  JointSet base_joints = 0;
  JointSet tree_joints = 0;  // those that move a link
};

/// `for (const std::size_t joint : JointsIn(set))`: in order of their index.
class JointsIn {
 public:
  explicit JointsIn(JointSet set) : left_(set) {}

  class Iterator {
   public:
    explicit Iterator(JointSet left) : left_(left) {}
    std::size_t operator*() const { return static_cast<std::size_t>(std::countr_zero(left_)); }
    Iterator& operator++() {
      left_ ^= only(**this);
      return *this;
    }
    bool operator==(const Iterator& other) const = default;

   private:
    JointSet left_;
  };

  [[nodiscard]] Iterator begin() const { return Iterator(left_); }
  [[nodiscard]] static Iterator end() { return Iterator(JointSet{}); }

 private:
  JointSet left_;
};

}  // namespace fairlead
