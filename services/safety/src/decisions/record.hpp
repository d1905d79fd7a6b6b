// One record of a decision log: what the core was given in a step and what came out of it.
//
// shared/fairlead_tools/record/run_log.py has the layout byte by byte. The same layout serves in
// memory, where a record has every output, and in the file, where it has a digest of all and some
// in full.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "fairlead_safety/gate.hpp"

namespace fairlead {

enum class RecordType : std::uint8_t {
  header = 1,  // JSON: robot, profile, configuration text, which gate
  boot = 2,
  step = 3,
  timer = 4,  // a step of the timer that drew no id and put nothing out
  gap = 5,    // so many records were lost here
  end = 6,    // why the log ends; without it the gate ended without asking, or still runs
};

/// First half of a SHA-256.
using Digest = std::array<std::uint8_t, 16>;

/// As many as one step can put out.
inline constexpr std::size_t max_outputs =
    std::remove_cvref_t<decltype(std::declval<const Outputs&>().items())>::capacity;
inline constexpr std::size_t max_drawn = 64;  // ids that one step can draw

/// Ids drawn since the record before.
using IdList = FixedVec<std::uint64_t, max_drawn>;

struct RecordedOutput {
  OutputKind kind = OutputKind::log;
  std::string_view source;
  Bytes payload;
};

using RecordedOutputs = FixedVec<RecordedOutput, max_outputs>;

/// Views of bytes that belong to whoever made the record.
struct Record {
  RecordType type = RecordType::timer;
  std::uint64_t now_ns = 0;       // boot, step, timer
  BootInfo boot;                  // boot
  Event event;                    // step, timer
  IdList ids;                     // boot, step
  std::uint8_t output_count = 0;  // boot, step: how many the step had
  Digest digest{};                // of all of them; zero in memory
  RecordedOutputs outputs;
  std::uint64_t lost = 0;  // gap
  std::string_view text;   // header, end
};

/// The core's copies of what a step put out.
Record boot_record(std::uint64_t now_ns, const BootInfo& info, std::span<const std::uint64_t> ids,
                   const Outputs& outputs);
Record step_record(std::uint64_t now_ns, const Event& event, std::span<const std::uint64_t> ids,
                   const Outputs& outputs);

/// More bytes than `encode_record` can need.
std::size_t room_for(const Record& record);

/// The record's body; returns its size. `buffer` has `room_for(record)`.
std::size_t encode_record(const Record& record, std::span<std::uint8_t> buffer);

/// Reads a body; false if it is not exactly one. The record's views point into `body`.
bool decode_record(RecordType type, Bytes body, Record& record);

/// What replay compares: kind, source and every byte of each output, in order.
Digest digest_of(const RecordedOutputs& outputs);

}  // namespace fairlead
