// Other programs that compute known answers: each is run on a case's scene, and prints the values.
#pragma once

#include <string>
#include <vector>

#include "render/study/known_answers.h"

namespace taut::studies {

/// The protocol, for --help.
extern const std::string_view kEngineHelp;

/// A program that speaks the protocol.
struct Engine {
  std::string name;
  std::vector<std::string> command;
};

/// Reads NAME=COMMAND, the command's words apart by spaces. Throws Misuse.
Engine engine_of(const std::string& text);

/// Runs an engine on a case at a time step of `step` (s), for about `cpu_cap` (s) of CPU time.
/// Throws Misuse where the command cannot be started.
Verdict verify(const AnswerCase& of, const Engine& engine, double step, double cpu_cap);

}  // namespace taut::studies
