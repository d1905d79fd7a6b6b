#include "decisions/replay.hpp"

namespace fairlead {

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
  if (record.output_count == 0) return true;
  RecordedOutputs outputs;
  for (const Output& output : outputs_->items())
    (void)outputs.push_back(
        RecordedOutput{output.kind, output.source.view(), outputs_->payload(output)});
  return digest_of(outputs) == record.digest;
}

GateState Replay::state() const { return gate_ == nullptr ? GateState::boot : gate_->state(); }

}  // namespace fairlead
