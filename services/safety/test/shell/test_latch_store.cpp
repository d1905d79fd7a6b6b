#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "process/latch_store.hpp"
#include "process/refusal.hpp"

using namespace fairlead;
namespace fs = std::filesystem;

namespace {

/// A folder of its own for each test.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "fairlead-latch-XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    path = name;
  }
  ~Folder() { fs::remove_all(path); }
  fs::path path;
};

void ignore(const std::string&) {}

const std::vector<std::uint8_t> kRecord = {1, 2, 3};

}  // namespace

TEST_CASE("a folder never used before is a first start") {
  const Folder folder;
  const LatchStore store(folder.path / "new", ignore);
  CHECK(store.first_start());
  CHECK_FALSE(store.found().clean_mark);
  CHECK(store.found().latch.empty());
}

TEST_CASE("a used folder without a clean mark is not a first start and not clean") {
  const Folder folder;
  { const LatchStore store(folder.path, ignore); }
  const LatchStore store(folder.path, ignore);
  CHECK_FALSE(store.first_start());
  CHECK_FALSE(store.found().clean_mark);
}

TEST_CASE("a clean mark and a latch survive the end of the process") {
  const Folder folder;
  {
    LatchStore store(folder.path, ignore);
    store.set_clean_mark(true);
  }
  {
    LatchStore store(folder.path, ignore);
    CHECK(store.found().clean_mark);
    store.set_clean_mark(false);
    store.set_latch(kRecord);
  }
  {
    LatchStore store(folder.path, ignore);
    CHECK_FALSE(store.found().clean_mark);
    CHECK(store.found().latch == kRecord);
    store.set_latch({});
    store.set_clean_mark(true);
  }
  const LatchStore store(folder.path, ignore);
  CHECK(store.found() == StoredState{true, {}});
}

TEST_CASE("clearing the clean mark for an arm is on the disk when the call returns") {
  const Folder folder;
  {
    LatchStore store(folder.path, ignore);
    store.set_clean_mark(true);
  }
  LatchStore store(folder.path, ignore);
  REQUIRE(fs::exists(folder.path / "clean_mark"));
  CHECK(store.is_marked());
  CHECK(store.clear_clean_mark_now().empty());
  CHECK_FALSE(fs::exists(folder.path / "clean_mark"));
  CHECK_FALSE(store.is_marked());
  store.set_clean_mark(true);
  CHECK(store.is_marked());  // whether or not it has been written yet
}

TEST_CASE("a second gate on the same folder is refused") {
  const Folder folder;
  const LatchStore first(folder.path, ignore);
  const std::string expected =
      "state folder: another gate already uses " + folder.path.string() + "; see: fairlead ps";
  CHECK_THROWS_WITH_AS(LatchStore(folder.path, ignore), expected.c_str(), StartFailed);
}

TEST_CASE("a latch that cannot be written is reported once and nothing throws") {
  const Folder folder;
  std::vector<std::string> faults;
  {
    LatchStore store(folder.path, [&faults](const std::string& fault) { faults.push_back(fault); });
    // A folder where the file should be: no write can replace it, whoever runs the test.
    fs::create_directories(folder.path / "latch" / "occupied");
    store.set_latch(kRecord);
  }
  REQUIRE(faults.size() == 1);
  CHECK(faults[0].starts_with("cannot replace " + (folder.path / "latch").string()));
}

TEST_CASE("a state folder that cannot be made is refused by name") {
  const Folder folder;
  { const LatchStore store(folder.path, ignore); }
  CHECK_THROWS_AS(LatchStore(folder.path / "gate.lock" / "sub", ignore), StartFailed);
}

TEST_CASE("a folder that others may write is not believed") {
  const Folder folder;
  { const LatchStore store(folder.path, ignore); }
  REQUIRE(::chmod(folder.path.c_str(), 0777) == 0);
  CHECK_THROWS_AS(LatchStore(folder.path, ignore), StartFailed);
  REQUIRE(::chmod(folder.path.c_str(), 0770) == 0);
  CHECK_NOTHROW(LatchStore(folder.path, ignore));
  if (::geteuid() != 0) return;  // only root can give it away
  REQUIRE(::chown(folder.path.c_str(), 12345, 12345) == 0);
  CHECK_THROWS_AS(LatchStore(folder.path, ignore), StartFailed);
}

TEST_CASE("after a write that failed half-way the disk is made what is wanted, even as before") {
  const Folder folder;
  std::atomic<bool> failed = false;
  {
    LatchStore store(folder.path, [&](const std::string&) { failed = true; });
    store.set_clean_mark(true);
    while (!fs::exists(folder.path / "clean_mark")) std::this_thread::yield();
    fs::create_directories(folder.path / "latch" / "occupied");  // no file can take its place
    store.set_clean_mark(false);
    store.set_latch(kRecord);
    while (!failed) std::this_thread::yield();
    fs::remove_all(folder.path / "latch");
    store.set_latch({});
    store.set_clean_mark(true);
  }
  CHECK(fs::exists(folder.path / "clean_mark"));
  CHECK_FALSE(fs::exists(folder.path / "latch"));
}

TEST_CASE("an arm that was refused for the mark's sake leaves a gate that ends clean") {
  const Folder folder;
  {
    LatchStore store(folder.path, ignore);
    store.set_clean_mark(true);
    while (!fs::exists(folder.path / "clean_mark")) std::this_thread::yield();
    fs::remove(folder.path / "clean_mark");
    fs::create_directories(folder.path / "clean_mark" / "occupied");
    CHECK(store.clear_clean_mark_now() != "");
    fs::remove_all(folder.path / "clean_mark");
  }
  CHECK(fs::exists(folder.path / "clean_mark"));
}
