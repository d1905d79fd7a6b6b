// One chunk's rows on their way: what is predicted so far.
#pragma once

#include "../evidence.hpp"
#include "fairlead_safety/path.hpp"

namespace fairlead {

/// Asked row by row, in order, from the first live one on.
class PathWalk {
 public:
  PathWalk(const PathPlan& plan, const ClaimLimits& claim, const MeasuredState& state,
           const ActionChunk& chunk, std::size_t first_row, const RowBefore& before,
           Companions companions);

  /// Moves on by one row and judges where that leads.
  Evidence check_next();
};

}  // namespace fairlead
