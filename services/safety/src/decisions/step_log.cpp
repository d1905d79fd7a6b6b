#include "decisions/step_log.hpp"

#include "decisions/header.hpp"
#include "process/refusal.hpp"

namespace fairlead {
namespace {

constexpr std::size_t kKeptFiles = 10'000;

RecordedOutputs verdicts_and_replies(const RecordedOutputs& outputs) {
  RecordedOutputs kept;
  for (const RecordedOutput& output : outputs)
    if (output.kind == OutputKind::verdict || output.kind == OutputKind::reply ||
        output.kind == OutputKind::refusal)
      (void)kept.push_back(output);
  return kept;
}

}  // namespace

StepLog::StepLog(const std::filesystem::path& folder, const Limits& limits,
                 const std::string& config_file) {
  if (folder.empty()) return;
  std::string fault;
  file_ = std::make_unique<LogFile>(folder, kKeptFiles, UINT64_MAX, fault);
  if (!fault.empty()) throw ConfigRefused("decision log: " + fault);
  const std::string header = make_header(limits, config_file);
  append(RecordType::header,
         Bytes(reinterpret_cast<const std::uint8_t*>(header.data()), header.size()));
}

void StepLog::boot(std::uint64_t now_ns, const BootInfo& info, DrawnIds& ids,
                   const Outputs& outputs) {
  write(boot_record(now_ns, info, ids.drawn(), outputs), ids);
}

void StepLog::step(std::uint64_t now_ns, const Event& event, DrawnIds& ids,
                   const Outputs& outputs) {
  write(step_record(now_ns, event, ids.drawn(), outputs), ids);
}

void StepLog::write(Record record, DrawnIds& ids) {
  ids.forget();
  if (file_ == nullptr) return;
  if (record.output_count > 0) {
    record.digest = digest_of(record.outputs);
    record.outputs = verdicts_and_replies(record.outputs);
  }
  body_.resize(room_for(record));
  append(record.type, Bytes(body_).first(encode_record(record, body_)));
}

void StepLog::append(RecordType type, Bytes body) {
  const std::string fault = file_->append(type, body);
  if (!fault.empty()) throw ConfigRefused("decision log: " + fault);
}

}  // namespace fairlead
