#include "process/self_test.hpp"

#include <memory>
#include <string>
#include <vector>

#include "core/chunk/judge_chunk.hpp"
#include "core/chunk/judgement.hpp"
#include "fairlead_safety/crc32.hpp"
#include "fairlead_safety/limits.hpp"
#include "process/refusal.hpp"

namespace fairlead {
namespace {

constexpr double huge = 999'999.0;  // G008 lets it pass; no limit of a robot does

double middle(double lower, double upper) { return 0.5 * (lower + upper); }

// Every joint half-way between its bounds, 0 without any, standing still.
MeasuredState rest_of(const Limits& limits) {
  MeasuredState state;
  state.count = limits.measured_count();
  for (std::size_t j = 0; j < limits.joints.size(); ++j) {
    const JointLimits& joint = limits.joints[j];
    if (joint.bounded) state.positions[j] = middle(joint.bounds.lower, joint.bounds.upper);
  }
  for (std::size_t i = 0; i < limits.passive_joints.size(); ++i) {
    const Bounds& bounds = limits.passive_joints[i].bounds;
    state.positions[limits.joints.size() + i] = middle(bounds.lower, bounds.upper);
  }
  (void)state.acted.resize(limits.parts.size());
  return state;
}

ClaimLimits claim_of_all(const Limits& limits) {
  ClaimLimits claim;
  for (std::size_t i = 0; i < limits.parts.size(); ++i) {
    (void)claim.parts.push_back(i);
    claim.modes[i] = limits.parts[i].modes;
  }
  claim.horizon_max = limits.protocol.horizon_max;
  return claim;
}

// One part in one mode: a row that rests, and what is wrong when one of its numbers changes.
class Questions {
 public:
  Questions(const RobotModel& model, const ClaimLimits& claim, PathRoom& room, std::size_t part,
            Mode mode)
      : model_(model), claim_(claim), room_(room), part_(model.limits.parts[part]), mode_(mode) {
    action_.part = static_cast<std::uint8_t>(part);
    action_.mode = static_cast<std::uint8_t>(mode);
    if (is_joint_mode(action_.mode))
      for (const std::size_t j : part_.joints)
        (void)action_.active.push_back(static_cast<std::uint8_t>(j));
    const auto* frames = frames_of(part_.modes, action_.mode);
    if (frames != nullptr) action_.frame_id = (*frames)[0];
    row_.resize(mode_width(action_.mode, model.limits.joints.size()));
    for (const std::uint8_t j : action_.active)
      if (is_target(mode)) row_[j] = rest_.positions[j];
    if (mode != Mode::cartesian_pose) return;
    const PoseLimits& pose = part_.modes.cartesian_pose;
    for (std::size_t i = 0; i < 3; ++i) row_[i] = middle(pose.lower[i], pose.upper[i]);
    row_[6] = 1.0;
  }

  std::size_t ask_all() {
    ask("a row of one number too many", std::vector<double>(row_.size() + 1), code::shape);
    for (std::size_t i = 0; i < row_.size(); ++i)
      if (!is_joint_mode(action_.mode) || action_.active.contains(static_cast<std::uint8_t>(i)))
        ask_about(i);
    return asked_;
  }

 private:
  void ask_about(std::size_t i) {
    const std::string place = ", number " + std::to_string(i);
    const CartesianLimits* norms = norm_block(part_.modes, action_.mode);
    std::uint32_t outside = code::absolute;
    if (norms != nullptr && !norms->free_axes[i]) outside = code::addressing;
    if (is_target(mode_) && !model_.limits.joints[i].bounded) outside = code::start;
    ask("NaN" + place, with(i, unset), code::finite);
    ask("999999" + place, with(i, huge), outside);
    ask("-999999" + place, with(i, -huge), outside);
    if (mode_ == Mode::joint_velocity) rest_.velocities[i] = huge;
    if (mode_ == Mode::joint_velocity) ask("0 where 999999 is measured" + place, row_, code::start);
    rest_.velocities[i] = 0.0;
  }

  void ask(const std::string& what, const std::vector<double>& row, std::uint32_t expected) {
    action_.values = NumberView(
        Bytes(reinterpret_cast<const std::uint8_t*>(row.data()), row.size() * sizeof(double)));
    ActionChunk chunk;
    chunk.horizon = 1;
    (void)chunk.parts.push_back(action_);
    Judgement found;
    found.evidence = check_shape(model_.limits, claim_, chunk);
    if (found.evidence.ok())
      found =
          judge_rows(room_, model_, claim_, rest_, chunk, JudgedRows::all(0, 1), RowBefore{}, {});
    ++asked_;
    std::string got(code_name(found.evidence.code).view());
    if (found.outcome != Outcome::refused) got = "a release";
    if (found.evidence.code == code::finite && !found.evidence.raises_stop)
      got += " without a stop";
    const std::string known(code_name(expected).view());
    if (got != known)
      throw StartFailed("self-test: part " + std::string(part_.name.view()) + ", mode " +
                        std::string(mode_name(action_.mode)) + ": " + what + ": expected " + known +
                        ", got " + got);
  }

  [[nodiscard]] std::vector<double> with(std::size_t i, double value) const {
    std::vector<double> row = row_;
    row[i] = value;
    return row;
  }

  const RobotModel& model_;
  const ClaimLimits& claim_;
  PathRoom& room_;
  const PartLimits& part_;
  Mode mode_;
  MeasuredState rest_ = rest_of(model_.limits);
  ActionPart action_;
  std::vector<double> row_;
  std::size_t asked_ = 0;
};

// The check of memory (G050): the sum of a text that everybody knows, and of one bit turned over.
std::size_t ask_sum(const Limits& limits) {
  const auto sum = [](const auto& bytes) { return crc32(Bytes(bytes.data(), bytes.size())); };
  const std::array<std::uint8_t, 9> digits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  if (sum(digits) != 0xCBF43926U) throw StartFailed("self-test: CRC-32 of 123456789 is wrong");
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&limits);
  std::vector<std::uint8_t> copy(bytes, bytes + sizeof limits);
  const std::uint32_t once = crc32(Bytes(bytes, sizeof limits));
  if (sum(copy) != once) throw StartFailed("self-test: two CRC-32 of the limits differ");
  copy[copy.size() / 2] ^= 1U;
  if (sum(copy) == once) throw StartFailed("self-test: CRC-32 of the limits misses a turned bit");
  return 3;
}

}  // namespace

std::size_t self_test(const Limits& limits) {
  const auto model = std::make_unique<RobotModel>(limits);
  const auto claim = std::make_unique<ClaimLimits>(claim_of_all(limits));
  const auto room = std::make_unique<PathRoom>();
  std::size_t asked = ask_sum(limits);
  for (std::size_t part = 0; part < limits.parts.size(); ++part)
    for (std::uint8_t mode = 0; mode < mode_count; ++mode)
      if (limits.parts[part].modes.supports(mode))
        asked += Questions(*model, *claim, *room, part, Mode{mode}).ask_all();
  return asked;
}

}  // namespace fairlead
