#include "decisions/what_if.hpp"

#include <algorithm>

namespace fairlead {
namespace {

std::string_view text_of(Bytes payload) {
  return {reinterpret_cast<const char*>(payload.data()), payload.size()};
}

bool has_log(const Record& record, std::string_view text) {
  for (const RecordedOutput& output : record.outputs)
    if (output.kind == OutputKind::log && text_of(output.payload) == text) return true;
  return false;
}

bool has_refusal(const Record& record) {
  for (const RecordedOutput& output : record.outputs)
    if (output.kind == OutputKind::refusal) return true;
  return false;
}

bool is_same_outcome(const Verdict& a, const Verdict& b) {
  return a.outcome == b.outcome && a.code == b.code && a.released_first == b.released_first &&
         a.released_last == b.released_last;
}

// G002 to G004: not the rows, but who sends them and when.
bool concerns_identity(const Verdict& verdict) { return verdict.code >= 2 && verdict.code <= 4; }

}  // namespace

void WhatIf::feed(const Record& record, std::uint64_t tick) {
  Record changed = record;
  if (record.type == RecordType::step && record.event.kind == EventKind::joint_state)
    changed.event.payload = as_it_would_have_acted(record.event.payload);
  replay_.feed(changed);
  note_news(record, tick);
  pair_verdicts(record, tick);
}

Bytes WhatIf::as_it_would_have_acted(Bytes frame) {
  if (decode(frame, state_) != FrameFault::none) return frame;
  for (Acted& acted : state_.acted) {
    if (acted.hold != static_cast<std::uint8_t>(Hold::none)) continue;
    const auto found = matches_.find(acted.verdict_id);
    const Match match = found == matches_.end() ? Match() : found->second;
    const std::uint64_t tick = match.recorded_first + acted.row;
    if (match.verdict_id != 0 && tick >= match.released_first && tick <= match.released_last) {
      acted.verdict_id = match.verdict_id;
      acted.row = static_cast<std::uint32_t>(tick - match.released_first);
    } else {
      acted = Acted{static_cast<std::uint8_t>(Hold::refused), 0, 0};
    }
  }
  const std::size_t size = encode(state_, frame_);
  return size == 0 ? frame : Bytes(frame_).first(size);
}

void WhatIf::pair_verdicts(const Record& record, std::uint64_t tick) {
  std::vector<Verdict> others;
  for (const Output& output : replay_.outputs().items()) {
    Verdict verdict;
    if (output.kind == OutputKind::verdict &&
        decode(replay_.outputs().payload(output), verdict) == FrameFault::none)
      others.push_back(verdict);
  }
  for (const RecordedOutput& output : record.outputs) {
    Verdict recorded;
    if (output.kind != OutputKind::verdict ||
        decode(output.payload, recorded) != FrameFault::none ||
        matches_.contains(recorded.verdict_id))
      continue;
    const auto other = std::find_if(others.begin(), others.end(), [&recorded](const Verdict& v) {
      return v.source == recorded.source && v.seq == recorded.seq;
    });
    compare(recorded, other == others.end() ? nullptr : &*other, tick);
    if (other != others.end()) others.erase(other);
  }
}

void WhatIf::compare(const Verdict& recorded, const Verdict* instead, std::uint64_t tick) {
  Match match;
  match.recorded_first = recorded.released_first;
  if (instead != nullptr && instead->outcome != static_cast<std::uint8_t>(Outcome::refused)) {
    match.verdict_id = instead->verdict_id;
    match.released_first = instead->released_first;
    match.released_last = instead->released_last;
  }
  matches_[recorded.verdict_id] = match;
  if (instead == nullptr || (concerns_identity(*instead) && !concerns_identity(recorded))) {
    ++unjudged_;
  } else if (!is_same_outcome(recorded, *instead)) {
    changed_.push_back(ChangedVerdict{tick, recorded, *instead});
  }
}

void WhatIf::note_news(const Record& record, std::uint64_t tick) {
  for (const Output& output : replay_.outputs().items()) {
    const Bytes payload = replay_.outputs().payload(output);
    Refusal refusal;
    std::string news;
    if (output.kind == OutputKind::log) {
      const std::string_view text = text_of(payload);
      const bool ends_motion = text.starts_with("stopped: ") || text.starts_with("latched: ");
      if (ends_motion && !has_log(record, text)) news = text;
    } else if (output.kind == OutputKind::refusal && !has_refusal(record) &&
               decode(payload, refusal) == FrameFault::none) {
      news = "refused a query: " + std::string(refusal.reason.view());
    }
    if (!news.empty()) notes_.push_back("tick " + std::to_string(tick) + ": " + news);
  }
}

}  // namespace fairlead
