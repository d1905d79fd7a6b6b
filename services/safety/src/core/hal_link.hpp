// What the gate knows about the robot: whose session it follows, and the newest state of it.
//
// Before the first hal/status there is no session and every state is ignored. A session once
// left is never followed again, so a late message of a dead HAL cannot bring it back.
#pragma once

#include <array>
#include <cstdint>

#include "fairlead_safety/judge.hpp"
#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

class HalLink {
 public:
  enum class News : std::uint8_t { nothing, facts_changed, new_session };

  explicit HalLink(const Limits& limits) : limits_(limits) {}

  /// Take a hal/status.
  News take_status(const HalStatus& status);

  /// What keeps this HAL from being armed, "" if nothing does.
  [[nodiscard]] const Text& mismatch() const { return mismatch_; }

  /// Copy a state that has passed check_state; its tick is newer or the same.
  void take_state(const JointState& message, std::uint64_t now_ns);

  [[nodiscard]] std::uint64_t session() const { return session_; }
  [[nodiscard]] bool lockstep() const { return lockstep_; }
  [[nodiscard]] bool has_state() const { return has_state_; }
  [[nodiscard]] const MeasuredState& state() const { return state_; }
  [[nodiscard]] std::uint64_t tick() const { return has_state_ ? state_.tick : 0; }
  /// When the newest tick arrived; repeats of it do not count.
  [[nodiscard]] std::uint64_t arrival_ns() const { return arrival_ns_; }

 private:
  Text find_mismatch(const HalStatus& status) const;
  [[nodiscard]] bool was_left(std::uint64_t session) const;

  const Limits& limits_;
  std::uint64_t session_ = 0;
  std::array<std::uint64_t, 64> left_{};
  std::size_t next_left_ = 0;
  bool lockstep_ = false;
  Text mismatch_ = "no hal/status received yet";
  MeasuredState state_;
  bool has_state_ = false;
  std::uint64_t arrival_ns_ = 0;
};

}  // namespace fairlead
