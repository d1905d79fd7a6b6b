// A decision log written step by step, by a tool that has no clock to keep up with.
//
// The gate's own process has `DecisionLog`, whose disk no decision waits for.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "decisions/decision_log.hpp"
#include "decisions/log_file.hpp"

namespace fairlead {

class StepLog {
 public:
  /// Begins a log in `folder` with the header of `limits`, read from `config_file`; "" as folder:
  /// none is kept. Throws ConfigRefused if it cannot be written.
  StepLog(const std::filesystem::path& folder, const Limits& limits,
          const std::string& config_file);

  void boot(std::uint64_t now_ns, const BootInfo& info, DrawnIds& ids, const Outputs& outputs);
  void step(std::uint64_t now_ns, const Event& event, DrawnIds& ids, const Outputs& outputs);

 private:
  void write(Record record, DrawnIds& ids);
  void append(RecordType type, Bytes body);

  std::unique_ptr<LogFile> file_;
  std::vector<std::uint8_t> body_;
};

}  // namespace fairlead
