// Faults made on purpose at every place where they can happen: each call that can fail does, or the
// program is killed there. A file with a final name is whole or as before, the message says why,
// and the next run makes what a run that was never disturbed makes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <regex>
#include <thread>

#include "render/program/output.h"
#include "tests/faults/subject.h"
#include "tests/faults/trial.h"
#include "tests/support/dice.h"
#include "tests/support/fault_table.h"
#include "tests/support/folder.h"

namespace taut::faults {
namespace {

namespace fs = std::filesystem;

constexpr fs::perms kOwnMode =
    fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read;

bool is_sanitized() {
#ifdef TAUT_SANITIZED
  return true;  // its own allocator has to come first
#else
  return false;
#endif
}

bool is_temporary(const std::string& name) {
  return name.ends_with(".part");
}

class FaultPlaces : public testing::TestWithParam<Subject> {
 protected:
  void SetUp() override {
    if (is_sanitized()) GTEST_SKIP() << "a sanitizer's library must be loaded before all others";
    const Folder folder;
    prepare(folder);
    const ProgramResult outcome = run_undisturbed(subject_, folder.path());
    ASSERT_EQ(outcome.code, 0) << outcome.messages;
    undisturbed_ = files_in(folder.path());
  }

  /// All faults that a run can meet.
  std::vector<Fault> faults() const {
    std::vector<Fault> all;
    for (const bool in_children : {false, true}) {
      if (in_children && subject_.child_code == 0) continue;
      const Folder folder;
      prepare(folder);
      const Trial trial = run_with({.in_children = in_children}, subject_, folder.path());
      EXPECT_EQ(trial.outcome.code, 0) << "without a fault: " << trial.outcome.messages;
      for (const How how : {How::fail, How::fail_from_there_on, How::kill}) {
        for (int kind = 0; kind < kKinds; ++kind) {
          // How other programs take failures is theirs; that they can fail is enough.
          if (in_children && kind != kOpen && kind != kWrite &&
              !(subject_.own_child && kind == kMemory)) {
            continue;
          }
          const std::uint64_t calls = trial.calls[kind];
          const std::uint64_t apart =
              kind == kMemory ? std::max<std::uint64_t>(calls / subject_.allocations, 1) : 1;
          for (std::uint64_t at = 1; at <= calls; at += apart)
            all.push_back({Kind(kind), how, at, in_children});
        }
      }
    }
    return all;
  }

  /// Makes each `apart`-th of them.
  void disturb(std::size_t apart) {
    const std::vector<Fault> all = faults();
    for (std::size_t i = apart / 2; i < all.size(); i += apart) disturb(all[i]);
  }

  /// Kills it at so many moments, at any time of its run.
  void kill_at_moments(int count) {
    using Clock = std::chrono::steady_clock;
    Dice dice(1);
    Clock::duration whole{};
    {
      const Folder folder;
      prepare(folder);
      const auto start = Clock::now();
      run_undisturbed(subject_, folder.path());
      whole = Clock::now() - start;
    }
    for (int i = 0; i < count; ++i) {
      const Folder folder;
      prepare(folder);
      std::vector<std::string> command = subject_.arguments;
      command.insert(command.begin(), TAUT_PROGRAM);
      Child child(command, folder.path());
      const double share = dice.between(0, 1);
      std::this_thread::sleep_for(share * whole);
      kill(child.id(), SIGKILL);
      const int code = child.wait().code;
      SCOPED_TRACE(fmt::format("killed after {:.0f}% of its time: {}", 100 * share, code));
      EXPECT_TRUE(code == 0 || code == 128 + SIGKILL);
      expect_whole_files({.how = How::kill}, code, folder);
      const ProgramResult next = run_undisturbed(subject_, folder.path());
      EXPECT_EQ(next.code, 0) << next.messages;
      expect_undisturbed(folder);
    }
  }

  void expect_accepted(bool all) {
    const std::string title = "At every place: " + subject_.name;
    FaultTable table(title, "FOLDER");
    for (const auto& [place, outcome] : rows_)
      table.add(place, {outcome.first, "", outcome.second});
    // A chart makes as many calls as its time allows: of the table, a run may lack some.
    const bool accept = all && std::getenv("TAUT_ACCEPT");
    EXPECT_TRUE(accept ? table.is_as_accepted() : table.is_part_of_accepted());
  }

 private:
  void prepare(const Folder& folder) const {
    for (const auto& [name, bytes] : subject_.before)
      fs::permissions(folder.write(name, bytes), kOwnMode);
  }

  void disturb(const Fault& fault) {
    const Folder folder;
    prepare(folder);
    const Trial trial = run_with(fault, subject_, folder.path());
    SCOPED_TRACE(fmt::format("{}: kind {}, how {}, call {}{}: {} ended with {}: {}", subject_.name,
                             int(fault.kind), int(fault.how), fault.at,
                             fault.in_children ? " of children" : "", trial.place,
                             trial.outcome.code, trial.outcome.messages));
    // Threads may make fewer calls another time.
    if (trial.place.empty()) return;
    expect_right_end(fault, trial.outcome);
    expect_whole_files(fault, trial.outcome.code, folder);
    note(fault, trial, folder);

    const ProgramResult next = run_undisturbed(subject_, folder.path());
    EXPECT_EQ(next.code, 0) << next.messages;
    expect_undisturbed(folder);
  }

  void expect_right_end(const Fault& fault, const ProgramResult& outcome) const {
    if (fault.how == How::kill && !fault.in_children) {
      EXPECT_EQ(outcome.code, 128 + SIGKILL);
      return;
    }
    const int code = outcome.code;
    EXPECT_EQ(outcome.messages.find("internal error"), std::string::npos);
    if (code == 0) return;
    if (fault.in_children) {
      const bool is_full = kErrors[fault.kind] == ENOSPC && code == program::kCannotWrite;
      const bool no_memory = fault.kind == kMemory && code == program::kNoMemory;
      EXPECT_TRUE(code == subject_.child_code || is_full || no_memory);
      return;
    }
    std::string cause = std::strerror(kErrors[fault.kind]);
    switch (fault.kind) {
      case kMemory:
        EXPECT_EQ(code, program::kNoMemory);
        cause = "out of memory";
        break;
      case kThread:
        ADD_FAILURE() << "fewer threads can do the work";
        break;
      case kSpawn:
      case kPipe:
        EXPECT_EQ(code, subject_.child_code);
        break;
      case kWrite:
        EXPECT_TRUE(code == program::kCannotWrite || code == subject_.child_code);
        break;
      default:
        EXPECT_EQ(code, program::kCannotWrite);
    }
    if (fault.kind == kSay && fault.how == How::fail_from_there_on) return;  // also of its message
    EXPECT_TRUE(outcome.messages.starts_with("taut: "));
    EXPECT_NE(outcome.messages.find(cause), std::string::npos) << "expected: " << cause;
  }

  /// Each is as it was before, or as it is after an undisturbed run.
  void expect_whole_files(const Fault& fault, int code, const Folder& folder) const {
    const Files now = files_in(folder.path());
    for (const auto& [name, bytes] : now) {
      if (subject_.own.contains(name)) continue;
      if (is_temporary(name)) {
        const bool cannot_be_removed = fault.how == How::kill || fault.kind == kUnlink;
        EXPECT_TRUE(cannot_be_removed) << name << " is left";
        continue;
      }
      const auto before = subject_.before.find(name);
      const auto after = undisturbed_.find(name);
      EXPECT_TRUE((before != subject_.before.end() && bytes == before->second) ||
                  (after != undisturbed_.end() && bytes == after->second))
          << name << " is neither as before nor as it ought to be";
    }
    for (const auto& [name, bytes] : subject_.before)
      EXPECT_TRUE(now.contains(name) || !undisturbed_.contains(name)) << name << " is gone";
    if (code == 0) expect_undisturbed(folder);
  }

  void expect_undisturbed(const Folder& folder) const {
    const Files now = files_in(folder.path());
    for (const auto& [name, bytes] : undisturbed_) {
      if (subject_.own.contains(name)) continue;
      const auto file = now.find(name);
      EXPECT_TRUE(file != now.end() && file->second == bytes) << name;
      // FFmpeg makes a file of its own.
      if (subject_.before.contains(name) && !name.ends_with(".mp4")) {
        EXPECT_EQ(fs::status(folder.path() / name).permissions(), kOwnMode) << name;
      }
    }
    for (const auto& [name, bytes] : now)
      EXPECT_TRUE(undisturbed_.contains(name)) << name << " should not be there";
  }

  /// The table has what is the same each time: not which of many allocations was the first, nor
  /// which of two frames, nor what chance calls a video that is being made.
  void note(const Fault& fault, const Trial& trial, const Folder& folder) {
    if (fault.how != How::fail || fault.kind == kMemory || fault.in_children) return;
    const auto plain = [&](std::string text) {
      for (std::size_t at; (at = text.find(folder.path().string())) != std::string::npos;)
        text.replace(at, folder.path().string().size(), "FOLDER");
      text = std::regex_replace(text, std::regex("[0-9]{6}\\.png"), "NNNNNN.png");
      return std::regex_replace(text, std::regex("\\.[0-9a-f]{16}\\.part"), ".part");
    };
    rows_[plain(trial.place)] = {trial.outcome.code, plain(trial.outcome.messages)};
  }

  const Subject& subject_ = GetParam();
  Files undisturbed_;
  std::map<std::string, std::pair<int, std::string>> rows_;
};

TEST_P(FaultPlaces, SomeOfThem) {
  disturb(2 * GetParam().apart);
  expect_accepted(false);
}

using LongFaultPlaces = FaultPlaces;

TEST_P(LongFaultPlaces, AllOfThem) {
  disturb(1);
  expect_accepted(true);
}

TEST_P(FaultPlaces, KilledAtSomeMoments) {
  kill_at_moments(2);
}

// Six commands: more than a thousand kills.
TEST_P(LongFaultPlaces, KilledAtHundredsOfMoments) {
  kill_at_moments(170);
}

/// A closed stream's number is not given to an output, which would get the program's words.
TEST(ClosedStreams, AreNoOutputs) {
  const Folder folder;
  const Subject& render = *std::ranges::find(subjects(), "render", &Subject::name);
  for (const auto& [name, bytes] : render.before) folder.write(name, bytes);
  std::vector<std::string> arguments = render.arguments;
  arguments.push_back("--no-video");
  const ProgramResult outcome = run_taut(arguments, folder.path(), [] { close(STDOUT_FILENO); });
  EXPECT_EQ(outcome.code, program::kCannotWrite);
  EXPECT_EQ(outcome.messages, "taut: standard output: Bad file descriptor\n");
  EXPECT_EQ(read_file(folder.path() / "clip/frames/lock"), "");
}

std::string name_of(const testing::TestParamInfo<Subject>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Some, FaultPlaces, testing::ValuesIn(subjects()), name_of);
INSTANTIATE_TEST_SUITE_P(Long, LongFaultPlaces, testing::ValuesIn(subjects()), name_of);

}  // namespace
}  // namespace taut::faults
