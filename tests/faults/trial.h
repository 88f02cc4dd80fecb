// One run of a command with one fault in it.
#pragma once

#include <filesystem>
#include <string>

#include "tests/faults/preload/page.h"
#include "tests/faults/subject.h"
#include "tests/support/program.h"

namespace taut::faults {

struct Fault {
  Kind kind = kOpen;
  How how = How::count;
  std::uint64_t at = 0;
  bool in_children = false;
};

struct Trial {
  ProgramResult outcome;
  std::uint64_t calls[kKinds] = {};
  std::string place;
};

/// Runs the command in `folder`, under the fault.
Trial run_with(const Fault& fault, const Subject& subject, const std::filesystem::path& folder);

/// Runs it in peace.
ProgramResult run_undisturbed(const Subject& subject, const std::filesystem::path& folder);

/// All files below a folder.
Files files_in(const std::filesystem::path& folder);

}  // namespace taut::faults
