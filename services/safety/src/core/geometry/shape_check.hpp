// G031 and G032: tools and capsules in one configuration, against volumes and each other.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "core/chunk/judgement.hpp"
#include "core/geometry/distances.hpp"
#include "core/kinematics/forward_kinematics.hpp"
#include "core/trajectory/displacement_bound.hpp"

namespace fairlead {

/// By how much the shapes of a configuration are clear at least: what is near one by one, what is
/// further away all together [m].
struct Clearance {
  struct Near {
    std::size_t shape;  // which of the ShapeCheck's
    double margin;
  };
  double others = 0.0;
  std::size_t near_count = 0;
  std::array<Near, max_capsule_pairs + max_parts + max_capsules> near;

  void add(std::size_t shape, double margin) { near[near_count++] = {shape, margin}; }
};

/// All configurations in which no joint is further than `half` from `middle`. `poses`: in the
/// middle. `bound`: of what moves from there to anywhere in it.
struct Cell {
  const Joints& middle;
  const Joints& half;
  const FramePoses& poses;
  const DisplacementBound& bound;
};

/// A corner of a cell, by what each joint goes from the middle; and what is left to a limit there,
/// by the velocities in the middle. Nothing in the cell has less by more than `bend`.
struct CellCorner {
  double margin = std::numeric_limits<double>::infinity();
  double bend = 0.0;
  Joints ways{};

  [[nodiscard]] double least() const { return margin - bend; }
};

class WorstCorner;

class ShapeCheck {
 public:
  /// Of what any of `commanded` moves. `guessed`: joints of tools commanded by motions, of which
  /// a controller makes what it likes. What these broke they may mend, or an operator has to: a
  /// tool outside its box as long as that brings it nearer, capsules too near each other not at
  /// all.
  ShapeCheck(const RobotModel& model, JointSet commanded, JointSet guessed = 0);

  [[nodiscard]] bool has_nothing() const {
    return pairs_.empty() && tools_.empty() && capsules_.empty();
  }

  /// From here on tools and capsules may be so far from where they are predicted. What is nearer to
  /// a limit than that is at fault, also where it was before: nobody knows that it stays.
  void drift_by(double tool, double clearance) {
    tool_drift_ = tool;
    clearance_drift_ = clearance;
  }

  /// A row begins: the joints are where they are said to be, unless they may be so far from there,
  /// each either way. What is nearer to a limit than that takes a tool or capsule is at fault,
  /// unless it was even nearer where the row begins, by what was said for the row before.
  void begin_row() {
    deviation_before_.reset();
    if (deviation_) deviation_before_.emplace(*deviation_);
    deviation_.reset();
  }
  void deviate_by(const Joints& ways) { deviation_.emplace(model_, ways); }

  /// The targets of the row before the first. A row may leave what is broken no further beyond
  /// the limit than they do: else an arm that sags, commanded each time to where it is, or a little
  /// better, would sink without end.
  void note_targets_before(const FramePoses& poses) { targets_before_ = &poses; }

  /// What is at fault in a configuration. What was broken in the one before may stay as it was.
  /// Without a fault, `found`: how clear it is, which need not be more than `share` of the bound.
  Evidence check(const FramePoses& poses, const FramePoses& before, const DisplacementBound& bound,
                 double share, Clearance& found);

  /// The same, as far as all of the bound.
  Evidence check(const FramePoses& poses, const FramePoses& before, const DisplacementBound& bound,
                 Clearance& found) {
    return check(poses, before, bound, 1.0, found);
  }

  /// Which share of its way everything is clear by at least, 1 at most.
  [[nodiscard]] double clear_fraction_of(const Clearance& clearance,
                                         const DisplacementBound& bound) const;
  /// How far a shape moves at most [m].
  [[nodiscard]] double bound_of(std::size_t shape, const DisplacementBound& bound) const;
  /// Joints that move it.
  [[nodiscard]] JointSet movers_of(std::size_t shape) const;
  /// Where in a cell it comes nearest to a limit, to first order; or to where it was beyond that in
  /// `before`.
  [[nodiscard]] CellCorner worst_corner(std::size_t shape, const FramePoses& before,
                                        const Cell& cell) const;

 private:
  Evidence check_volumes(const FramePoses& poses, const FramePoses& before, Clearance& found) const;
  Evidence keep_tool_in(std::size_t part, std::size_t index, const FramePoses& poses,
                        const FramePoses& before, double& slack) const;
  Evidence keep_tool_out(std::size_t part, std::size_t volume, const FramePoses& poses,
                         const FramePoses& before, double& slack) const;
  Evidence keep_capsule_out(std::size_t capsule, std::size_t volume, const FramePoses& poses,
                            const FramePoses& before, double& slack) const;
  Evidence check_pairs(const FramePoses& poses, const FramePoses& before,
                       const DisplacementBound& bound, double share, Clearance& found);
  void add_pair(const ModelPair& pair, const FramePoses& before, const Cell& cell,
                WorstCorner& worst) const;
  void add_tool(const ModelTool& tool, const Volume& volume, const FramePoses& before,
                const Cell& cell, WorstCorner& worst) const;
  void add_capsule(std::size_t capsule, const Volume& volume, const FramePoses& before,
                   const Cell& cell, WorstCorner& worst) const;
  [[nodiscard]] Segment segment(std::size_t capsule, const FramePoses& poses) const;
  [[nodiscard]] double pair_distance(const ModelPair& pair, const FramePoses& poses) const;
  [[nodiscard]] Evidence of_part_that_moves(Evidence evidence, JointSet movers) const;

  static Box box_of(const Volume& volume) { return {vector(volume.lower), vector(volume.upper)}; }
  static Eigen::Vector3d tool_at(const ModelTool& tool, const FramePoses& poses) {
    return point_in_root(poses[tool.place.frame], tool.place.position);
  }
  // How far something may be from where it is placed [m].
  static double off(const std::optional<DisplacementBound>& deviation, const ModelTool& tool) {
    return deviation ? deviation->of(tool.place.frame, tool.place.position.norm()) : 0.0;
  }
  static double off(const std::optional<DisplacementBound>& deviation,
                    const ModelCapsule& capsule) {
    return deviation ? deviation->of(capsule.frame, capsule.extent) : 0.0;
  }
  static double off(const std::optional<DisplacementBound>& deviation, const ModelPair& pair) {
    return deviation ? deviation->of(pair) : 0.0;
  }
  // How far beyond its limit something may stay that was so before.
  static double excused(double margin_before, Excuse excuse) {
    return excuse == Excuse::none ? 0.0 : std::max(-margin_before, 0.0);
  }
  [[nodiscard]] Excuse excuse_of(JointSet movers, double drift, Excuse if_guessed) const {
    if (drift > 0.0) return Excuse::none;
    return (movers & guessed_) != 0 ? if_guessed : Excuse::as_it_is;
  }

  template <class MarginOf>
  [[nodiscard]] bool is_at_fault(double margin, const FramePoses& before, Excuse excuse,
                                 const MarginOf& margin_of) const {
    const auto margin_before = [&] { return margin_of(before); };
    if (is_breach(margin, margin_before, excuse)) return true;
    return margin < 0.0 && targets_before_ != nullptr &&
           margin < margin_of(*targets_before_) - unchanged;
  }

  const RobotModel& model_;
  const FramePoses* targets_before_ = nullptr;
  JointSet commanded_;
  JointSet guessed_;
  double tool_drift_ = 0.0;
  double clearance_drift_ = 0.0;
  std::optional<DisplacementBound> deviation_, deviation_before_;
  // Shapes are counted through all three:
  FixedVec<std::uint16_t, max_capsule_pairs> pairs_;
  FixedVec<std::uint8_t, max_parts> tools_;        // by part
  FixedVec<std::uint8_t, max_capsules> capsules_;  // that volumes keep out
};

}  // namespace fairlead
