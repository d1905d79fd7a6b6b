// Which mutant this process runs, and which mutants each test case comes by.
//
//   FAIRLEAD_MUTANT=17        run with mutant 17
//   FAIRLEAD_MUTANT_MS=2000   processor time after which it counts as hung
//   FAIRLEAD_MUTANT_SERVE=1   answer lines "mutant, milliseconds, name of a test" of standard
//   input,
//                             each with a fork of this process: its status as wait() tells it
//   FAIRLEAD_MUTANT_MAP=FILE  write "name, time, mutants reached" of each test case
#include "mutant.hpp"

#include <doctest/doctest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

unsigned number_from(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? 0 : static_cast<unsigned>(std::strtoul(text, nullptr, 10));
}

}  // namespace

namespace fm {

unsigned active = 0;
bool reached[most];

}  // namespace fm

namespace {

// Before anything else of the program: constants of the core are mutated too.
[[gnu::constructor(101)]] void choose_mutant() { fm::active = number_from("FAIRLEAD_MUTANT"); }

// The alarm ends the process by its default action.
bool set_alarm(unsigned limit_ms) {
  itimerval limit{};
  limit.it_value.tv_sec = limit_ms / 1000;
  limit.it_value.tv_usec = static_cast<suseconds_t>(limit_ms % 1000) * 1000;
  return limit_ms > 0 && setitimer(ITIMER_PROF, &limit, nullptr) == 0;
}

const bool alarm_is_set = set_alarm(number_from("FAIRLEAD_MUTANT_MS"));

// Name of the test that runs, or ran last, in a fork.
constexpr std::size_t name_size = 512;
char* const last_test = static_cast<char*>(
    mmap(nullptr, name_size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));

// Some tests with one mutant, in a process of their own.
[[noreturn]] void run_tests(unsigned mutant, unsigned limit_ms, const char* names) {
  const rlimit no_core{};
  setrlimit(RLIMIT_CORE, &no_core);
  alarm(600);  // a test that waits for what never comes takes no processor time
  set_alarm(limit_ms);
  unsetenv("FAIRLEAD_MUTANT_SERVE");
  fm::active = mutant;
  doctest::Context context;
  context.setOption("abort-after", 1);
  context.setOption("minimal", true);
  context.setOption("no-version", true);
  context.addFilter("test-case", names);
  _exit(context.run());
}

void serve() {
  static char line[1 << 17];
  while (std::fgets(line, sizeof line, stdin) != nullptr) {
    line[std::strcspn(line, "\n")] = 0;
    char* rest = nullptr;
    const auto mutant = static_cast<unsigned>(std::strtoul(line, &rest, 10));
    const auto limit_ms = static_cast<unsigned>(std::strtoul(rest, &rest, 10));
    const pid_t child = fork();
    if (child == 0) {
      std::fclose(stdout);
      run_tests(mutant, limit_ms, rest + 1);
    }
    int status = -1;
    waitpid(child, &status, 0);
    std::printf("%d %s\n", status, last_test);
    std::fflush(stdout);
  }
  _exit(0);
}

class MapWriter : public doctest::IReporter {
 public:
  explicit MapWriter(const doctest::ContextOptions&) {
    if (const char* path = std::getenv("FAIRLEAD_MUTANT_MAP")) file_ = std::fopen(path, "w");
    end("", 0.0);  // what the constants of the core came by, before any test
  }
  ~MapWriter() override {
    if (file_ != nullptr) std::fclose(file_);
  }
  void test_case_start(const doctest::TestCaseData& test) override {
    std::snprintf(last_test, name_size, "%s", test.m_name);
    if (file_ == nullptr) return;
    name_ = test.m_name;
    std::fill(std::begin(fm::reached), std::end(fm::reached), false);
    begun_ = std::chrono::steady_clock::now();
  }
  void test_case_end(const doctest::CurrentTestCaseStats&) override {
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun_;
    end(name_, took.count());
  }
  void report_query(const doctest::QueryData&) override {}
  void test_run_start() override {
    if (number_from("FAIRLEAD_MUTANT_SERVE") != 0) serve();
  }
  void test_run_end(const doctest::TestRunStats&) override {}
  void test_case_reenter(const doctest::TestCaseData&) override {}
  void test_case_exception(const doctest::TestCaseException&) override {}
  void subcase_start(const doctest::SubcaseSignature&) override {}
  void subcase_end() override {}
  void log_assert(const doctest::AssertData&) override {}
  void log_message(const doctest::MessageData&) override {}
  void test_case_skipped(const doctest::TestCaseData&) override {}

 private:
  void end(const char* name, double seconds) {
    if (file_ == nullptr) return;
    std::fprintf(file_, "%s\t%.6f\t", name, seconds);
    for (unsigned id = 1; id < fm::most; ++id)
      if (fm::reached[id]) std::fprintf(file_, "%u ", id);
    std::fputc('\n', file_);
  }

  std::FILE* file_ = nullptr;
  const char* name_ = "";
  std::chrono::steady_clock::time_point begun_;
};

}  // namespace

REGISTER_LISTENER("mutants reached", 1, MapWriter);
