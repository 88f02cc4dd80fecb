// The needs of a run, and the refusal of one that needs more than the machine has.
#pragma once

#include <filesystem>
#include <string>

#include "render/program/command.h"
#include "scenes/scene/scene.h"

namespace taut::options {

/// All roughly, memory at most.
struct Needs {
  double memory = 0;  // bytes
  double disk = 0;    // bytes
  double time = 0;  // s of one processor, at least: of a method that chooses its steps one a frame
};

/// Of `taut simulate`; the disk is the CSV's.
Needs simulation_needs(const scenes::Scene& scene);

/// Of `taut render`, for so many frames of the scene's stage, drawn by so many threads (0: as many
/// as the machine has).
Needs clip_needs(const scenes::Scene& scene, double frames, int samples, int threads);

/// How many frames the scene's clip has, without a list of them.
double clip_length(const scenes::Scene& scene);

/// Steps in a frame; 0 for methods that choose their own.
double steps_per_frame(const scenes::Scene& scene);

/// As in "3 min".
std::string time_text(double seconds);
/// As in "about 1.5 GB of memory, 20 MB of disk".
std::string space_text(const Needs& needs);

/// --max-memory; 0: three quarters of what the machine, or the group of processes, has.
void add_memory_option(program::Command& command, double& most);

/// Throws BadScene where the memory is more than `most` allows, and CannotWrite where the disk of
/// `folder` has less room than is needed; `fewer` says what else to change. Unless `quiet`, says on
/// standard error what will take more than a minute.
void refuse_beyond(const Needs& needs, const scenes::Scene& scene, double most,
                   const std::filesystem::path& folder, const std::string& fewer, bool quiet);

}  // namespace taut::options
