// Judgements run on threads of Zenoh's library, whose stacks have 2 MiB: half of it is enough.
#ifndef __SANITIZE_ADDRESS__  // which leaves room around each variable
#include <doctest/doctest.h>
#include <pthread.h>

#include <memory>
#include <string>

#include "decisions/header.hpp"
#include "decisions/log_reader.hpp"
#include "decisions/replay.hpp"

using namespace fairlead;

namespace {

struct Work {
  LogReader* log;
  Replay* replay;
  std::size_t steps = 0;
};

void* judge_all(void* given) {
  Work& work = *static_cast<Work*>(given);
  for (Record record; work.log->next(record); ++work.steps)
    if (record.type != RecordType::end) work.replay->feed(record);
  return nullptr;
}

}  // namespace

TEST_CASE("recorded sessions of two arms are judged on a stack of 1 MiB") {
  LogReader log(std::string(FAIRLEAD_SESSIONS_DIR) + "/judged_dual_panda_1.decisions");
  const std::unique_ptr<Limits> limits = recorded_limits(read_header(log.header()));
  Replay replay(*limits);
  Work work{&log, &replay};
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  REQUIRE(pthread_attr_setstacksize(&attributes, 1 << 20) == 0);
  pthread_t thread;
  REQUIRE(pthread_create(&thread, &attributes, judge_all, &work) == 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
  CHECK(work.steps > 100);
}
#endif
