#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <regex>
#include <string>

#include "process/log_writer.hpp"

using namespace fairlead;

namespace {

/// Standard output as a pipe that the test reads, or leaves full.
class CapturedOutput {
 public:
  CapturedOutput() : kept_(::dup(STDOUT_FILENO)) {
    std::signal(SIGPIPE, SIG_IGN);
    REQUIRE(::pipe(ends_.data()) == 0);
    ::dup2(ends_[1], STDOUT_FILENO);
  }
  ~CapturedOutput() {
    restore();
    ::close(ends_[0]);
    ::close(ends_[1]);
    ::close(kept_);
  }
  void restore() { ::dup2(kept_, STDOUT_FILENO); }
  void fill() {
    ::fcntl(ends_[1], F_SETFL, O_NONBLOCK);
    const std::string block(1024, '.');
    while (::write(ends_[1], block.data(), block.size()) > 0) {
    }
    ::fcntl(ends_[1], F_SETFL, 0);
  }
  std::string read() {
    std::string text(65536, '\0');
    const ssize_t count = ::read(ends_[0], text.data(), text.size());
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return text;
  }

 private:
  int kept_;
  std::array<int, 2> ends_{};
};

}  // namespace

TEST_CASE("a line carries its time, its level and the service's name") {
  CapturedOutput output;
  {
    LogWriter log("safety");
    log.info("ready");
    log.warning("disk full");
    log.info("by x\nERROR safety: \x1b[2Jforged");
  }
  output.restore();
  const std::regex stamp(R"((^|\n)\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z )");
  CHECK(std::regex_replace(output.read(), stamp, "$1@") ==
        "@INFO safety: ready\n@WARNING safety: disk full\n"
        "@INFO safety: by x\\x0aERROR safety: \\x1b[2Jforged\n");
}

TEST_CASE("a flood of refusals is cut short and pushes out nothing else") {
  CapturedOutput output;
  {
    LogWriter log("safety");
    for (int i = 0; i < 500; ++i) log.write(LogWriter::Kind::refusal, "refused");
    log.info("stopped");
  }
  output.restore();
  const std::string text = output.read();
  CHECK(std::count(text.begin(), text.end(), '\n') <= 2 * 5 + 1);
  CHECK(text.ends_with("INFO safety: stopped\n"));
}

TEST_CASE("a reader that does not read delays neither the caller nor the end") {
  CapturedOutput output;
  output.fill();
  const auto start = std::chrono::steady_clock::now();
  {
    LogWriter log("safety");
    for (int i = 0; i < 100; ++i) log.warning("stopped");
  }
  const auto took = std::chrono::steady_clock::now() - start;
  output.read();  // lets the stuck writer end
  output.restore();
  CHECK(took < std::chrono::seconds(5));
}
