#include "decisions/chunk_probe.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstring>
#include <type_traits>

namespace fairlead {
namespace {

static_assert(std::is_trivially_copyable_v<Verdict>);

bool has_halves(std::uint8_t mode) {
  return mode == static_cast<std::uint8_t>(Mode::cartesian_delta) ||
         mode == static_cast<std::uint8_t>(Mode::cartesian_twist) ||
         mode == static_cast<std::uint8_t>(Mode::body_twist);
}

constexpr std::size_t quaternion_column = 3;  // of a pose: xyz, then xyzw

std::vector<std::size_t> pose_columns(std::string_view axis) {
  if (axis.empty()) return {0, 1, 2, 3, 4, 5, 6};
  if (axis == "linear") return {0, 1, 2};
  if (axis == "angular") return {3, 4, 5, 6};
  if (axis == "x") return {0};
  if (axis == "y") return {1};
  if (axis == "z") return {2};
  return {};
}

Eigen::Quaterniond quaternion_at(const double* xyzw) {
  return Eigen::Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
}

// A turn cannot be scaled number by number: its angle is.
void turn(const double* about_xyzw, double scale, double* xyzw) {
  const Eigen::Quaterniond about = quaternion_at(about_xyzw);
  Eigen::Quaterniond difference = about.conjugate() * quaternion_at(xyzw);
  if (difference.w() < 0.0) difference.coeffs() *= -1.0;  // the short way
  const Eigen::AngleAxisd whole(difference);
  const Eigen::Quaterniond part(Eigen::AngleAxisd(scale * whole.angle(), whole.axis()));
  const Eigen::Quaterniond turned = (about * part).normalized();
  const std::array<double, 4> numbers{turned.x(), turned.y(), turned.z(), turned.w()};
  std::copy(numbers.begin(), numbers.end(), xyzw);
}

}  // namespace

ChunkProbe::ChunkProbe(Replay& replay, const Record& record, const Limits& limits)
    : replay_(replay), record_(record), limits_(limits) {
  if (decode(record.event.payload, chunk_) != FrameFault::none) chunk_ = ActionChunk();
}

std::optional<std::size_t> ChunkProbe::action_of(std::string_view part) const {
  for (std::size_t i = 0; i < chunk_.parts.size(); ++i) {
    const std::uint8_t index = chunk_.parts[i].part;
    if (index < limits_.parts.size() && limits_.parts[index].name == part) return i;
  }
  return std::nullopt;
}

std::vector<std::size_t> ChunkProbe::columns_of(std::size_t action, std::string_view axis) const {
  const ActionPart& part = chunk_.parts[action];
  if (is_joint_mode(part.mode)) {
    std::vector<std::size_t> columns;
    for (const std::uint8_t j : part.active)
      if (axis.empty() || limits_.joints[j].name == axis) columns.push_back(j);
    return columns;
  }
  if (part.mode == static_cast<std::uint8_t>(Mode::cartesian_pose)) return pose_columns(axis);
  if (has_halves(part.mode) && axis == "linear") return {0, 1, 2};
  if (has_halves(part.mode) && axis == "angular") return {3, 4, 5};
  std::vector<std::size_t> columns(mode_width(part.mode, limits_.joints.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) columns[i] = i;
  return columns;
}

double ChunkProbe::number(std::size_t action, std::size_t row, std::size_t column) const {
  const ActionPart& part = chunk_.parts[action];
  return part.values[row * mode_width(part.mode, limits_.joints.size()) + column];
}

std::vector<double> ChunkProbe::numbers_of(std::size_t action) const {
  const NumberView& values = chunk_.parts[action].values;
  std::vector<double> numbers(values.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = values[i];
  return numbers;
}

std::optional<Verdict> ChunkProbe::scaled(const Selection& selection,
                                          const std::vector<double>& about, double scale) {
  const ActionPart& part = chunk_.parts[selection.action];
  const bool is_pose = part.mode == static_cast<std::uint8_t>(Mode::cartesian_pose);
  const std::size_t width = mode_width(part.mode, limits_.joints.size());
  std::vector<double> numbers = numbers_of(selection.action);
  for (std::size_t row = selection.first_row; row < selection.end_row; ++row) {
    for (std::size_t c = 0; c < selection.columns.size(); ++c) {
      double* number = &numbers[row * width + selection.columns[c]];
      if (is_pose && selection.columns[c] == quaternion_column) {
        turn(&about[c], scale, number);
        break;  // the three that follow are the quaternion's too, and the last
      }
      *number = about[c] + scale * (*number - about[c]);
    }
  }
  return answer_to(selection.action, numbers);
}

std::optional<Verdict> ChunkProbe::rounded(std::size_t action) {
  std::vector<double> numbers = numbers_of(action);
  for (double& number : numbers) number = number < 0.5 ? 0.0 : 1.0;
  return answer_to(action, numbers);
}

std::optional<Verdict> ChunkProbe::answer_to(std::size_t action,
                                             const std::vector<double>& numbers) {
  ActionChunk changed = chunk_;
  changed.parts[action].values = NumberView(Bytes(
      reinterpret_cast<const std::uint8_t*>(numbers.data()), numbers.size() * sizeof(double)));
  return answer_to(Bytes(frame_).first(encode(changed, frame_)));
}

std::optional<Verdict> ChunkProbe::answer_to(Bytes frame) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) return std::nullopt;
  const pid_t child = ::fork();
  if (child == 0) {
    Record asked = record_;
    asked.event.payload = frame;
    replay_.feed(asked);
    for (const Output& output : replay_.outputs().items()) {
      Verdict verdict;
      if (output.kind != OutputKind::verdict ||
          decode(replay_.outputs().payload(output), verdict) != FrameFault::none ||
          verdict.seq != chunk_.seq || !(verdict.source == record_.event.source))
        continue;
      const ssize_t written = ::write(ends[1], &verdict, sizeof verdict);
      ::_exit(written == sizeof verdict ? 0 : 1);
    }
    ::_exit(1);
  }
  ::close(ends[1]);
  Verdict verdict;
  std::array<std::uint8_t, sizeof verdict> bytes{};
  const bool answered =
      child > 0 && ::read(ends[0], bytes.data(), bytes.size()) == ssize_t{sizeof verdict};
  ::close(ends[0]);
  if (child > 0) ::waitpid(child, nullptr, 0);
  if (!answered) return std::nullopt;
  std::memcpy(&verdict, bytes.data(), sizeof verdict);
  return verdict;
}

}  // namespace fairlead
