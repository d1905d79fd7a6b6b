#include "decisions/chunk_probe.hpp"

#include <sys/wait.h>
#include <unistd.h>

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

// A rotation cannot be scaled number by number: none of its columns is one of its own.
std::vector<std::size_t> pose_columns(std::string_view axis) {
  if (axis == "linear") return {0, 1, 2};
  if (axis == "x") return {0};
  if (axis == "y") return {1};
  if (axis == "z") return {2};
  return {};
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

std::optional<Verdict> ChunkProbe::scaled(const Selection& selection,
                                          const std::vector<double>& about, double scale) {
  ActionChunk changed = chunk_;
  ActionPart& part = changed.parts[selection.action];
  const std::size_t width = mode_width(part.mode, limits_.joints.size());
  std::vector<double> values(part.values.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = part.values[i];
  for (std::size_t row = selection.first_row; row < selection.end_row; ++row) {
    for (std::size_t c = 0; c < selection.columns.size(); ++c) {
      double& number = values[row * width + selection.columns[c]];
      number = about[c] + scale * (number - about[c]);
    }
  }
  part.values = NumberView(
      Bytes(reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(double)));
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
