// Chunks of a policy that wants the gate to be busy: what they are made of, and how to vary them.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "core/chunk/judge_chunk.hpp"
#include "core/kinematics/forward_kinematics.hpp"

namespace fairlead::bench {

/// Numbers from 0 to 1, the same in every run that draws as many.
class Lots {
 public:
  double one() { return static_cast<double>(engine_() >> 11U) * 0x1.0p-53; }
  double either_way() { return 2.0 * one() - 1.0; }
  std::size_t below(std::size_t end) { return engine_() % end; }

 private:
  std::mt19937_64 engine_{1};
};

/// What one part is told: to and fro, turning round after `turn_after` rows.
struct AttackPart {
  std::uint8_t mode = 0;
  double share = 0.0;         // of its limits
  std::vector<double> along;  // by joint or axis, -1 to 1
  std::uint32_t turn_after = 1;
};

/// Where the robot stands, what it is told there, and how far it goes until the next state.
struct Attack {
  Joints at{};
  std::vector<double> drift;  // by joint, share of what it may be seen to go in a tick
  std::vector<AttackPart> parts;
};

/// The numbers and parts of a chunk, each part's numbers behind it.
struct AttackRows {
  std::vector<std::vector<double>> numbers;
  std::vector<ActionPart> actions;
};

Attack any_attack(const Limits& limits, Lots& lots);
/// With one to four things changed, by little or by much.
Attack varied(const Attack& attack, const Limits& limits, Lots& lots);
/// Within G020 and G022, as far as those do not depend on the path.
AttackRows rows_of(const Attack& attack, const RobotModel& model, std::uint32_t rows);

}  // namespace fairlead::bench
