#include "decisions/log_story.hpp"

#include <utility>

#include "decisions/verdict_document.hpp"

namespace fairlead {
namespace {

using nlohmann::json;

constexpr std::size_t kRemembered = 256;  // chunks that a verdict may still be about

const char* state_name(std::uint8_t state) {
  constexpr std::array<const char*, 5> names = {"boot", "disarmed", "armed", "stopped", "latched"};
  return state < names.size() ? names[state] : "unknown";
}

bool is_ended(std::uint8_t state) {
  return state == static_cast<std::uint8_t>(GateState::stopped) ||
         state == static_cast<std::uint8_t>(GateState::latched);
}

}  // namespace

std::vector<Moment> LogStory::take(const Record& record) {
  std::vector<Moment> decisions;
  if (record.type == RecordType::gap || record.type == RecordType::end) return decisions;
  ++steps_;
  if (record.type == RecordType::step) take_event(record.event);
  take_claim(record);
  for (const RecordedOutput& output : record.outputs) {
    Verdict verdict;
    if (output.kind == OutputKind::status && take_status(output.payload)) {
      Moment moment;
      moment.is_verdict = false;
      moment.status = status_;
      moment.step = steps_;
      moment.tick = tick_;
      decisions.push_back(moment);
    }
    if (output.kind != OutputKind::verdict || decode(output.payload, verdict) != FrameFault::none ||
        verdict.verdict_id <= newest_verdict_)
      continue;
    newest_verdict_ = verdict.verdict_id;
    decisions.push_back(moment_of(record, verdict));
  }
  return decisions;
}

void LogStory::take_event(const Event& event) {
  if (event.kind == EventKind::joint_state) {
    JointState state;
    if (decode(event.payload, state) != FrameFault::none) return;
    tick_ = state.tick;
    measured_.resize(state.positions.size());
    for (std::size_t i = 0; i < measured_.size(); ++i) measured_[i] = state.positions[i];
  } else if (event.kind == EventKind::candidate) {
    remember_chunk(event);
  }
}

void LogStory::take_claim(const Record& record) {
  if (record.type != RecordType::step || record.event.kind != EventKind::claim) return;
  Claim claim;
  if (decode(record.event.payload, claim) != FrameFault::none) return;
  for (const RecordedOutput& output : record.outputs) {
    ClaimReply reply;
    if (output.kind == OutputKind::reply && decode(output.payload, reply) == FrameFault::none)
      skills_[reply.claim_id] = std::string(claim.skill.view());
  }
}

void LogStory::remember_chunk(const Event& event) {
  if (decode(event.payload, chunk_) != FrameFault::none) return;
  json parts = json::array();
  for (const ActionPart& part : chunk_.parts) {
    const bool known = part.part < limits_.parts.size();
    parts.push_back({{"part", known ? std::string(limits_.parts[part.part].name.view()) : "?"},
                     {"mode", mode_name(part.mode)},
                     {"frame", part.frame_id.view()}});
  }
  const auto skill = skills_.find(chunk_.claim_id);
  Remembered chunk{
      std::string(event.source), chunk_.seq, chunk_.start_tick, chunk_.horizon, false, {}};
  chunk.chunk = {{"goal_id", hex_id(chunk_.goal_id)},
                 {"skill", skill == skills_.end() ? "" : skill->second},
                 {"obs_tick", chunk_.obs_tick},
                 {"start_tick", chunk_.start_tick},
                 {"rows", chunk_.horizon},
                 {"parts", parts}};
  chunks_.push_back(std::move(chunk));
  if (chunks_.size() > kRemembered) chunks_.pop_front();
}

Moment LogStory::moment_of(const Record& record, const Verdict& verdict) {
  Moment moment;
  moment.step = steps_;
  moment.tick = tick_;
  moment.verdict = verdict;
  moment.of_candidate =
      record.type == RecordType::step && record.event.kind == EventKind::candidate;
  for (auto chunk = chunks_.rbegin(); chunk != chunks_.rend(); ++chunk) {
    if (chunk->seq != verdict.seq || chunk->source != verdict.source.view()) continue;
    moment.has_chunk = true;
    moment.again = std::exchange(chunk->has_verdict, true);
    moment.start_tick = chunk->start_tick;
    moment.horizon = chunk->horizon;
    moment.chunk = chunk->chunk;
    for (const json& part : chunk->chunk.at("parts"))
      if (part.at("part") == verdict.part.view()) moment.chunk["mode"] = part.at("mode");
    break;
  }
  return moment;
}

// True if the gate has stopped or latched just now, or gives another reason for it.
bool LogStory::take_status(Bytes payload) {
  if (decode(payload, room_) != FrameFault::none) return false;
  json stops = json::array();
  for (const std::uint64_t id : room_.stop_ids) stops.push_back(hex_id(id));
  const std::string cause(room_.cause.view());
  const bool is_new = is_ended(room_.state) && (room_.state != state_ || status_["cause"] != cause);
  state_ = room_.state;
  status_ = {{"state", state_name(room_.state)},
             {"cause", cause},
             {"fix", room_.fix.view()},
             {"stop_ids", stops},
             {"latch_id", hex_id(room_.latch_id)}};
  return is_new;
}

}  // namespace fairlead
