// A golden suite: a folder whose golden.toml names frames and motions of scenes, to be kept and
// compared with what they are later.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/format/document.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {

/// One picture to keep: a scene at one of its frames.
struct GoldenFrame {
  std::string name;
  std::filesystem::path scene;
  int frame = 0;
  MethodChoice method;
  double within = 0;   // m: how far today's simulation may end from the kept state
  std::string source;  // file:line, for messages
};

/// One motion to keep: a scene's states from the start to one of its frames.
struct GoldenTrajectory {
  std::string name;
  std::filesystem::path scene;
  int last = 0;  // frame
  MethodChoice method;
  double within = 0;  // m: how far today's simulation may be from any kept state
};

struct GoldenSuite {
  std::filesystem::path folder;
  int width = 320, height = 180, samples = 4;
  std::vector<GoldenFrame> frames;  // in the order of the file
  std::vector<GoldenTrajectory> trajectories;
};

/// Reads FOLDER/golden.toml: what has those names, or everything. Throws BadScene, also for faults
/// of a scene that is read.
GoldenSuite load_golden_suite(const std::filesystem::path& folder,
                              const std::vector<std::string>& only = {});
/// The same of a document that was read already.
GoldenSuite golden_suite_from(const Document& document, const std::vector<std::string>& only = {});

}  // namespace taut::scenes
