// The judgement alone, and the yardstick it is compared with.
#pragma once

#include <string>
#include <vector>

#include "bench_robot.hpp"
#include "core/chunk/judge_chunk.hpp"
#include "stopwatch.hpp"

namespace fairlead::bench {

/// The yardstick: copies the numbers of a chunk and compares each with two bounds and with the
/// number a row before. What nobody who reads every number can do without.
class CopyAndCompare final : public Case {
 public:
  CopyAndCompare(std::string name, const Limits& limits, std::uint32_t horizon);
  void run(std::size_t calls) override;

 private:
  JointChunk chunk_;
  std::vector<double> copy_;
  std::vector<double> lower_, upper_, step_;  // as long as the chunk's numbers
};

/// Every row of a chunk of joint targets against its limits (G011, G020, G021, G022); all pass.
class LimitRows final : public Case {
 public:
  LimitRows(std::string name, const Limits& limits, std::uint32_t horizon);
  void run(std::size_t calls) override;

 private:
  [[nodiscard]] std::size_t rows_in_order() const;

  RobotModel model_;
  ClaimLimits claim_;
  MeasuredState state_;
  JointChunk chunk_;
  RowBefore nothing_before_;
};

/// Every check of every row of such a chunk: limits, then prediction, forward kinematics, braking,
/// volumes and pairs of capsules.
class WholeRows final : public Case {
 public:
  WholeRows(std::string name, const Limits& limits, std::uint32_t horizon);
  void run(std::size_t calls) override;

 private:
  [[nodiscard]] JudgedRows all_rows() const;

  RobotModel model_;
  PathRoom room_;
  ClaimLimits claim_;
  MeasuredState state_;
  JointChunk chunk_;
};

}  // namespace fairlead::bench
