// What the gate would have answered to a chunk other than the one it got, at that very moment.
//
// Each question is put to a copy of this whole process (fork), stepped once and thrown away: the
// gate has no way back from a step, and needs none. Only for commands that read a log.
#pragma once

#include <optional>
#include <vector>

#include "decisions/replay.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// Some numbers of one part of a chunk: `columns` of rows `first_row` to before `end_row`.
struct Selection {
  std::size_t action = 0;  // index into the chunk's parts
  std::size_t first_row = 0;
  std::size_t end_row = 0;
  std::vector<std::size_t> columns;
};

class ChunkProbe {
 public:
  /// `replay` stands before the step of `record`, a candidate. Both must outlive it.
  ChunkProbe(Replay& replay, const Record& record, const Limits& limits);

  [[nodiscard]] const ActionChunk& chunk() const { return chunk_; }
  /// Index into the chunk's parts, nothing if none is called so.
  [[nodiscard]] std::optional<std::size_t> action_of(std::string_view part) const;
  /// The columns that the axis of a verdict is about; all that are commanded for "".
  [[nodiscard]] std::vector<std::size_t> columns_of(std::size_t action,
                                                    std::string_view axis) const;
  [[nodiscard]] double number(std::size_t action, std::size_t row, std::size_t column) const;

  /// The verdict if every selected number x were about + scale * (x - about), with one `about`
  /// per selected column. A pose's quaternion is turned instead: by that share of the turn from
  /// the one in `about`. Nothing if there was no verdict.
  std::optional<Verdict> scaled(const Selection& selection, const std::vector<double>& about,
                                double scale);

  /// The verdict if every number of the part were 0 or 1, whichever is nearer.
  std::optional<Verdict> rounded(std::size_t action);

 private:
  [[nodiscard]] std::vector<double> numbers_of(std::size_t action) const;
  std::optional<Verdict> answer_to(std::size_t action, const std::vector<double>& numbers);
  std::optional<Verdict> answer_to(Bytes frame);

  Replay& replay_;
  const Record& record_;
  const Limits& limits_;
  ActionChunk chunk_;
  std::vector<std::uint8_t> frame_ = std::vector<std::uint8_t>(max_frame_bytes);
};

}  // namespace fairlead
