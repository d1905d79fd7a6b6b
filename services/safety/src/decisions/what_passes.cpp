#include "decisions/what_passes.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/kinematics/forward_kinematics.hpp"
#include "decisions/verdict_document.hpp"
#include "process/verdict_text.hpp"

namespace fairlead {
namespace {

using nlohmann::json;

constexpr double kFarEnough = 100.0;  // a limit beyond so many times the chunk is not near

bool is_released(const std::optional<Verdict>& verdict) {
  return verdict.has_value() && verdict->outcome == static_cast<std::uint8_t>(Outcome::released);
}

/// Four digits, towards zero.
double rounded_down(double value) {
  if (value <= 0.0) return 0.0;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 3.0);
  return std::floor(value / unit) * unit;
}

bool is_pose(const ActionPart& action) {
  return action.mode == static_cast<std::uint8_t>(Mode::cartesian_pose);
}

/// Where the tool is measured to be, in the frame that the poses are told in: xyz, xyzw.
std::vector<double> measured_pose(const ActionPart& action, const Limits& limits,
                                  const std::vector<double>& measured) {
  Joints joints{};
  std::copy_n(measured.begin(), std::min(measured.size(), joints.size()), joints.begin());
  const auto model = std::make_unique<RobotModel>(limits);
  const Pose pose = link_pose(*model, {*model, joints}, limits.kinematics.find(action.frame_id),
                              limits.parts[action.part].tool);
  const Eigen::Quaterniond turn(pose.rotation);
  return {pose.position.x(), pose.position.y(), pose.position.z(), turn.x(),
          turn.y(),          turn.z(),          turn.w()};
}

/// Where numbers of the mode count from: standing still, or where the robot is. Empty: unknown.
std::vector<double> rest_of(const ActionPart& action, const std::vector<std::size_t>& columns,
                            const Limits& limits, const std::vector<double>& measured) {
  switch (static_cast<Mode>(action.mode)) {
    case Mode::joint_velocity:
    case Mode::cartesian_delta:
    case Mode::cartesian_twist:
    case Mode::body_twist:
    case Mode::composite_mode:
      return std::vector<double>(columns.size(), 0.0);
    case Mode::joint_position:
    case Mode::dex_hand_joint: {
      std::vector<double> rest;
      for (const std::size_t j : columns)
        if (j < measured.size()) rest.push_back(measured[j]);
      return rest;
    }
    case Mode::cartesian_pose: {
      const std::vector<double> pose = measured_pose(action, limits, measured);
      std::vector<double> rest;
      for (const std::size_t column : columns) rest.push_back(pose[column]);
      return rest;
    }
    case Mode::gripper_position: {
      const std::size_t joint = limits.parts[action.part].joints[0];
      if (joint < measured.size()) return {measured[joint]};
      return {};
    }
    default:
      return {};
  }
}

/// The largest scale between `passes` and `fails` that passes.
double largest_passing(ChunkProbe& probe, const Selection& selection,
                       const std::vector<double>& about, double passes, double fails) {
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (passes + fails);
    (is_released(probe.scaled(selection, about, middle)) ? passes : fails) = middle;
  }
  return passes;
}

/// That scale to four digits, so that it can be told; the gate was asked about exactly this one.
double told(ChunkProbe& probe, const Selection& selection, const std::vector<double>& about,
            double scale) {
  const double rounded = rounded_down(scale * (1.0 + 1e-9));
  return is_released(probe.scaled(selection, about, rounded)) ? rounded : scale;
}

double size_of(const ChunkProbe& probe, const Selection& selection) {
  if (selection.columns.size() == 1)
    return probe.number(selection.action, selection.first_row, selection.columns[0]);
  double sum = 0.0;
  for (const std::size_t column : selection.columns) {
    const double x = probe.number(selection.action, selection.first_row, column);
    sum += x * x;
  }
  return std::sqrt(sum);
}

Selection every_row(const ChunkProbe& probe, std::size_t action) {
  return Selection{action, 0, probe.chunk().horizon, probe.columns_of(action, "")};
}

// The numbers of the verdict's axis in its row alone, moved towards the row before, or towards
// rest if there is none that acts.
json one_row(ChunkProbe& probe, const Verdict& verdict, std::size_t action, const Limits& limits,
             const std::vector<double>& measured) {
  const auto row = static_cast<std::size_t>(verdict.row);
  const Selection selection{action, row, row + 1, probe.columns_of(action, verdict.axis.view())};
  if (selection.columns.empty()) return nullptr;
  std::vector<double> about;
  const bool is_first = verdict.outcome == static_cast<std::uint8_t>(Outcome::refused) || row == 0;
  if (is_first) {
    about = rest_of(probe.chunk().parts[action], selection.columns, limits, measured);
    if (about.size() != selection.columns.size()) return nullptr;
  } else {
    for (const std::size_t column : selection.columns)
      about.push_back(probe.number(action, row - 1, column));
  }
  if (!is_released(probe.scaled(selection, about, 0.0))) return nullptr;
  const double scale = largest_passing(probe, selection, about, 0.0, 1.0);
  const double asked = size_of(probe, selection);
  json found = {{"change", "row"}, {"scale", scale}, {"about_row", !is_first}, {"asked", asked}};
  if (selection.columns.size() == 1)
    found["number"] = about[0] + scale * (asked - about[0]);
  else if (is_first && !is_pose(probe.chunk().parts[action]))
    found["number"] = scale * asked;
  else
    found["scale"] = told(probe, selection, about, scale);
  return found;
}

json all_rows(ChunkProbe& probe, std::size_t action, const Limits& limits,
              const std::vector<double>& measured) {
  const Selection selection = every_row(probe, action);
  const std::vector<double> rest =
      rest_of(probe.chunk().parts[action], selection.columns, limits, measured);
  if (selection.columns.empty() || rest.size() != selection.columns.size()) return nullptr;
  const std::optional<Verdict> still = probe.scaled(selection, rest, 0.0);
  if (!is_released(still))
    return {{"change", "none"}, {"still", still.has_value() ? verdict_document(*still) : json()}};
  const double scale = largest_passing(probe, selection, rest, 0.0, 1.0);
  return {{"change", "rows"}, {"scale", told(probe, selection, rest, scale)}};
}

// A rule has no magnitude; a change (G025) is a matter of when, not of how much.
bool is_about_numbers(const Verdict& verdict) {
  return verdict.row >= 0 && verdict.code >= 20 && verdict.code != 25 &&
         std::isfinite(verdict.value) && has_magnitude(verdict);
}

}  // namespace

json what_would_pass(ChunkProbe& probe, const Verdict& verdict, const Limits& limits,
                     const std::vector<double>& measured) {
  const auto action = probe.action_of(verdict.part.view());
  if (!is_about_numbers(verdict) || !action.has_value()) return nullptr;
  if (probe.chunk().parts[*action].mode == static_cast<std::uint8_t>(Mode::gripper_binary))
    return is_released(probe.rounded(*action)) ? json{{"change", "rounded"}} : json();
  const json row = one_row(probe, verdict, *action, limits, measured);
  return row.is_null() ? all_rows(probe, *action, limits, measured) : row;
}

json nearest_limits(ChunkProbe& probe, const Limits& limits, const std::vector<double>& measured) {
  json found = json::array();
  for (std::size_t action = 0; action < probe.chunk().parts.size(); ++action) {
    const ActionPart& part = probe.chunk().parts[action];
    const Selection selection = every_row(probe, action);
    const std::vector<double> rest = rest_of(part, selection.columns, limits, measured);
    if (selection.columns.empty() || rest.size() != selection.columns.size()) continue;
    json entry = {{"part", limits.parts[part.part].name.view()}, {"scale", nullptr}};
    double passes = 1.0;
    double fails = 2.0;
    while (fails <= kFarEnough && is_released(probe.scaled(selection, rest, fails)))
      passes = std::exchange(fails, 2.0 * fails);
    if (fails <= kFarEnough) {
      const double largest = largest_passing(probe, selection, rest, passes, fails);
      const double scale = told(probe, selection, rest, largest);
      entry["scale"] = scale;
      const std::optional<Verdict> beyond = probe.scaled(selection, rest, scale * 1.01);
      if (beyond.has_value() && !is_released(beyond)) entry["beyond"] = verdict_document(*beyond);
    }
    found.push_back(entry);
  }
  return found;
}

}  // namespace fairlead
