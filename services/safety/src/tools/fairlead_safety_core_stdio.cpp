// The real gate core behind stdin and stdout, so that a test can drive it step by step with
// its own time and its own losses. No Zenoh, no clock, no disk.
//
//   fairlead-safety-core-stdio --config robots/R/gate.sim.json [--seed N] [--decision-log DIR]
//
// Ids come from a generator seeded with N (default 1): the same input gives the same output.
// Every event is recorded in DIR, if one is named, as the gate does: docs/decision-log.md.
// Everything is little-endian; one answer per event, flushed at once; end of input ends it.
//
//   event:  u8 kind, u64 now_ns, u32 length + source, u32 length + payload
//   answer: u32 count, then per output: u8 kind, u32 length + source, u32 length + payload
//
// Kinds are those of EventKind (gate.hpp) and OutputKind (outputs.hpp). The first event must
// be kind 255, boot: its payload is u8 first_start, u8 clean_mark, then the latch record (the
// payload of an earlier persist_latch) or nothing. Every further boot puts a new gate in the
// place of the present one, whose time starts anew; ids go on.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "config/config_loader.hpp"
#include "decisions/step_log.hpp"
#include "fairlead_safety/gate.hpp"
#include "process/refusal.hpp"

namespace {

using fairlead::Bytes;

constexpr std::uint8_t boot_kind = 255;

// splitmix64: well spread ids from consecutive seeds.
class SeededIds : public fairlead::IdSource {
 public:
  explicit SeededIds(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next_id() override {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31U);
  }

 private:
  std::uint64_t state_;
};

template <class Number>
bool read_number(Number& value) {
  return std::fread(&value, sizeof value, 1, stdin) == 1;
}

bool read_bytes(std::vector<std::uint8_t>& bytes) {
  std::uint32_t size = 0;
  if (!read_number(size)) return false;
  bytes.resize(size);
  return size == 0 || std::fread(bytes.data(), size, 1, stdin) == 1;
}

template <class Number>
void write_number(Number value) {
  std::fwrite(&value, sizeof value, 1, stdout);
}

void write_bytes(const void* data, std::size_t size) {
  write_number(static_cast<std::uint32_t>(size));
  if (size > 0) std::fwrite(data, size, 1, stdout);
}

void answer(const fairlead::Outputs& outputs) {
  write_number(static_cast<std::uint32_t>(outputs.items().size()));
  for (const fairlead::Output& output : outputs.items()) {
    write_number(static_cast<std::uint8_t>(output.kind));
    write_bytes(output.source.view().data(), output.source.size());
    const Bytes payload = outputs.payload(output);
    write_bytes(payload.data(), payload.size());
  }
  std::fflush(stdout);
}

fairlead::BootInfo boot_info(const std::vector<std::uint8_t>& payload) {
  fairlead::BootInfo info;
  if (payload.size() < 2)
    throw fairlead::ConfigRefused("boot: expected first_start and clean_mark");
  info.first_start = payload[0] != 0;
  info.clean_mark = payload[1] != 0;
  info.latch = Bytes(payload).subspan(2);
  return info;
}

void run(const fairlead::Limits& limits, std::uint64_t seed, fairlead::StepLog& log) {
  SeededIds seeded(seed);
  fairlead::DrawnIds ids(seeded);
  auto gate = std::make_unique<fairlead::Gate>(limits, ids);
  ids.forget();  // the first boot puts another in its place
  const auto outputs = std::make_unique<fairlead::Outputs>();
  std::uint8_t kind = 0;
  std::uint64_t now_ns = 0;
  std::vector<std::uint8_t> source;
  std::vector<std::uint8_t> payload;
  while (read_number(kind) && read_number(now_ns) && read_bytes(source) && read_bytes(payload)) {
    if (kind == boot_kind) {
      gate = std::make_unique<fairlead::Gate>(limits, ids);
      const fairlead::BootInfo info = boot_info(payload);
      gate->boot(now_ns, info, *outputs);
      log.boot(now_ns, info, ids, *outputs);
    } else {
      fairlead::Event event;
      event.kind = static_cast<fairlead::EventKind>(kind);
      event.source = {reinterpret_cast<const char*>(source.data()), source.size()};
      event.payload = payload;
      event.received_ns = now_ns;
      gate->step(now_ns, event, *outputs);
      log.step(now_ns, event, ids, *outputs);
    }
    answer(*outputs);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string config;
  std::string log_folder;
  std::uint64_t seed = 1;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--config") == 0) config = argv[i + 1];
    if (std::strcmp(argv[i], "--decision-log") == 0) log_folder = argv[i + 1];
    if (std::strcmp(argv[i], "--seed") == 0) seed = std::strtoull(argv[i + 1], nullptr, 10);
  }
  try {
    const auto limits = fairlead::load_limits(config);
    fairlead::StepLog log(log_folder, *limits, config);
    run(*limits, seed, log);
  } catch (const std::exception& refusal) {
    std::fprintf(stderr, "ERROR fairlead-safety-core-stdio: %s\n", refusal.what());
    return 2;
  }
  return 0;
}
