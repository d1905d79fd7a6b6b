// Making the evidence of a refusal: which code, where, and the numbers that decided.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/chunk/judgement.hpp"
#include "core/wire/phrase.hpp"

namespace fairlead {

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

/// `value` is above `limit`, or not a number.
inline Evidence above(std::uint32_t code, std::string_view axis, double value, double limit,
                      std::string_view source) {
  Evidence evidence;
  evidence.code = code;
  evidence.axis = axis;
  evidence.value = value;
  evidence.limit = limit;
  evidence.margin = limit - value;
  evidence.limit_source = source;
  return evidence;
}

/// `value` is below `limit`, or not a number.
inline Evidence below(std::uint32_t code, std::string_view axis, double value, double limit,
                      std::string_view source) {
  Evidence evidence = above(code, axis, value, limit, source);
  evidence.margin = value - limit;
  return evidence;
}

/// A rule that has no magnitude: what was found and what was expected.
inline Evidence broken_rule(std::uint32_t code, std::string_view axis, std::string_view rule,
                            double found = 0.0, double expected = 0.0) {
  Evidence evidence = above(code, axis, found, expected, rule);
  evidence.margin = 0.0;
  return evidence;
}

/// What the numbers are, and under which key of robot.yaml the limit is declared.
inline Evidence in(Evidence evidence, std::string_view unit, std::string_view key = {}) {
  evidence.unit = unit;
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
  evidence.part = part.view();
  return evidence;
}

}  // namespace fairlead
