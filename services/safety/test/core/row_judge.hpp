// Judging single chunks of the test robot.
#pragma once

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "core/chunk/judgement.hpp"

namespace fairlead::test {

inline Judgement judge(const ActionChunk& chunk, const MeasuredState& state = state_at_rest(),
                       const RowBefore& before = {}, std::size_t first_row = 0) {
  static const Limits limits = test_limits();
  static const ClaimLimits claim = whole_robot(limits);
  return judge_rows(limits, claim, state, chunk, first_row, before);
}

// A single row that follows `previous`, so that only its own limits can refuse it.
inline std::uint32_t code_after(ChunkBuilder& previous, const ChunkBuilder& next,
                                const MeasuredState& state = state_at_rest()) {
  return judge(next.chunk, state, RowBefore{&previous.chunk, 0}).evidence.code;
}

}  // namespace fairlead::test
