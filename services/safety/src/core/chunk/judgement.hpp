// The decision itself: pure functions of (limits, measured state, chunk, what acted before).
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/release/part_history.hpp"
#include "core/wire/phrase.hpp"
#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

struct RobotModel;

/// Why something was not released: the stable code, the place, and the numbers.
/// Its texts point into the limits or at literals: it is used up within the step that made it.
struct Evidence {
  std::uint32_t code = 0;  // 1..50 for G001..G050, 0: nothing to report
  std::int64_t row = -1;   // row of the chunk, -1 if none
  std::string_view part;
  std::string_view axis;
  double value = 0.0;
  double limit = 0.0;
  double margin = 0.0;    // limit minus value, at a lower limit value minus limit: negative outside
  std::string_view unit;  // of value and limit, "1" of a plain number; "" of a rule
  std::string_view key;   // what a stop says of the limit: its key in robot.yaml, or a few words
  std::string_view limit_source;
  bool raises_stop = false;

  [[nodiscard]] bool ok() const { return code == 0; }
  /// Else it is a rule that `limit_source` words, and its numbers mean nothing to a person.
  [[nodiscard]] bool has_magnitude() const { return !unit.empty(); }
};

/// The newest measured state, copied out of its frame. SI, commanded joints then passive ones.
struct MeasuredState {
  std::uint64_t tick = 0;
  std::size_t count = 0;
  std::array<double, max_measured> positions{};
  std::array<double, max_measured> velocities{};
  std::array<double, max_measured> efforts{};
  // How fast the last tick was by the positions, with its sign (see travel_speed); 0 in the first
  // state of an episode.
  std::array<double, max_measured> travel_speeds{};
  FixedVec<Acted, max_parts> acted;  // what each part did in tick - 1
};

/// The row that acts in the tick before the chunk's first live row; empty after a hold.
struct RowBefore {
  const ActionChunk* chunk = nullptr;  // nullptr: the parts hold in that tick
  std::size_t row = 0;
  bool measured = true;  // the newest state was measured after it acted (lockstep)
  const PartMemories* memories = nullptr;  // by part; nullptr: nothing moved before
};

/// What another claim has released for the same ticks: its parts move too.
struct Companion {
  RowBefore before;                    // its row in the tick before `row`, as for the claim itself
  const ActionChunk* chunk = nullptr;  // nullptr: no released row left
  std::size_t row = 0;                 // acts in the tick of the judged chunk's first row
  std::size_t end_row = 0;             // its parts hold from this row on
};
using Companions = std::span<const Companion>;

/// Of configurations that one judgement looks at, or one step of all claims together. Good
/// demonstrations take up to 133; chunks made to bring two arms together need more.
inline constexpr std::size_t max_queries = 512;

/// Which rows of a chunk are judged. Those before `certified_end` can act before the gate judges
/// anew: whatever shares of them happen, they keep to the limits, and so does the stop behind each.
/// Those after it are forecast, by the middle of each gain: they are certified before they act.
struct JudgedRows {
  std::size_t first = 0;
  std::size_t end = 0;
  std::size_t certified_end = 0;
  std::size_t queries = max_queries;

  /// All of them are certified.
  static JudgedRows all(std::size_t first, std::size_t end, std::size_t queries = max_queries) {
    return {first, end, end, queries};
  }
};

struct Judgement {
  Outcome outcome = Outcome::refused;
  std::size_t first_row = 0;       // first live row of the chunk
  std::size_t row_count = 0;       // rows released, 0 if refused
  std::size_t configurations = 0;  // configurations that G031, G032 and G034 looked at
  Evidence evidence;               // why the rest was not
};

/// What one claim may do: its parts and its own, never looser, limits.
struct ClaimLimits {
  FixedVec<std::size_t, max_parts> parts;  // indices into Limits::parts
  std::array<ModeLimits, max_parts> modes;
  std::uint32_t horizon_max = 0;
  std::uint32_t age_max_ticks = 0;
};

/// G007, G008, G009: does the chunk have the shape it says, finite numbers, and only commands
/// that its parts know? Judges every row, past ones too.
Evidence check_shape(const Limits& limits, const ClaimLimits& claim, const ActionChunk& chunk);

/// G011 of a released row that is about to act: may it still, in this state?
Evidence check_running(const RobotModel& model, const ClaimLimits& claim,
                       const MeasuredState& state, const ActionChunk& chunk, std::size_t row);

/// The stable codes; their meaning is written where each is checked.
namespace code {
inline constexpr std::uint32_t frame = 1, session = 2, epoch = 3, claim = 4, sequence = 5, age = 6,
                               shape = 7, finite = 8, addressing = 9, rate = 10, state = 11,
                               past = 12, jump = 13, absolute = 20, start = 21, step = 22,
                               seam = 23, braking = 24, change = 25, speed = 26, unreachable = 30,
                               workspace = 31, collision = 32, singularity = 33, zone = 34,
                               tracking = 40, stuck = 41, contact = 42, ramp = 43, own = 50;
/// Each of them, in the order in which the status counts them.
inline constexpr std::array all{frame,  session,  epoch,       claim,     sequence,  age,
                                shape,  finite,   addressing,  rate,      state,     past,
                                jump,   absolute, start,       step,      seam,      braking,
                                change, speed,    unreachable, workspace, collision, singularity,
                                zone,   tracking, stuck,       contact,   ramp,      own};
}  // namespace code

/// As people write it: G007, G040.
inline Text code_name(std::uint32_t code) {
  return phrase("G", code < 10 ? "00" : "0", code);  // GCOVR_EXCL_BR_LINE: nothing here throws
}

/// `value` is above `limit`, or not a number, both in `unit`.
inline Evidence above(std::uint32_t code, std::string_view axis, double value, double limit,
                      std::string_view unit, std::string_view source) {
  Evidence evidence;
  evidence.code = code;
  evidence.axis = axis;
  evidence.value = value;
  evidence.limit = limit;
  evidence.margin = limit - value;
  evidence.unit = unit;
  evidence.limit_source = source;
  return evidence;
}

/// `value` is below `limit`, or not a number, both in `unit`.
inline Evidence below(std::uint32_t code, std::string_view axis, double value, double limit,
                      std::string_view unit, std::string_view source) {
  Evidence evidence = above(code, axis, value, limit, unit, source);
  evidence.margin = value - limit;
  return evidence;
}

/// What a rule asks for, in words that follow "needs". A literal that is too long for a line that
/// a person reads does not compile.
struct Rule {
  static constexpr std::size_t longest = 60;
  template <std::convertible_to<std::string_view> Literal>
  consteval Rule(const Literal& literal) : words(literal) {  // NOLINT: a literal is a rule
    if (words.size() > longest) throw "too long a rule";
  }
  /// Of words that are made as the gate runs.
  static Rule made_of(const Text& text) { return Rule(text); }

  std::string_view words;

 private:
  explicit Rule(const Text& text) : words(text.view()) {}
};

/// How many configurations a judgement may query, and has: this bounds the time that it takes.
class QueryBudget {
 public:
  explicit QueryBudget(std::size_t most = max_queries) : most_(most) {}

  /// G030 where none is left.
  Evidence take() {
    if (taken_ == most_)
      return above(code::unreachable, "queries", static_cast<double>(taken_),
                   static_cast<double>(most_), "1", "configurations that one judgement queries");
    ++taken_;
    return {};
  }
  [[nodiscard]] std::size_t taken() const { return taken_; }

 private:
  std::size_t most_;
  std::size_t taken_ = 0;
};

/// A rule that has no magnitude, and so no margin: what was found and what was expected.
inline Evidence broken_rule(std::uint32_t code, std::string_view axis, Rule rule,
                            double found = 0.0, double expected = 0.0) {
  Evidence evidence = above(code, axis, found, expected, "", rule.words);
  evidence.margin = 0.0;
  return evidence;
}

/// What a stop says of the limit: where robot.yaml has it, or a few words.
inline Evidence declared_as(Evidence evidence, std::string_view key) {
  evidence.key = key;
  return evidence;
}

/// Of a joint, by its kind.
inline std::string_view position_unit(JointKind kind) {
  return kind == JointKind::prismatic ? "m" : "rad";
}
inline std::string_view velocity_unit(JointKind kind) {
  return kind == JointKind::prismatic ? "m/s" : "rad/s";
}
inline std::string_view effort_unit(JointKind kind) {
  return kind == JointKind::prismatic ? "N" : "N m";
}

/// Evidence about a part; the row it came from is unchanged.
inline Evidence of(Evidence evidence, const Name& part) {
  evidence.part = part.view();
  return evidence;
}

inline Evidence at(Evidence evidence, std::int64_t row, const Name& part) {
  evidence.row = row;
  return of(evidence, part);
}

/// What was found, in words: the one text of stops, of the log, and of refusals in it.
/// `G020 arm linear, row 5: 0.09 m, limit 0.0867 m`, with the key of the limit in brackets where it
/// is known; of a rule `G003 epoch: needs the current arm epoch`. Where a limit comes from may be a
/// page of text: `fairlead why` has it.
inline Text words_of(const Evidence& evidence) {
  Text text = code_name(evidence.code);
  for (const std::string_view word : {evidence.part, evidence.axis})
    if (!word.empty()) text = phrase(text, " ", word);
  if (evidence.row >= 0) text = phrase(text, ", row ", evidence.row);
  if (!evidence.has_magnitude())
    return evidence.limit_source.empty() ? text : phrase(text, ": needs ", evidence.limit_source);
  const Text unit = evidence.unit == "1" ? Text() : phrase(" ", evidence.unit);
  text = phrase(text, ": ", Beside{evidence.value, evidence.limit}, unit, ", limit ",
                Beside{evidence.limit, evidence.value}, unit);
  return evidence.key.empty() ? text : phrase(text, " (", evidence.key, ")");
}

}  // namespace fairlead
