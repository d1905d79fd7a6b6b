// Chunks for the tests. The builder owns the numbers that a chunk's views point at.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/messages.hpp"
#include "test_robot.hpp"

namespace fairlead::test {

using Row = std::vector<double>;
using Rows = std::vector<Row>;

inline std::vector<std::uint8_t> frame_of(const auto& message) {
  std::vector<std::uint8_t> frame(8 * max_frame_bytes);
  frame.resize(encode(message, frame));
  return frame;
}

class ChunkBuilder {
 public:
  ActionChunk chunk;

  explicit ChunkBuilder(std::uint32_t horizon = 1) {
    chunk.horizon = horizon;
    chunk.robot_hash = hash_of(7);
    chunk.source = "runner";
    chunk.seq = 1;
  }

  /// A part with every number given, row by row.
  ChunkBuilder& add(std::uint8_t part, Mode mode, const Rows& rows,
                    std::initializer_list<std::uint8_t> active = {}, const char* frame_id = "") {
    ActionPart action;
    action.part = part;
    action.mode = static_cast<std::uint8_t>(mode);
    action.frame_id = frame_id;
    std::vector<double>& numbers = storage_->emplace_back();
    for (const Row& row : rows) numbers.insert(numbers.end(), row.begin(), row.end());
    action.values = view(numbers);
    for (const std::uint8_t j : active) (void)action.active.push_back(j);
    (void)chunk.parts.push_back(action);
    chunk.horizon = static_cast<std::uint32_t>(rows.size());
    return *this;
  }
  /// Joint mode, one joint: the rest is padding.
  ChunkBuilder& joint(std::uint8_t part, Mode mode, std::uint8_t joint, const Row& values) {
    Rows rows;
    for (const double value : values) {
      Row row(joint_count, 0.0);
      row[joint] = value;
      rows.push_back(row);
    }
    return add(part, mode, rows, {joint});
  }
  /// Cartesian mode along one axis of base_link.
  ChunkBuilder& along(std::uint8_t part, Mode mode, std::size_t axis, const Row& values) {
    Rows rows;
    for (const double value : values) {
      Row row(6, 0.0);
      row[axis] = value;
      rows.push_back(row);
    }
    return add(part, mode, rows, {}, "base_link");
  }
  /// Poses in base_link: xyz and quaternion xyzw, row by row.
  ChunkBuilder& poses(std::uint8_t part, const Rows& rows) {
    return add(part, Mode::cartesian_pose, rows, {}, "base_link");
  }
  ChunkBuilder& scalar(std::uint8_t part, Mode mode, const Row& values) {
    Rows rows;
    for (const double value : values) rows.push_back({value});
    return add(part, mode, rows);
  }
  [[nodiscard]] std::vector<std::uint8_t> frame() const { return frame_of(chunk); }

 private:
  static NumberView view(const std::vector<double>& numbers) {
    return NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers.data()),
                            numbers.size() * sizeof(double)));
  }
  // Shared, so that a copied builder's views stay valid.
  std::shared_ptr<std::deque<std::vector<double>>> storage_ =
      std::make_shared<std::deque<std::vector<double>>>();
};

}  // namespace fairlead::test
