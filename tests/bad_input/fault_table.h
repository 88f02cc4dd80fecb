// The table of faults: what was wrong, what taut said, how it ended. Made by the tests, kept in
// tests/bad_input/faults/, so that a change of any message is seen.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/support/program.h"

namespace taut {

class FaultTable {
 public:
  /// `folder` is where the tests' files lie.
  FaultTable(std::string title, const std::filesystem::path& folder)
      : title_(std::move(title)), folder_(folder.string()) {}

  void add(const std::string& fault, const Outcome& outcome);

  /// Compares with tests/bad_input/faults/NAME.md; with TAUT_ACCEPT set in the environment, writes
  /// it instead.
  testing::AssertionResult is_as_accepted(const std::string& name) const;

 private:
  std::string title_, folder_, rows_;
};

}  // namespace taut
