#include "hal_link.hpp"

#include "phrase.hpp"

namespace fairlead {
namespace {

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

HalLink::News HalLink::take_status(const HalStatus& status) {
  if (status.session == 0 || was_left(status.session)) return News::nothing;
  const bool is_new = status.session != session_;
  if (is_new) {
    if (session_ != 0) left_[next_left_++ % left_.size()] = session_;
    session_ = status.session;
    has_state_ = false;
  }
  const Text mismatch = find_mismatch(status);
  const bool lockstep = status.pacing == "lockstep";
  const bool changed = !(mismatch == mismatch_) || lockstep != lockstep_;
  mismatch_ = mismatch;
  lockstep_ = lockstep;
  return is_new ? News::new_session : changed ? News::facts_changed : News::nothing;
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

void HalLink::take_state(const JointState& message, std::uint64_t now_ns) {
  if (!has_state_ || message.tick > state_.tick) arrival_ns_ = now_ns;
  has_state_ = true;
  state_.tick = message.tick;
  state_.count = message.positions.size();
  for (std::size_t i = 0; i < state_.count; ++i) {
    state_.positions[i] = message.positions[i];
    state_.velocities[i] = message.velocities[i];
  }
  state_.acted = message.acted;
}

}  // namespace fairlead
