// The robot and the chunks that the short cases judge: a shipped robot's links and capsules, with
// all of its commanded joints in one part.
#pragma once

#include <cstdint>
#include <vector>

#include "core/chunk/judgement.hpp"

namespace fairlead::bench {

/// `shipped` with one part that has every commanded joint, in joint_position, and at most `pairs`
/// pairs of capsules. Every joint is bounded and can brake, and it starts half-way between its
/// bounds.
Limits one_part_of(const Limits& shipped, std::size_t pairs);

/// That part's claim.
ClaimLimits claim_of(const Limits& limits);

/// Every joint half-way between its bounds, 0 without any, standing still.
MeasuredState middle_of(const Limits& limits);

/// A chunk of joint targets that owns its numbers: every joint goes on by half a step a row, there
/// and back, so that no row is refused.
class JointChunk {
 public:
  JointChunk(const Limits& limits, const MeasuredState& state, std::uint32_t horizon);
  [[nodiscard]] const ActionChunk& chunk() const { return chunk_; }
  [[nodiscard]] const std::vector<double>& numbers() const { return numbers_; }

 private:
  std::vector<double> numbers_;
  ActionChunk chunk_;
};

/// Rows for one part, in a mode that it has, row by row. If `moving`, two that ask it to stay, then
/// deltas and velocities to and fro, by 0.15 to 0.3 of their limits; else all ask it to stay.
/// Joint targets, openings and the composite switch stay as they are.
std::vector<double> rows_for(const Limits& limits, const MeasuredState& state, std::size_t part,
                             std::uint32_t rows, bool moving);

/// That part of a chunk; its numbers are the caller's.
ActionPart action_of(const Limits& limits, std::size_t part, const std::vector<double>& numbers);
/// The same in another mode than that of `rows_for`.
ActionPart action_of(const Limits& limits, std::size_t part, std::uint8_t mode,
                     const std::vector<double>& numbers);

}  // namespace fairlead::bench
