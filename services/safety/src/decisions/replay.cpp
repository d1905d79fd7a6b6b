#include "decisions/replay.hpp"

#include <algorithm>

namespace fairlead {
namespace {

bool same(const RecordedOutput& one, const RecordedOutput& other) {
  return one.kind == other.kind && one.source == other.source &&
         std::ranges::equal(one.payload, other.payload);
}

// Those that are kept in full are what people are shown.
bool has_in_order(const RecordedOutputs& all, const RecordedOutputs& kept) {
  const auto* next = all.begin();
  for (const RecordedOutput& output : kept) {
    next =
        std::find_if(next, all.end(), [&](const RecordedOutput& one) { return same(one, output); });
    if (next == all.end()) return false;
    ++next;
  }
  return true;
}

}  // namespace

void ReplayedIds::offer(const IdList& ids) {
  offered_ = ids;
  next_ = 0;
  made_up_ = false;
}

std::uint64_t ReplayedIds::next_id() {
  if (next_ < offered_.size()) return offered_[next_++];
  made_up_ = true;
  constexpr std::uint64_t unlike_a_drawn_one = 0xFA17'0000'0000'0000;
  return unlike_a_drawn_one + ++last_made_up_;
}

void Replay::feed(const Record& record) {
  ids_.offer(record.ids);
  switch (record.type) {
    case RecordType::boot:
      gate_ = std::make_unique<Gate>(limits_, ids_);
      gate_->boot(record.now_ns, record.boot, *outputs_);
      break;
    case RecordType::step:
    case RecordType::timer:
      if (gate_ != nullptr) gate_->step(record.now_ns, record.event, *outputs_);
      break;
    case RecordType::header:
    case RecordType::gap:
    case RecordType::end:
      outputs_->clear();
      break;
  }
}

bool Replay::same_as(const Record& record) const {
  if (outputs_->items().size() != record.output_count || !ids_.exact()) return false;
  if (record.output_count == 0) return record.outputs.empty();
  RecordedOutputs outputs;
  for (const Output& output : outputs_->items())
    (void)outputs.push_back(
        RecordedOutput{output.kind, output.source.view(), outputs_->payload(output)});
  return digest_of(outputs) == record.digest && has_in_order(outputs, record.outputs);
}

GateState Replay::state() const { return gate_ == nullptr ? GateState::boot : gate_->state(); }

}  // namespace fairlead
