#include "decisions/decision_log.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "decisions/log_file.hpp"
#include "decisions/record_ring.hpp"
#include "fairlead_safety/query_messages.hpp"

namespace fairlead {
namespace {

constexpr std::size_t kRingBytes = std::size_t{8} << 20U;  // about a minute of a stuck disk
constexpr auto kPause = std::chrono::milliseconds(50);     // a killed gate's log misses this much
constexpr auto kRetryAfter = std::chrono::seconds(1);
constexpr auto kPatience = std::chrono::milliseconds(500);

// A file is full at an eighth of what all of them may have: little goes at a time.
constexpr std::uint64_t files_in_quota = 8;

Bytes text_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// What a status says beside its counters and its tick.
struct StatusNews {
  std::uint64_t session = 0, epoch = 0, latch_id = 0;
  std::uint8_t state = 0;
  Text cause;
  FixedVec<std::uint64_t, max_stops> stop_ids;
  friend bool operator==(const StatusNews&, const StatusNews&) = default;
};

}  // namespace

std::uint64_t DrawnIds::next_id() {
  const std::uint64_t id = ids_.next_id();
  if (!drawn_.push_back(id)) overflowed_ = true;
  return id;
}

void DrawnIds::forget() {
  drawn_.clear();
  overflowed_ = false;
}

/// The writing side: from the ring to the file, on its own thread.
class DecisionLog::Disk {
 public:
  Disk(const DecisionLogPlace& place, const std::string& header, LogWriter& log)
      : place_(place), header_(header), log_(log) {
    fault_ = begin_file();
  }

  const std::string& fault() const { return fault_; }
  std::string path() const { return file_->path().string(); }
  RecordRing& ring() { return ring_; }

  void run();
  /// Ask `run` to finish; true if it did in time.
  bool finish();

 private:
  void drain();
  void write(Bytes raw);
  bool append(RecordType type, Bytes body);
  std::string begin_file();
  void end_file();
  std::string write_gap();
  void keep_what_is_read(Record& record);
  bool is_news(Bytes status);
  void say(const std::string& text);

  const DecisionLogPlace place_;
  const std::string header_;
  LogWriter& log_;
  std::string fault_;  // of the newest attempt to write
  std::unique_ptr<LogFile> file_;
  std::uint64_t written_ = 0;  // records in this file
  RecordRing ring_{kRingBytes};
  std::uint64_t lost_ = 0;  // not yet in the file
  std::chrono::steady_clock::time_point retry_at_;
  std::vector<std::uint8_t> body_;
  std::vector<std::uint8_t> gap_;
  StatusNews last_status_;
  GateStatus status_;

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  bool stopping_ = false, finished_ = false, abandoned_ = false;
};

void DecisionLog::Disk::run() {
  std::unique_lock lock(mutex_);
  while (!finished_) {
    const bool last = changed_.wait_for(lock, kPause, [this] { return stopping_; });
    lock.unlock();
    drain();
    if (last) append(RecordType::end, text_bytes("the gate ended on request"));
    lock.lock();
    finished_ = last;
  }
  changed_.notify_all();
}

bool DecisionLog::Disk::finish() {
  std::unique_lock lock(mutex_);
  stopping_ = true;
  changed_.notify_all();
  const bool done = changed_.wait_for(lock, kPatience, [this] { return finished_; });
  abandoned_ = !done;
  return done;
}

void DecisionLog::Disk::drain() {
  while (true) {
    const Bytes raw = ring_.front();
    if (raw.empty()) return;
    write(raw);
    ring_.pop();
  }
}

// In the ring a record has all its outputs; the file gets their digest and those people read.
void DecisionLog::Disk::write(Bytes raw) {
  Record record;
  if (!decode_record(static_cast<RecordType>(raw[0]), raw.subspan(1), record)) return;
  if (record.type == RecordType::gap) {
    lost_ += record.lost;
    return;
  }
  if (record.output_count > 0) {
    record.digest = digest_of(record.outputs);
    keep_what_is_read(record);
  }
  body_.resize(room_for(record));
  const std::size_t size = encode_record(record, body_);
  if (!append(record.type, Bytes(body_).first(size))) ++lost_;
}

bool DecisionLog::Disk::append(RecordType type, Bytes body) {
  if (!fault_.empty() && std::chrono::steady_clock::now() < retry_at_) return false;
  if (file_ != nullptr && type != RecordType::end &&
      file_->size() + body.size() > place_.max_bytes / files_in_quota)
    end_file();
  std::string fault = file_ == nullptr ? begin_file() : "";
  if (fault.empty()) fault = write_gap();
  if (fault.empty()) fault = file_->append(type, body);
  if (fault.empty() != fault_.empty()) {
    say(fault.empty() ? "can be written again; the log names the gap"
                      : fault + "; decisions are not recorded until it can be");
  }
  fault_ = std::move(fault);
  if (!fault_.empty()) retry_at_ = std::chrono::steady_clock::now() + kRetryAfter;
  if (fault_.empty()) ++written_;
  return fault_.empty();
}

// The oldest files go first, so that there is room for this one.
std::string DecisionLog::Disk::begin_file() {
  std::string fault;
  const std::uint64_t quota = place_.max_bytes - place_.max_bytes / files_in_quota;
  auto file = std::make_unique<LogFile>(place_.folder, place_.files, quota, fault);
  if (fault.empty()) fault = file->append(RecordType::header, text_bytes(header_));
  std::error_code error;
  if (fault.empty())
    file_ = std::move(file);
  else
    std::filesystem::remove(file->path(), error);  // a file without a header is none
  return fault;
}

// A replay begins with its run: a later file's first record says how many came before it.
void DecisionLog::Disk::end_file() {
  (void)file_->append(RecordType::end, text_bytes("the log goes on in the next file"));
  file_.reset();
  lost_ += std::exchange(written_, 0);
}

std::string DecisionLog::Disk::write_gap() {
  if (lost_ == 0) return "";
  Record gap;
  gap.type = RecordType::gap;
  gap.lost = lost_;
  gap_.resize(room_for(gap));
  const std::size_t size = encode_record(gap, gap_);
  std::string fault = file_->append(RecordType::gap, Bytes(gap_).first(size));
  if (fault.empty()) lost_ = 0;
  return fault;
}

// Leases and released rows are what replay gives again; a status only if it says something new.
void DecisionLog::Disk::keep_what_is_read(Record& record) {
  RecordedOutputs kept;
  for (const RecordedOutput& output : record.outputs) {
    const bool repeated = output.kind == OutputKind::lease ||
                          output.kind == OutputKind::safe_chunk ||
                          (output.kind == OutputKind::status && !is_news(output.payload));
    if (!repeated) (void)kept.push_back(output);
  }
  record.outputs = kept;
}

bool DecisionLog::Disk::is_news(Bytes status) {
  if (decode(status, status_) != FrameFault::none) return true;
  const StatusNews news{status_.session, status_.epoch, status_.latch_id,
                        status_.state,   status_.cause, status_.stop_ids};
  const bool is_new = !(news == last_status_);
  last_status_ = news;
  return is_new;
}

void DecisionLog::Disk::say(const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (!abandoned_) log_.warning("decision log: " + text);
}

DecisionLog::DecisionLog(const DecisionLogPlace& place, std::string header, LogWriter& log) {
  if (place.folder.empty()) return;
  auto disk = std::make_shared<Disk>(place, header, log);
  if (!disk->fault().empty()) {
    log.warning("decision log: " + disk->fault() + "; nothing is recorded in this run");
    return;
  }
  log.info("decisions are recorded in " + disk->path());
  disk_ = std::move(disk);
  writer_ = std::thread([kept = disk_] { kept->run(); });
}

DecisionLog::~DecisionLog() {
  if (disk_ == nullptr) return;
  if (disk_->finish()) {
    writer_.join();
  } else {
    writer_.detach();  // stuck in a write; the process is about to end
  }
}

void DecisionLog::boot(std::uint64_t now_ns, const BootInfo& info, DrawnIds& ids,
                       const Outputs& outputs) {
  record(boot_record(now_ns, info, ids.drawn(), outputs), ids);
}

void DecisionLog::step(std::uint64_t now_ns, const Event& event, DrawnIds& ids,
                       const Outputs& outputs) {
  record(step_record(now_ns, event, ids.drawn(), outputs), ids);
}

void DecisionLog::record(const Record& record, DrawnIds& ids) {
  const bool replayable = !ids.overflowed();
  ids.forget();
  if (disk_ == nullptr) return;
  RecordRing& ring = disk_->ring();
  if (lost_ > 0) {  // before anything else, so that the gap stands where it is
    Record gap;
    gap.type = RecordType::gap;
    gap.lost = lost_;
    const std::span<std::uint8_t> room = ring.reserve(1 + room_for(gap));
    if (room.empty()) {
      ++lost_;
      return;
    }
    room[0] = static_cast<std::uint8_t>(gap.type);
    ring.commit(1 + encode_record(gap, room.subspan(1)));
    lost_ = 0;
  }
  const std::span<std::uint8_t> room =
      replayable ? ring.reserve(1 + room_for(record)) : std::span<std::uint8_t>();
  if (room.empty()) {
    ++lost_;
    return;
  }
  room[0] = static_cast<std::uint8_t>(record.type);
  ring.commit(1 + encode_record(record, room.subspan(1)));
}

}  // namespace fairlead
