// The real gate on recorded steps: with their times, bytes and ids, and nothing else.
#pragma once

#include <memory>

#include "decisions/record.hpp"

namespace fairlead {

/// The ids of a record, in the order they were drawn. If a gate asks for more than were
/// recorded, which only one under other limits does, it gets new ones.
class ReplayedIds final : public IdSource {
 public:
  void offer(const IdList& ids);
  std::uint64_t next_id() override;
  /// True if the newest record's ids were all drawn and no more.
  [[nodiscard]] bool exact() const { return next_ == offered_.size() && !made_up_; }

 private:
  IdList offered_;
  std::size_t next_ = 0;
  bool made_up_ = false;
  std::uint64_t last_made_up_ = 0;
};

class Replay {
 public:
  /// `limits` must outlive it.
  explicit Replay(const Limits& limits) : limits_(limits) {}

  /// Do what the record says. Records that are no step do nothing.
  void feed(const Record& record);
  [[nodiscard]] const Outputs& outputs() const { return *outputs_; }
  /// Whether the newest step gave byte for byte what the record says, and drew the same ids.
  [[nodiscard]] bool same_as(const Record& record) const;
  /// False before the first boot record.
  [[nodiscard]] bool started() const { return gate_ != nullptr; }
  [[nodiscard]] GateState state() const;

 private:
  const Limits& limits_;
  ReplayedIds ids_;
  std::unique_ptr<Gate> gate_;
  std::unique_ptr<Outputs> outputs_ = std::make_unique<Outputs>();
};

}  // namespace fairlead
