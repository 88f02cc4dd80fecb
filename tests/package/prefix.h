// taut installed in a folder of its own, once for all tests of a program.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {

/// The result of a program that must end well.
inline ProgramResult must_run(std::vector<std::string> command,
                              const std::filesystem::path& folder) {
  const std::string name = command[0];
  ProgramResult result = Child(std::move(command), folder).wait(std::chrono::seconds(300));
  EXPECT_EQ(result.code, 0) << name << "\n" << result.output << result.messages;
  return result;
}

/// Where taut is installed; tests only read it.
inline const std::filesystem::path& prefix() {
  static Folder folder;
  static const std::filesystem::path place = [] {
    const std::filesystem::path at = folder.path() / "prefix";
    must_run({"cmake", "--install", TAUT_BUILD_DIR, "--prefix", at.string()}, folder.path());
    return at;
  }();
  return place;
}

/// The first folder of the prefix's libraries: lib, lib64 or lib/TRIPLE.
inline std::filesystem::path library_folder() {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(prefix())) {
    if (entry.path().filename().string().starts_with("libtaut_sim.")) {
      return entry.path().parent_path();
    }
  }
  return {};
}

}  // namespace taut
