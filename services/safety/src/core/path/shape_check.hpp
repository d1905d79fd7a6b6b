// G031 and G032: tools and capsules in one configuration, against volumes and each other.
#pragma once

#include "../evidence.hpp"
#include "distances.hpp"
#include "frames.hpp"

namespace fairlead {

class ShapeCheck {
 public:
  /// Of what any of `commanded` moves.
  ShapeCheck(const PathPlan& plan, JointSet commanded);

  [[nodiscard]] bool has_nothing() const { return pairs_.empty() && !tools_ && !capsules_; }

  /// What is at fault in a configuration. What was broken in the one before may stay as it was.
  /// Without a fault, `slack`: the smallest margin [m], if it is below `need`.
  Evidence look(const FramePoses& poses, const FramePoses& before, double need,
                double& slack) const;

 private:
  Evidence look_at_volumes(const FramePoses& poses, const FramePoses& before, double need,
                           double& slack) const;
  Evidence keep_tool_in(std::size_t part, const Volume& volume, const FramePoses& poses,
                        const FramePoses& before, double& slack) const;
  Evidence keep_tool_out(std::size_t part, std::size_t volume, const FramePoses& poses,
                         const FramePoses& before, double& slack) const;
  Evidence keep_capsule_out(std::size_t capsule, std::size_t volume, const FramePoses& poses,
                            const FramePoses& before, double need, double& slack) const;
  Evidence look_at_pairs(const FramePoses& poses, const FramePoses& before, double need,
                         double& slack) const;
  [[nodiscard]] Segment segment(std::size_t capsule, const FramePoses& poses) const;
  [[nodiscard]] double pair_distance(const PlanPair& pair, const FramePoses& poses) const;
  [[nodiscard]] Evidence of_part_that_moves(Evidence evidence, JointSet movers) const;

  const PathPlan& plan_;
  JointSet commanded_;
  FixedVec<std::uint16_t, max_capsule_pairs> pairs_;
  std::uint64_t tools_ = 0;     // by part, one bit each
  std::uint64_t capsules_ = 0;  // that volumes keep out, one bit each
};

}  // namespace fairlead
