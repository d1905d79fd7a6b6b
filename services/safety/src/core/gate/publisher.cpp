#include "core/gate/publisher.hpp"

#include <algorithm>

namespace fairlead {
namespace {

constexpr std::uint64_t ms = 1'000'000;
constexpr std::uint64_t timer_period_ns = 5 * ms;  // the shell's longest pause between steps
constexpr std::uint64_t status_interval_ns = 500 * ms;

}  // namespace

void Publisher::finish() {
  Outputs& out = *outbox_.out;
  const std::uint64_t lease_interval_ns = limits_.protocol.lease_interval_ms * ms;
  if (outbox_.lease_due || outbox_.now_ns - lease_ns_ + timer_period_ns > lease_interval_ns)
    publish_lease();
  for (const Verdict& verdict : outbox_.verdicts)
    out.add(OutputKind::verdict, verdict.source, verdict);
  outbox_.verdicts.clear();
  if (outbox_.persist_latch_due) {
    out.add(OutputKind::persist_latch, Name(),
            LatchRecord{machine_.latch_id(), hal_.tick(), machine_.cause()});
    outbox_.persist_latch_due = false;
  }
  if (outbox_.clean_mark_due) {
    out.add(OutputKind::write_clean_mark);
    outbox_.clean_mark_due = false;
  }
  if (outbox_.status_due || outbox_.now_ns - status_ns_ >= status_interval_ns) {
    publish_status(OutputKind::status);
    status_ns_ = outbox_.now_ns;
    outbox_.status_due = false;
  }
}

void Publisher::publish_lease() {
  Lease& lease = machine_.leases().next();
  lease.grants.clear();
  for (LiveClaim& claim : claims_.places()) {
    if (!claim.live()) continue;
    publish_safe_chunk(claim);
    (void)lease.grants.push_back(grant_for(claim));  // as many places as claims
  }
  lease.session = hal_.session();
  lease.config_hash = limits_.config_hash;
  lease.state = static_cast<std::uint8_t>(machine_.state());
  lease.state_tick = hal_.tick();
  lease.stop_ids = machine_.stops();
  outbox_.out->add(OutputKind::lease, Name(), lease);
  lease_ns_ = outbox_.now_ns;
  outbox_.lease_due = false;
}

// The newest SafeChunk goes out before each lease until the HAL has named it, as the same bytes.
void Publisher::publish_safe_chunk(LiveClaim& claim) {
  const Released* release = claim.plan.current();
  if (release == nullptr || (release->seen && !claim.repeat)) return;
  claim.repeat = false;
  outbox_.out->add(OutputKind::safe_chunk, claim.safe_chunk.source, claim.safe_chunk);
}

Grant Publisher::grant_for(const LiveClaim& claim) const {
  Grant grant;
  grant.source = claim.source;
  grant.claim_id = claim.id;
  const std::uint64_t tick = hal_.tick();
  grant.until_tick = std::min(hal_.last_granted_tick(), claim.until_tick);
  const Released* release = claim.plan.current();
  if (release != nullptr && release->first_tick <= tick) {
    grant.decision = static_cast<std::uint8_t>(Decision::row);
    grant.verdict_id = release->verdict_id;
  } else if (claim.refused_tick == tick) {  // no state has tick 0
    grant.decision = static_cast<std::uint8_t>(Decision::hold);
    grant.verdict_id = claim.refused_verdict;
  } else if (hal_.lockstep() && !rows_.knows_act_before(claim)) {
    // Nothing that it could send may act in this tick: it holds without having sent anything.
    grant.decision = static_cast<std::uint8_t>(Decision::hold);
  }
  return grant;
}

void Publisher::fill_status() {
  status_.robot = limits_.robot;
  status_.profile = limits_.profile;
  status_.session = hal_.session();
  status_.epoch = machine_.epoch();
  status_.state = static_cast<std::uint8_t>(machine_.state());
  status_.cause = machine_.cause();
  status_.fix = machine_.fix();
  status_.latch_id = machine_.latch_id();
  status_.stop_ids = machine_.stops();
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

void Publisher::publish_status(OutputKind kind) {
  fill_status();
  status_.counters.clear();
  const auto add = [this](const Name& name, std::uint64_t value) {
    (void)status_.counters.push_back(Counter{name, value});  // 36 of 48 places
  };
  const Counters& counters = outbox_.counters;
  add("released", counters.released);
  add("truncated", counters.truncated);
  add("refused", counters.refused);
  add("copies", counters.copies);
  add("resets_refused", counters.resets_refused);
  add("stops_ignored", counters.stops_ignored);
  for (const std::uint32_t number : code::all)
    add(Name(code_name(number).view()), counters.codes[number]);
  outbox_.out->add(kind, Name(), status_);
}

}  // namespace fairlead
