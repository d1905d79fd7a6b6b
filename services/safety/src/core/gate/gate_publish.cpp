// What every step ends with: SafeChunks before the lease that permits them, then the rest.

#include <algorithm>

#include "core/gate/gate_core.hpp"

namespace fairlead {
namespace {

constexpr std::uint64_t ms = 1'000'000;
constexpr std::uint64_t timer_period_ns = 5 * ms;  // the shell's longest pause between steps
constexpr std::uint64_t status_interval_ns = 500 * ms;
constexpr std::uint64_t grant_ns = 75 * ms;  // how long a grant outlives its lease

}  // namespace

void Gate::Core::finish() {
  const std::uint64_t lease_interval_ns = limits_.protocol.lease_interval_ms * ms;
  if (lease_due_ || now_ns_ - lease_ns_ + timer_period_ns > lease_interval_ns) publish_lease();
  for (const Verdict& verdict : verdicts_) out_->add(OutputKind::verdict, verdict.source, verdict);
  verdicts_.clear();
  if (persist_latch_due_) {
    out_->add(OutputKind::persist_latch, Name(), LatchRecord{latch_id_, hal_.tick(), cause_});
    persist_latch_due_ = false;
  }
  if (clean_mark_due_) {
    out_->add(OutputKind::write_clean_mark);
    clean_mark_due_ = false;
  }
  if (status_due_ || now_ns_ - status_ns_ >= status_interval_ns) {
    publish_status(OutputKind::status);
    status_ns_ = now_ns_;
    status_due_ = false;
  }
}

void Gate::Core::publish_lease() {
  Lease& lease = leases_.next();
  lease.grants.clear();
  for (LiveClaim& claim : claims_.places()) {
    if (!claim.live()) continue;
    publish_safe_chunk(claim);
    (void)lease.grants.push_back(grant_for(claim));  // as many places as claims
  }
  lease.session = hal_.session();
  lease.config_hash = limits_.config_hash;
  lease.state = static_cast<std::uint8_t>(state_);
  lease.state_tick = hal_.tick();
  lease.stop_ids = stops_.held();
  out_->add(OutputKind::lease, Name(), lease);
  lease_ns_ = now_ns_;
  lease_due_ = false;
}

// The newest SafeChunk goes out before each lease until the HAL has named it.
void Gate::Core::publish_safe_chunk(LiveClaim& claim) {
  const Released* release = claim.plan.current();
  if (release == nullptr) return;
  if (release->seen && !claim.repeat) return;
  claim.repeat = false;
  const ActionChunk& chunk = claim.plan.chunk_of(*release);
  safe_chunk_.session = chunk.session;
  safe_chunk_.epoch = chunk.epoch;
  safe_chunk_.claim_id = claim.id;
  safe_chunk_.source = claim.source;
  safe_chunk_.verdict_id = release->verdict_id;
  safe_chunk_.judged_tick = release->judged_tick;
  safe_chunk_.first_tick = release->first_tick;
  safe_chunk_.horizon = release->row_count;
  safe_chunk_.after = release->after;
  safe_chunk_.parts.clear();
  for (ActionPart part : chunk.parts) {
    const std::size_t width = mode_width(part.mode, limits_.joints.size());
    part.values = part.values.rows(release->first_row, release->row_count, width);
    (void)safe_chunk_.parts.push_back(part);  // as many places as the chunk has
  }
  out_->add(OutputKind::safe_chunk, claim.source, safe_chunk_);
}

Grant Gate::Core::grant_for(const LiveClaim& claim) const {
  Grant grant;
  grant.source = claim.source;
  grant.claim_id = claim.id;
  const std::uint64_t tick = hal_.tick();
  const std::uint64_t ahead =
      std::max<std::uint64_t>(2, (grant_ns + limits_.period_ns - 1) / limits_.period_ns);
  grant.until_tick = hal_.lockstep() ? tick : tick + std::min(ahead, UINT64_MAX - tick);
  grant.until_tick = std::min(grant.until_tick, claim.until_tick);
  const Released* release = claim.plan.current();
  if (release != nullptr && release->first_tick <= tick) {
    grant.decision = static_cast<std::uint8_t>(Decision::row);
    grant.verdict_id = release->verdict_id;
  } else if (claim.refused_tick == tick) {  // no state has tick 0
    grant.decision = static_cast<std::uint8_t>(Decision::hold);
    grant.verdict_id = claim.refused_verdict;
  } else if (hal_.lockstep() && !knows_act_before(claim)) {
    // Nothing that it could send may act in this tick: it holds without having sent anything.
    grant.decision = static_cast<std::uint8_t>(Decision::hold);
  }
  return grant;
}

Text Gate::Core::fix() const {
  switch (state_) {  // GCOVR_EXCL_BR_LINE: the enum has no further value
    case GateState::disarmed:
      return "fairlead arm";
    case GateState::stopped:
      return phrase("fairlead reset ", Hex{stops_.held()[0]});
    case GateState::latched:
      return phrase("fairlead reset ", Hex{latch_id_});
    case GateState::boot:
    case GateState::armed:
      break;
  }
  return {};
}

void Gate::Core::fill_status() {
  status_.robot = limits_.robot;
  status_.profile = limits_.profile;
  status_.session = hal_.session();
  status_.epoch = epoch_;
  status_.state = static_cast<std::uint8_t>(state_);
  status_.cause = cause_;
  status_.fix = fix();
  status_.latch_id = latch_id_;
  status_.stop_ids = stops_.held();
  status_.state_tick = hal_.tick();
  status_.lockstep_allowed = limits_.lockstep_allowed;
  status_.config_hash = limits_.config_hash;
  status_.robot_hash = limits_.robot_hash;
  status_.claims.clear();
  for (const LiveClaim& claim : claims_.places()) {
    if (!claim.live()) continue;
    ClaimInfo info{claim.source, claim.skill, claim.id, {}};
    for (const std::size_t part : claim.limits.parts)
      (void)info.parts.push_back(limits_.parts[part].name);
    (void)status_.claims.push_back(info);
  }
}

void Gate::Core::publish_status(OutputKind kind) {
  fill_status();
  status_.counters.clear();
  const auto add = [this](const Name& name, std::uint64_t value) {
    (void)status_.counters.push_back(Counter{name, value});  // 36 of 48 places
  };
  add("released", released_);
  add("truncated", truncated_);
  add("refused", refused_);
  add("copies", copies_);
  add("resets_refused", resets_refused_);
  add("stops_ignored", stops_ignored_);
  for (const std::uint32_t number : code::all)
    add(Name(code_name(number).view()), code_counts_[number]);
  out_->add(kind, Name(), status_);
}

}  // namespace fairlead
