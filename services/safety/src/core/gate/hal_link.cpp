#include "core/gate/hal_link.hpp"

#include <algorithm>

#include "core/chunk/state_check.hpp"

namespace fairlead {
namespace {

// A HAL that lives says so far more often: at least every 100 ms, in any pacing.
constexpr std::uint64_t silent_ns = 500'000'000;

constexpr std::uint64_t grant_ns = 75'000'000;  // how long a grant outlives its lease

template <std::size_t N, class Declared>
Text compare_names(const FixedVec<Name, N>& found, const Declared& declared,
                   std::string_view what) {
  if (found.size() != declared.size())
    return phrase("the HAL has ", found.size(), " ", what, ", the gate file ", declared.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    if (!(found[i] == declared[i].name))
      return phrase("the HAL's ", what, " ", i, " is ", found[i], ", the gate file's ",
                    declared[i].name);
  return {};
}

}  // namespace

bool HalLink::was_left(std::uint64_t session) const {
  for (const std::uint64_t past : left_)
    if (past == session) return true;
  return false;
}

HalLink::Facts HalLink::facts_of(const HalStatus& status) const {
  return {status.session, status.pacing == "lockstep", status.state == "resetting", status.tick,
          find_mismatch(status)};
}

void HalLink::follow(const Facts& facts) {
  if (facts_.session != 0) left_[next_left_++ % left_.size()] = facts_.session;
  ended_tick_ = tick();
  facts_ = facts;
  rival_ = Facts{};
  rival_heard_ns_ = 0;
  has_state_ = false;
  arrivals_.fill(Arrival{});
  refused_leap_ = Arrival{};
}

// One period for each begun since then, and one for the jitter of either. What came in on another
// link may have got its turn first.
std::uint64_t HalLink::latest_tick(const Arrival& from, std::uint64_t now_ns) const {
  const std::uint64_t since_ns = now_ns - std::min(now_ns, from.ns);
  const std::uint64_t ticks = (since_ns + limits_.period_ns - 1) / limits_.period_ns + 1;
  return from.tick + std::min(ticks, UINT64_MAX - from.tick);
}

std::uint64_t HalLink::newest_possible(std::uint64_t now_ns) const {
  std::uint64_t newest = 0;
  for (const Arrival& arrival : arrivals_)
    if (arrival.tick != 0) newest = std::max(newest, latest_tick(arrival, now_ns));
  return newest;
}

std::uint64_t HalLink::granted_ticks(std::uint64_t period_ns) {
  return std::max<std::uint64_t>(2, (grant_ns + period_ns - 1) / period_ns);
}

std::uint64_t HalLink::last_granted_tick() const {
  if (lockstep()) return tick();
  return tick() + std::min(granted_ticks(limits_.period_ns), UINT64_MAX - tick());
}

bool HalLink::confirms_leap(std::uint64_t tick, std::uint64_t now_ns) {
  const bool agrees = refused_leap_.tick != 0 && tick > refused_leap_.tick &&
                      tick <= latest_tick(refused_leap_, now_ns);
  refused_leap_ = agrees ? Arrival{} : Arrival{tick, now_ns};
  return agrees;
}

HalLink::News HalLink::take_status(const HalStatus& status) {
  if (status.session == 0 || was_left(status.session)) return News::nothing;
  const Facts facts = facts_of(status);
  if (facts_.session == 0) {
    follow(facts);
    return News::new_session;
  }
  if (facts.session != facts_.session) {  // it has to show a state first
    if (facts.session != rival_.session) rival_heard_ns_ = 0;
    rival_ = facts;
    return News::nothing;
  }
  const bool changed = !(facts.mismatch == facts_.mismatch) || facts.lockstep != facts_.lockstep;
  facts_ = facts;
  return changed ? News::facts_changed : News::nothing;
}

std::uint64_t HalLink::newest_first() const {
  return facts_.tick + std::min(unheard_ticks, UINT64_MAX - facts_.tick);
}

HalLink::News HalLink::take_rival_state(std::uint64_t now_ns) {
  const bool both = has_state_ && now_ns - heard_ns_ <= silent_ns;
  if (!both) {
    follow(Facts{rival_});
    return News::new_session;
  }
  const bool known = two_at_once(now_ns);
  rival_heard_ns_ = now_ns;
  return known ? News::nothing : News::two_at_once;
}

bool HalLink::two_at_once(std::uint64_t now_ns) const {
  return rival_heard_ns_ != 0 && now_ns - rival_heard_ns_ <= 4 * silent_ns;
}

Text HalLink::find_mismatch(const HalStatus& status) const {
  if (status.robot_hash != limits_.robot_hash) return "the HAL's robot_hash is not the gate file's";
  if (status.period_ns != limits_.period_ns)
    return phrase("the HAL's period is ", status.period_ns, " ns, the gate file's ",
                  limits_.period_ns, " ns");
  if (!(status.pacing == "realtime") && !(status.pacing == "lockstep"))
    return phrase("unknown pacing ", status.pacing, "; known: realtime, lockstep");
  if (status.pacing == "lockstep" && !limits_.lockstep_allowed)
    return phrase("the HAL paces in lockstep, which profile ", limits_.profile, " does not allow");
  if (status.state == "fault") return phrase("the HAL reports a fault: ", status.detail);
  const Text joints = compare_names(status.joints, limits_.joints, "joint");
  return joints.empty()
             ? compare_names(status.passive_joints, limits_.passive_joints, "passive joint")
             : joints;
}

bool HalLink::repeats(const JointState& message) const {
  for (std::size_t i = 0; i < state_.count; ++i)
    if (message.positions[i] != state_.positions[i] ||
        message.velocities[i] != state_.velocities[i] || message.efforts[i] != state_.efforts[i])
      return false;
  return message.episode_tick == episode_tick_ && message.acted == state_.acted;
}

void HalLink::take_state(const JointState& message, std::uint64_t now_ns) {
  // An episode begins somewhere else, without a motion that led there.
  const bool same_episode = has_state_ && message.episode_tick == episode_tick_;
  for (std::size_t i = 0; i < message.positions.size(); ++i)
    state_.travel_speeds[i] =
        same_episode ? travel_speed(limits_, i, state_.positions[i], message.positions[i]) : 0.0;
  behind_lost_ = message.tick - state_.tick > 1;
  episode_tick_ = message.episode_tick;
  arrival_ns_ = now_ns;
  arrivals_[next_arrival_++ % arrivals_.size()] = {message.tick, now_ns};
  heard_ns_ = now_ns;
  has_state_ = true;
  state_.tick = message.tick;
  state_.count = message.positions.size();
  for (std::size_t i = 0; i < state_.count; ++i) {
    state_.positions[i] = message.positions[i];
    state_.velocities[i] = message.velocities[i];
    state_.efforts[i] = message.efforts[i];
  }
  state_.acted = message.acted;
}

void HalLink::note_repeat() {
  if (behind_lost_) state_.travel_speeds = {};
}

}  // namespace fairlead
