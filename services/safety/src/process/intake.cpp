#include "process/intake.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

void Budget::refill(std::uint64_t now_ns) {
  if (filled_ns_ != 0)
    left_ = std::min(burst_, left_ + per_second_ * static_cast<double>(now_ns - filled_ns_) * 1e-9);
  filled_ns_ = now_ns;
}

void Intake::expect(const std::string& source, std::uint64_t session, std::uint64_t epoch,
                    std::uint64_t claim_id, const FixedVec<Grant, max_claims>& live) {
  const std::lock_guard lock(mutex_);
  std::erase_if(claims_, [epoch](const auto& item) { return item.second.epoch != epoch; });
  for (auto& [other, claimed] : claims_) std::erase(claimed.claim_ids, claim_id);  // handed over
  Claimed& claimed = claims_[source];
  claimed.session = session;
  claimed.epoch = epoch;
  std::vector<std::uint64_t>& ids = claimed.claim_ids;
  const auto ended = std::ranges::find_if(ids, [&](std::uint64_t id) {
    return std::ranges::find(live, id, &Grant::claim_id) == live.end();
  });
  if (ids.size() == max_claims) ids.erase(ended != ids.end() ? ended : ids.begin());
  ids.push_back(claim_id);
}

void Intake::forget(const std::string& source) {
  const std::lock_guard lock(mutex_);
  claims_.erase(source);
}

Intake::Claimed* Intake::claim_of(std::string_view source, Bytes frame) {
  ChunkHead head;
  if (!read_chunk_head(frame, head)) return nullptr;
  const auto found = claims_.find(source);
  if (found == claims_.end()) return nullptr;
  Claimed& claim = found->second;
  const bool is_its = claim.epoch == head.epoch && claim.session == head.session &&
                      std::ranges::find(claim.claim_ids, head.claim_id) != claim.claim_ids.end();
  return is_its ? &claim : nullptr;
}

bool Intake::admits(std::string_view source, Bytes frame, std::uint64_t now_ns) {
  const std::lock_guard lock(mutex_);
  now_ns_ = std::max(now_ns_, now_ns);  // threads come in any order
  Claimed* claim = claim_of(source, frame);
  if (claim == nullptr) {
    const auto size = static_cast<double>(frame.size());
    stranger_frames_.refill(now_ns_);
    stranger_bytes_.refill(now_ns_);
    if (!stranger_frames_.has(1.0) || !stranger_bytes_.has(size)) {
      ++left_out_.strangers;
      return false;
    }
    stranger_frames_.take(1.0);
    stranger_bytes_.take(size);
    return true;
  }
  const std::string_view text(reinterpret_cast<const char*>(frame.data()), frame.size());
  const bool is_copy = claim->newest == text;
  Budget& budget = is_copy ? claim->copies : claim->frames;
  budget.refill(now_ns_);
  if (!budget.has(1.0)) {
    ++(is_copy ? left_out_.copies : left_out_.excess);
    return false;
  }
  budget.take(1.0);
  if (!is_copy) claim->newest = text;
  return true;
}

Intake::LeftOut Intake::take_left_out() {
  const std::lock_guard lock(mutex_);
  return std::exchange(left_out_, LeftOut{});
}

}  // namespace fairlead
