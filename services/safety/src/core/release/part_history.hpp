// What each part did: the rows that acted, in which mode it still moves, for as long as that motion
// may last (G025), and where its tool was to go (G026).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "core/kinematics/pose.hpp"
#include "core/kinematics/robot_model.hpp"
#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

class ClaimTable;
struct LiveClaim;
struct MeasuredState;
struct Setpoint;

/// Which way a composite row switches: below 0 or not. unknown: a row that nobody remembers.
enum class Switch : std::uint8_t { none, negative, positive, unknown };

inline Switch switch_of(double value) { return value < 0.0 ? Switch::negative : Switch::positive; }

/// In which mode and frame rows move a part. none: in none. unknown: in more than one, or in one
/// that nobody remembers.
struct MovingMode {
  enum class Kind : std::uint8_t { none, known, unknown };
  Kind kind = Kind::none;
  std::uint8_t mode = 0;
  Name frame_id;

  /// A row of this command may move the part.
  void note(const ActionPart& action) {
    kind = Kind::known;
    mode = action.mode;
    frame_id = action.frame_id;
  }
  /// A row of this command may still act.
  void add(const ActionPart& action) { add(MovingMode{Kind::known, action.mode, action.frame_id}); }
  /// Combined with what else may move it.
  void add(const MovingMode& other) {
    if (kind == Kind::none)
      *this = other;
    else if (other.kind == Kind::unknown || mode != other.mode || !(frame_id == other.frame_id))
      kind = Kind::unknown;
  }
  /// Whether a command is of another mode or frame than what may still move the part.
  [[nodiscard]] bool differs(const ActionPart& action) const {
    if (kind == Kind::none) return false;
    return kind == Kind::unknown || mode != action.mode || !(frame_id == action.frame_id);
  }
  static std::uint16_t mode_bit(std::uint8_t mode) {
    return static_cast<std::uint16_t>(1U << mode);
  }
};

/// Rows of a part that were released and may still act: in ticks of which the state is lost,
/// nobody says whether they did.
struct ReleasedRows {
  MovingMode moving;
  std::uint16_t modes = 0;       // a bit for each
  std::uint64_t first_tick = 0;  // of the newest
  std::uint64_t end_tick = 0;    // after the last

  void add(const ActionPart& action, std::uint64_t first, std::uint64_t end) {
    moving.add(action);
    modes = static_cast<std::uint16_t>(modes | MovingMode::mode_bit(action.mode));
    first_tick = first;
    end_tick = std::max(end_tick, end);
  }
  /// One acted: nothing else can go on from it.
  void act(const ActionPart& action) {
    moving.note(action);
    modes = MovingMode::mode_bit(action.mode);
  }
  /// The part held in a tick, which discards all that could have acted in it.
  void hold(std::uint64_t tick) {
    if (first_tick <= tick) *this = ReleasedRows{};
  }
};

/// `kind` none: it stood still after a tick in which no row moved it. unknown: it moves, or a row
/// acted that nobody remembers.
struct PartMemory : MovingMode {
  // The last row that acted since arming, also after standstill: bit m is set if it may have been
  // of mode m, none if no row has acted.
  std::uint16_t acted_modes = 0;
  Switch composite = Switch::none;  // of that row, if it was one of composite_mode
  ReleasedRows released;
  // Where the controller was last commanded to bring the part's tool, in the root link's frame;
  // nothing where nobody knows: a state was lost, or a row acted that nobody remembers.
  std::optional<Pose> goal;

  /// The part stood still after a tick in which no row moved it.
  void rest() { kind = Kind::none; }
  /// A row acted of a claim that has ended: `add` has noted its mode, unless there were two.
  void note_forgotten(std::uint16_t all_modes) {
    if (kind == Kind::none) kind = Kind::unknown;
    acted_modes = kind == Kind::known ? mode_bit(mode) : all_modes;
    composite = Switch::unknown;
  }
  /// Rows that were released may have acted in ticks of which no state told.
  void note_unseen() {
    add(released.moving);
    acted_modes = static_cast<std::uint16_t>(acted_modes | released.modes);
    if ((released.modes & mode_bit(static_cast<std::uint8_t>(Mode::composite_mode))) != 0)
      composite = Switch::unknown;
  }
};

using PartMemories = std::array<PartMemory, max_parts>;

class PartHistory {
 public:
  /// `model` must outlive the history.
  explicit PartHistory(const RobotModel& model) : model_(model), limits_(model.limits) {}

  /// Arming in `state`: nothing is known of what happened before.
  void begin(const MeasuredState& state);
  /// A new session executes nothing that was released to another.
  void begin_session();
  /// A state of a later tick comes: the newest so far was of this one, 0 if there was none.
  void end_tick(std::uint64_t tick) { seen_tick_ = tick; }
  /// By what each part did in the tick before `now`, which began at `before`.
  void update(const MeasuredState& before, const MeasuredState& now, const ClaimTable& claims);
  /// Also while disarmed: what a part could have done before it held says nothing of later ticks.
  void forget_held(const MeasuredState& now);

  /// The newest release of a claim has gone out.
  void note_released(const LiveClaim& claim);
  /// A claim ends. The HAL may still execute a row of it.
  void keep(const LiveClaim& claim);

  /// A state tells what acted in the tick before it. Of the ticks before that, which had a state
  /// each that was lost, it is only known what had been released. `tick`: of the newest state.
  [[nodiscard]] bool may_have_acted(std::size_t part, std::uint64_t tick) const {
    return tick - seen_tick_ > 1 && memories_[part].released.end_tick > seen_tick_;
  }
  [[nodiscard]] const PartMemories& memories() const { return memories_; }

 private:
  [[nodiscard]] Setpoint acted_row(std::size_t part, const MeasuredState& now,
                                   const ClaimTable& claims) const;
  [[nodiscard]] Switch switched(const MeasuredState& now, const ClaimTable& claims) const;
  [[nodiscard]] bool is_left_out(std::size_t part, const MeasuredState& now,
                                 const ClaimTable& claims) const;
  [[nodiscard]] Pose tool_of(std::size_t part, const MeasuredState& state) const;
  void note_goal(std::size_t part, const Setpoint& row, Switch switched,
                 const MeasuredState& before, const MeasuredState& now);

  const RobotModel& model_;
  const Limits& limits_;
  PartMemories memories_;
  std::uint64_t seen_tick_ = 0;  // of the state before the newest, 0: none
};

}  // namespace fairlead
