// What the gate knows about the robot: whose session it follows, and the newest state of it.
//
// Before the first hal/status there is no session and every state is ignored. Another session
// is followed only when it has delivered a valid state while the present one is silent, so that
// a stray message cannot shut out the real HAL. A session once left is never followed again, so
// a late message of a dead HAL cannot bring it back.
#pragma once

#include <array>
#include <cstdint>

#include "core/chunk/judgement.hpp"
#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// What a HAL may step on by in lockstep without a claim: states that a link lost while the world
/// came to standstill, or before it was met.
inline constexpr std::uint64_t unheard_ticks = 100'000;

class HalLink {
 public:
  enum class News : std::uint8_t { nothing, facts_changed, new_session, two_at_once };

  explicit HalLink(const Limits& limits) : limits_(limits) {}

  /// Take a hal/status.
  News take_status(const HalStatus& status);
  /// The newest tick that the session's first state can be of, by what its newest status said.
  [[nodiscard]] std::uint64_t newest_first() const;

  /// A valid state of the session that only announced itself so far.
  News take_rival_state(std::uint64_t now_ns);
  /// The session that announced itself beside the one that is followed, 0 if none did.
  [[nodiscard]] std::uint64_t rival() const { return rival_.session; }
  /// Whether both have delivered states within the last seconds.
  [[nodiscard]] bool two_at_once(std::uint64_t now_ns) const;

  /// What keeps this HAL from being armed, "" if nothing does.
  [[nodiscard]] const Text& mismatch() const { return facts_.mismatch; }

  /// Copy a state that has passed check_state and has a newer tick than the last.
  void take_state(const JointState& message, std::uint64_t now_ns);
  /// Whether a state of the newest tick says what the one that was taken did.
  [[nodiscard]] bool repeats(const JointState& message) const;
  /// The newest tick that a HAL in realtime can have reached, by when its last states arrived.
  /// Several are looked at, because one of them may itself have been late.
  [[nodiscard]] std::uint64_t newest_possible(std::uint64_t now_ns) const;
  /// Whether a tick beyond that follows from the last one refused for it: then the HAL's count is
  /// what it says, and the states taken before were the odd ones. Remembers the tick otherwise.
  bool confirms_leap(std::uint64_t tick, std::uint64_t now_ns);
  /// The newest tick's state came again: in lockstep the world stands. Positions behind a lost
  /// state tell how fast a joint was in between, and no later state would tell that it stands: from
  /// then on velocities decide, as in a first state.
  void note_repeat();
  /// A valid state was heard, be it a repeat.
  void note_heard(std::uint64_t now_ns) { heard_ns_ = now_ns; }

  [[nodiscard]] std::uint64_t session() const { return facts_.session; }
  [[nodiscard]] bool lockstep() const { return facts_.lockstep; }
  [[nodiscard]] bool resetting() const { return facts_.resetting; }
  [[nodiscard]] bool has_state() const { return has_state_; }
  [[nodiscard]] const MeasuredState& state() const { return state_; }
  [[nodiscard]] std::uint64_t tick() const { return has_state_ ? state_.tick : 0; }
  /// The newest tick of the session followed before this one; 0: none of it was seen.
  [[nodiscard]] std::uint64_t ended_tick() const { return ended_tick_; }
  /// How many ticks of realtime a lease grants beyond the state that it is of.
  [[nodiscard]] static std::uint64_t granted_ticks(std::uint64_t period_ns);
  /// The last tick that a lease lets rows act in: the gate's word is good until then.
  [[nodiscard]] std::uint64_t last_granted_tick() const;
  /// When the newest tick arrived; repeats of it do not count.
  [[nodiscard]] std::uint64_t arrival_ns() const { return arrival_ns_; }
  /// When a state of this session was heard last; repeats count.
  [[nodiscard]] std::uint64_t heard_ns() const { return heard_ns_; }

 private:
  // What a hal/status says about its session.
  struct Facts {
    std::uint64_t session = 0;
    bool lockstep = false;
    bool resetting = false;
    std::uint64_t tick = 0;
    Text mismatch = "no hal/status received yet";
  };

  struct Arrival {
    std::uint64_t tick = 0;  // 0: none
    std::uint64_t ns = 0;
  };

  [[nodiscard]] std::uint64_t latest_tick(const Arrival& from, std::uint64_t now_ns) const;
  [[nodiscard]] Facts facts_of(const HalStatus& status) const;
  void follow(const Facts& facts);
  Text find_mismatch(const HalStatus& status) const;
  [[nodiscard]] bool was_left(std::uint64_t session) const;

  const Limits& limits_;
  std::array<std::uint64_t, 64> left_{};
  std::size_t next_left_ = 0;
  Facts facts_;
  Facts rival_;
  std::uint64_t rival_heard_ns_ = 0;  // its newest valid state, 0: none
  MeasuredState state_;
  bool has_state_ = false;
  std::uint64_t ended_tick_ = 0;
  bool behind_lost_ = false;        // that state: the one of the tick before was not heard
  std::uint64_t episode_tick_ = 0;  // of that state
  std::uint64_t arrival_ns_ = 0;
  std::uint64_t heard_ns_ = 0;
  std::array<Arrival, 8> arrivals_{};  // of the last new ticks
  std::size_t next_arrival_ = 0;
  Arrival refused_leap_;
};

}  // namespace fairlead
