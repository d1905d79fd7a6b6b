#include "attack.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bench_robot.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead::bench {
namespace {

constexpr double just_within = 1.0 - 1e-9;
constexpr double radian = 0.1;  // a row, of joints whose tool is told poses
constexpr std::uint32_t latest_turn = 4;

using Row = std::vector<double>;

std::vector<std::uint8_t> modes_of(const PartLimits& part) {
  std::vector<std::uint8_t> modes;
  for (std::uint8_t mode = 0; mode < mode_count; ++mode)
    if (part.modes.supports(mode)) modes.push_back(mode);
  return modes;
}

// From a thousandth to all: what is near a limit by a hair takes longest.
double some_size(Lots& lots) { return std::pow(10.0, -3.5 * lots.one()); }

double within(const JointLimits& joint, double position) {
  return joint.bounded ? std::clamp(position, joint.bounds.lower, joint.bounds.upper) : position;
}

/// Rows of one part, each made from the one before.
class RowMaker {
 public:
  RowMaker(const Attack& attack, const RobotModel& model, std::size_t part)
      : attack_(attack),
        model_(model),
        part_(part),
        wish_(attack.parts[part]),
        limits_(model.limits.parts[part]),
        before_(mode_width(wish_.mode, model.limits.joints.size()), 0.0) {}

  Row next() {
    Row row(before_.size(), 0.0);
    if (const JointModeLimits* block = joint_block(limits_.modes, wish_.mode))
      is_target(static_cast<Mode>(wish_.mode)) ? tell_targets(*block, row)
                                               : tell_velocities(*block, row);
    else if (const CartesianLimits* norms = norm_block(limits_.modes, wish_.mode))
      tell_motion(*norms, row);
    else if (wish_.mode == static_cast<std::uint8_t>(Mode::cartesian_pose))
      tell_pose(row);
    else if (wish_.mode == static_cast<std::uint8_t>(Mode::gripper_position))
      row[0] = attack_.at[limits_.joints[0]];
    ++made_;
    return before_ = row;
  }

 private:
  [[nodiscard]] double share(std::size_t i) const { return wish_.share * wish_.along[i]; }
  [[nodiscard]] bool goes_back() const { return made_ / wish_.turn_after % 2 == 1; }
  // So many steps out; one more until it turns, then one less.
  [[nodiscard]] double steps_out() const {
    const std::uint32_t i = made_ % (2 * wish_.turn_after);
    return i < wish_.turn_after ? i + 1 : 2 * wish_.turn_after - 1 - i;
  }
  void tell_targets(const JointModeLimits& block, Row& row) const {
    for (const std::size_t j : limits_.joints)
      row[j] = within(model_.limits.joints[j],
                      attack_.at[j] + steps_out() * share(j) * just_within * block.step_limit[j]);
  }
  void tell_velocities(const JointModeLimits& block, Row& row) const {
    for (const std::size_t j : limits_.joints) {
      const double step = just_within * block.step_limit[j];
      const double speed = share(j) * just_within * model_.limits.joints[j].velocity_limit;
      row[j] = std::clamp(goes_back() ? -speed : speed, before_[j] - step, before_[j] + step);
    }
  }
  void tell_motion(const CartesianLimits& block, Row& row) const {
    tell_half(0, block.linear_limit, block.linear_step_limit, block, row);
    tell_half(3, block.angular_limit, block.angular_step_limit, block, row);
  }
  void tell_half(std::size_t first, double limit, double step_limit, const CartesianLimits& block,
                 Row& row) const {
    Eigen::Vector3d told, before;
    for (std::size_t i = 0; i < 3; ++i) {
      told[static_cast<Eigen::Index>(i)] = block.free_axes[first + i] ? share(first + i) : 0.0;
      before[static_cast<Eigen::Index>(i)] = before_[first + i];
    }
    told *= (goes_back() ? -limit : limit) * just_within / std::max(1.0, told.norm());
    const double step = (told - before).norm(), most = just_within * step_limit;
    if (step > most) told = before + (told - before) * (most / step);
    for (std::size_t i = 0; i < 3; ++i) row[first + i] = told[static_cast<Eigen::Index>(i)];
  }
  void tell_pose(Row& row) const {
    Joints joints = attack_.at;
    for (const std::size_t j : limits_.joints) joints[j] += radian * steps_out() * share(j);
    const std::size_t frame = model_.limits.kinematics.find(limits_.modes.cartesian_pose.frames[0]);
    const Pose told = link_pose(model_, {model_, joints}, frame, limits_.tool);
    const Eigen::Vector3d& place = told.position;
    const Eigen::Quaterniond turn(told.rotation);
    row = {place[0], place[1], place[2], turn.x(), turn.y(), turn.z(), turn.w()};
  }

  const Attack& attack_;
  const RobotModel& model_;
  const std::size_t part_;
  const AttackPart& wish_;
  const PartLimits& limits_;
  Row before_;
  std::uint32_t made_ = 0;
};

AttackPart any_part(const Limits& limits, const PartLimits& part, Lots& lots) {
  const std::vector<std::uint8_t> modes = modes_of(part);
  AttackPart wish;
  wish.mode = modes[lots.below(modes.size())];
  wish.share = lots.one();
  for (std::size_t i = 0; i < std::max<std::size_t>(6, limits.joints.size()); ++i)
    wish.along.push_back(lots.either_way());
  wish.turn_after = 1 + static_cast<std::uint32_t>(lots.below(latest_turn));
  return wish;
}

void vary_part(AttackPart& wish, const PartLimits& part, Lots& lots) {
  const std::vector<std::uint8_t> modes = modes_of(part);
  double& along = wish.along[lots.below(wish.along.size())];
  switch (lots.below(8)) {
    case 0:
      wish.mode = modes[lots.below(modes.size())];
      break;
    case 1:
    case 2:
      wish.share = std::min(1.0, wish.share * std::exp(0.5 * lots.either_way()));
      break;
    case 3:
      wish.turn_after = 1 + static_cast<std::uint32_t>(lots.below(latest_turn));
      break;
    default:
      along = std::clamp(along + lots.either_way() * some_size(lots), -1.0, 1.0);
  }
}

}  // namespace

Attack any_attack(const Limits& limits, Lots& lots) {
  Attack attack;
  attack.at = middle_of(limits).positions;
  for (std::size_t j = 0; j < limits.joints.size(); ++j) {
    const auto& [lower, upper] =
        std::pair(limits.joints[j].bounds.lower, limits.joints[j].bounds.upper);
    attack.at[j] = limits.joints[j].bounded ? lower + lots.one() * (upper - lower) : lots.one();
    attack.drift.push_back(0.0);
  }
  for (const PartLimits& part : limits.parts) attack.parts.push_back(any_part(limits, part, lots));
  return attack;
}

Attack varied(const Attack& attack, const Limits& limits, Lots& lots) {
  Attack next = attack;
  for (std::size_t left = 1 + lots.below(4); left > 0; --left) {
    const std::size_t j = lots.below(limits.joints.size());
    const std::size_t part = lots.below(limits.parts.size());
    const double size = some_size(lots);
    switch (lots.below(6)) {
      case 0:
      case 1:
        next.at[j] = within(limits.joints[j], next.at[j] + size * lots.either_way());
        break;
      case 2:
        for (std::size_t i = 0; i < limits.joints.size(); ++i)
          next.at[i] = within(limits.joints[i], next.at[i] + size * lots.either_way());
        break;
      case 3:
        next.drift[j] = size * lots.either_way();
        break;
      default:
        vary_part(next.parts[part], limits.parts[part], lots);
    }
  }
  return next;
}

AttackRows rows_of(const Attack& attack, const RobotModel& model, std::uint32_t rows) {
  AttackRows found;
  for (std::size_t part = 0; part < model.limits.parts.size(); ++part) {
    RowMaker maker(attack, model, part);
    std::vector<double>& numbers = found.numbers.emplace_back();
    for (std::uint32_t row = 0; row < rows; ++row) {
      const Row next = maker.next();
      numbers.insert(numbers.end(), next.begin(), next.end());
    }
    found.actions.push_back(action_of(model.limits, part, attack.parts[part].mode, numbers));
  }
  return found;
}

}  // namespace fairlead::bench
