// Timing of short calls: batches of all cases in turn, and of each the quickest one.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <string>

namespace fairlead::bench {

/// Something to be timed. Its name says what one call is.
class Case {
 public:
  explicit Case(std::string name) : name_(std::move(name)) {}
  virtual ~Case() = default;
  Case(const Case&) = delete;
  Case& operator=(const Case&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// The loop is inside, so that no virtual call is timed.
  virtual void run(std::size_t calls) = 0;

 private:
  std::string name_;
};

inline std::uint64_t now_ns() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                        std::chrono::steady_clock::now().time_since_epoch())
                                        .count());
}

/// Processor time of this thread.
inline std::uint64_t busy_ns() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000U +
         static_cast<std::uint64_t>(time.tv_nsec);
}

/// One step: by the clock, and of the processor's time alone, which leaves out what the machine
/// gave to others meanwhile [ns].
struct StepTime {
  double wall_ns = 0.0;
  double busy_ns = 0.0;
};

template <class Work>
StepTime time_of(Work&& work) {
  const std::uint64_t wall = now_ns(), busy = busy_ns();
  work();
  const auto busy_time = static_cast<double>(busy_ns() - busy);
  return {static_cast<double>(now_ns() - wall), busy_time};
}

/// The compiler must take `value` to be needed, and all memory to be read and written here.
template <class Value>
void keep(const Value& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

}  // namespace fairlead::bench
