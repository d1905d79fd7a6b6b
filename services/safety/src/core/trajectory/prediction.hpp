// Where the rows take the joints, row by row from what is measured.
//
// Joint targets are reached within their tick. Of velocities, deltas and twists the declared gain
// says which share happens. The first branch takes the middle of it: the forecast. The others carry
// both ends, in every combination of the parts that have one; with other claims' rows, all of that
// again while those hold: together they bound what can happen. What nothing commands, grippers and
// passive joints stay where they are measured.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/forward_kinematics.hpp"
#include "core/kinematics/inverse_kinematics.hpp"
#include "core/modes/commanded_motion.hpp"
#include "core/trajectory/unequal_shares.hpp"

namespace fairlead {

/// Parts that move links and have a gain, of a chunk and its companions, at most.
inline constexpr std::size_t max_gains = 3;
inline constexpr std::size_t max_branches = 2 * (1 + (std::size_t{1} << max_gains));

/// For each part one share of its gain: the configuration after a row, how fast the joints go
/// there, and the configuration before the row; where the frames are in both.
struct Branch {
  Joints now;
  Joints speed;
  Joints before;
  /// Joints that may go at two speeds, `speed` and `slower`: as measured, and as commanded where
  /// that is slower; or from the two ends from which a first target is reached.
  JointSet slowing = 0;
  Joints slower;
  std::array<FramePoses, 2> poses;
  std::size_t newest = 0;
  /// By part, what its tool was commanded to move and has not yet [m, rad], along the root's axes;
  /// not a number where nobody knows.
  std::array<Motion6, max_parts> left;

  Branch() = default;
  Branch(const Branch& other) { *this = other; }
  /// Without the frames before the row: `begin_row` sets them, and they are most of what a copy
  /// costs.
  Branch& operator=(const Branch& other);

  FramePoses& poses_now() { return poses[newest]; }
  [[nodiscard]] const FramePoses& poses_now() const { return poses[newest]; }
  [[nodiscard]] const FramePoses& poses_before() const { return poses[newest ^ 1U]; }

  /// With the slower speeds.
  [[nodiscard]] Branch slowed() const;
  /// What was reached is what the next row starts from.
  void begin_row() {
    before = now;
    slowing = 0;
    newest ^= 1U;
  }
};

/// Between which positions a joint can be, or how fast, whatever share of each row has happened.
struct Interval {
  Joints lowest;
  Joints highest;
};

class Prediction {
 public:
  Prediction(const RobotModel& model, const ClaimLimits& claim, const MeasuredState& state,
             const ActionChunk& chunk, std::size_t first_row, const RowBefore& before,
             Companions companions);

  /// Goes on by one row, of the chunk and of its companions. G030 where the chunk's leads nowhere.
  Evidence advance();
  /// From here on only the forecast: one branch, and where it is, a joint is.
  void only_forecast();
  [[nodiscard]] bool is_forecast() const { return forecast_only_; }

  [[nodiscard]] std::size_t row() const { return row_; }  // the one that was gone to last
  [[nodiscard]] std::size_t next_row() const { return next_row_; }
  [[nodiscard]] std::size_t branch_count() const { return branch_count_; }
  /// Branches with different shares: the first of them, and as many of each further number that
  /// hold what this chunk does not command.
  [[nodiscard]] std::size_t share_count() const { return share_count_; }
  /// Whether a branch has the lower end of a gain, of which the branch `bit` further has the upper.
  [[nodiscard]] bool has_lower_end(std::size_t index, std::size_t bit) const {
    const std::size_t ends = index % share_count_;
    return ends != 0 && bit < share_count_ - 1 && ((ends - 1) & bit) == 0;
  }
  [[nodiscard]] const Branch& branch(std::size_t index) const { return branches_[index]; }
  /// Joints that the chunk's own rows command.
  [[nodiscard]] JointSet commanded() const { return commanded_; }
  /// Joints whose position or speed changes on the way.
  [[nodiscard]] JointSet moving() const { return moving_; }
  /// Those of them that go on for their stop lag before they brake: commanded a motion, not a
  /// target, or left to themselves while they move.
  [[nodiscard]] JointSet lagging() const { return lagging_ | coasting_; }
  /// Joints of tools that are commanded a motion of which not all may happen.
  [[nodiscard]] JointSet guessed() const { return guessed_; }
  /// Whether the base moves, or did when the state was measured.
  [[nodiscard]] bool drives_base() const { return (moving_ & model_.base_joints) != 0; }
  /// The fastest of its joints, in their velocity limits: measured, and in all certified rows so
  /// far; later of the newest row and when that began.
  [[nodiscard]] double base_speed() const { return std::max(base_speed_, base_speed_before_); }
  /// Where the joints are measured, before any row.
  [[nodiscard]] const Branch& measured() const { return measured_; }
  /// Branches that a row which acts already has taken on from there, before the first row.
  [[nodiscard]] std::size_t start_count() const { return start_count_; }
  /// Before the first row: whether any joint that the chunk commands, or that is commanded a
  /// motion, moves in a branch.
  [[nodiscard]] bool is_coasting(const Branch& branch) const;
  /// Takes it to where it is a tick later if nothing changes its motion.
  void coast_one_tick(Branch& branch) const;
  [[nodiscard]] const Interval& interval() const { return interval_; }
  /// How far each joint may be from where the branches start or go on from, either way: it held in
  /// the tick that runs, and was measured to move when that began.
  [[nodiscard]] const Joints& start_off() const { return start_off_; }
  [[nodiscard]] bool is_start_off() const { return is_start_off_; }
  /// How far the base may be turned from there, also while it comes to rest [rad]: what it is told
  /// along its own axes leads aside by that.
  [[nodiscard]] double turn_off() const;
  /// Before the first row: the targets of the row that was measured last; null where it had
  /// none.
  [[nodiscard]] std::optional<Joints> last_targets() const;
  /// Whether there are several rows of each of which another share may happen. Then branch 1 has
  /// the lower ends of all gains, the last of `share_count` the upper ones.
  [[nodiscard]] bool shares_can_differ() const { return rows_shared_ > 1; }
  /// Raises `off`, by joint, to how far other shares can leave it from its branches, and where they
  /// come to rest: `lower` and `upper`, where it does for these two branches.
  void raise_off(const Joints& lower, const Joints& upper, Joints& off) const;
  /// Whether other shares can make a joint faster or slower in the newest row than its branches.
  [[nodiscard]] bool speeds_can_differ() const { return speeds_differ_; }
  /// A branch whose joints are each as fast as any shares can make them, or as slow; where it is,
  /// does not count.
  [[nodiscard]] Branch with_speeds(bool highest) const;
  /// Where the newest row begins: how far two shares of the rows before may have left a joint of a
  /// part from each other at most [rad]. What slides counts as the turn that takes the arm as far;
  /// where nothing turns, the tool's Jacobian is the same everywhere.
  [[nodiscard]] double interval_width(std::size_t part) const;

 private:
  struct Command {
    const ActionPart& action;
    const ModeLimits& modes;
    Setpoint row;
  };
  /// What a share of what is asked of a tool makes of its joints. row: its motion, along the root's
  /// axes [m, rad]; asked: with what is left of the rows before it.
  struct ToolWay {
    Motion6 row;
    Motion6 asked;
    double share;
    Joints after;
    Joints first_step;
  };

  void start_still(const PartMemories* memories);
  void note_left(const PartMemories* memories);
  void note_new_goals(const RowBefore& before);
  void include(const ActionChunk& chunk, JointSet& joints);
  void include_companions();
  void add_branches(std::size_t part);
  void include_holding();
  [[nodiscard]] double gain(const Command& command, std::size_t branch) const;
  void note_spread();
  void note_shares(double turn_before);
  void note_speeds();
  [[nodiscard]] Evidence check_speeds() const;
  [[nodiscard]] double turn_width() const;
  void note_base_speed();
  void note_targets(const ActionChunk& chunk, std::size_t row);
  void note_pose(const ActionPart& action, std::size_t row);
  /// The branches that there are.
  [[nodiscard]] std::span<Branch> branches() { return std::span(branches_).first(branch_count_); }
  [[nodiscard]] std::span<const Branch> branches() const {
    return std::span(branches_).first(branch_count_);
  }
  Evidence apply_rows(const RowBefore& own, bool before);
  Evidence apply_row(const ActionChunk& chunk, std::size_t row, bool own, bool poses,
                     std::size_t branch_count);
  Evidence apply(const Command& command, std::size_t branch);
  void apply_targets(const Command& command, Branch& branch);
  void apply_velocities(const Command& command, std::size_t index);
  Evidence apply_tool_motion(const Command& command, std::size_t index);
  Evidence find_way(const Command& command, std::size_t index, ToolWay& way);
  Evidence note_other_ways(const Command& command);
  [[nodiscard]] Evidence find_other_way(const Command& command, const Branch& branch,
                                        const ToolWay& way, const Joints& shift, Joints& less,
                                        Joints& more) const;
  void widen_by_other_ways();
  Evidence apply_pose(const Command& command, Branch& branch);
  Evidence solve_pose(const Command& command, Branch& branch, Joints& first_step) const;
  [[nodiscard]] Evidence check_speed(const Branch& branch, std::size_t part,
                                     const Joints& first_step, double of_most) const;
  [[nodiscard]] bool is_switched_up(const ActionChunk& chunk, std::size_t row) const;
  [[nodiscard]] bool goals_add_up(const RowBefore& own, bool before) const;
  void apply_body_twist(const Command& command, std::size_t index);
  void note_speed(Branch& branch, std::size_t joint, double change, double of_most = 1.0) const;
  [[nodiscard]] bool reaches_goal(std::size_t joint) const;
  [[nodiscard]] std::pair<double, double> speeds_off(std::size_t joint, double of_most) const;
  [[nodiscard]] double goal_off(std::size_t joint) const;
  [[nodiscard]] double creep(std::size_t joint) const;
  [[nodiscard]] JointSet commanded_in(std::size_t step) const;
  [[nodiscard]] JointSet held_in(const RowBefore& before) const;
  [[nodiscard]] double held_off(std::size_t joint) const;
  void widen_start();
  void settle_uncommanded();
  [[nodiscard]] double came_from(const Branch& branch, std::size_t joint) const;
  [[nodiscard]] Evidence check_finite() const;

  const RobotModel& model_;
  const ClaimLimits& claim_;
  const MeasuredState& state_;
  const ActionChunk& chunk_;
  Companions companions_;
  std::size_t next_row_;
  std::size_t row_ = 0;
  std::size_t steps_ = 0;  // rows gone through since the first live one, the one gone to included
  bool goals_add_up_ = false;  // in the newest row
  std::size_t branch_count_ = 1;
  // Of them have each another share; the rest is these while all others hold.
  std::size_t share_count_ = 1;
  std::size_t start_count_ = 0;
  std::size_t holding_count_ = 0;  // the last of them: nothing moves but what the chunk commands
  FixedVec<std::size_t, max_parts> gain_parts_;  // with a gain, that move links: a bit for each
  std::array<std::uint8_t, max_parts> gain_bit_{};
  JointSet commanded_ = 0;
  JointSet moving_ = 0;
  JointSet lagging_ = 0;
  JointSet guessed_ = 0;
  JointSet redundant_ = 0;           // of arms with more than six joints that reach for a pose
  JointSet coasting_ = 0;            // measured to move, and nothing that the chunk commands
  JointSet perhaps_still_ = 0;       // only positions say that it moves
  JointSet held_ = 0;                // in the tick that runs; rows command them from the next on
  JointSet has_earlier_target_ = 0;  // joints: in the row before the first, a pose included
  std::array<double, max_joints> earlier_targets_;
  Interval interval_;
  Interval interval_before_;  // of the row before
  std::size_t rows_shared_ = 0;
  std::array<UnequalShares, max_parts> unequal_shares_;  // by part
  std::array<SharedBy, max_parts> shared_by_{};          // by part, in the newest row
  Interval speeds_;  // of the joints in the newest row, while shares can differ
  bool speeds_differ_ = false;
  double turned_off_ = 0.0;  // of the base's slides, by what shares may have turned it before [m]
  bool forecast_only_ = false;
  double base_speed_ = 0.0;
  double base_speed_before_ = 0.0;
  bool is_start_off_ = false;
  Joints start_off_{};
  // Of tools' joints in the newest row, whose way depends on where they start.
  Joints way_less_{};
  Joints way_more_{};
  Branch measured_;
  std::array<Branch, max_branches> branches_;
};

}  // namespace fairlead
