// A prediction of a robot's own.
#pragma once

#include <doctest/doctest.h>

#include "chunk_builder.hpp"
#include "core/trajectory/prediction.hpp"

namespace fairlead::test {

/// Of lengths, angles and speeds of hundredths: to 1 % of them, where Approx alone is off by 0.01.
inline doctest::Approx about(double value) {
  return doctest::Approx(value).epsilon(0.01).scale(0.01);
}

/// What a prediction needs, kept for as long as it lasts.
struct Predicted {
  Predicted(const Limits& robot, const MeasuredState& measured, const ActionChunk& rows,
            const RowBefore& before = {}, Companions companions = {})
      : limits(robot),
        state(measured),
        chunk(rows),
        all(model, claim, state, chunk, 0, before, companions) {}
  Limits limits;
  RobotModel model{limits};
  ClaimLimits claim = whole_robot(limits);
  MeasuredState state;
  ActionChunk chunk;
  Prediction all;

  const Branch& after_a_row() {
    CHECK(all.advance().ok());
    return all.branch(0);
  }
};

}  // namespace fairlead::test
