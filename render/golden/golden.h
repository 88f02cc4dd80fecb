// Golden pictures: the record of a frame, and the comparison of today's picture with it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "render/golden/picture_difference.h"
#include "render/picture/picture.h"
#include "sim/run/trajectory.h"

namespace taut::golden {

/// The renderer of a picture, as far as pixels depend on it.
struct Renderer {
  std::string driver;     // its name and version, without the way in and its vectors' width
  std::string processor;  // name, features, and the width of the driver's vectors
};

/// Of a context with this description (Context::description), on this machine.
Renderer renderer_of(const std::string& description);

/// This machine's processor: its name, and a hash of its features.
std::string processor();

/// The record of a frame beside its picture. The state is the simulation's, not to be simulated
/// again: slack motion is chaotic, and differs between machines.
struct GoldenRecord {
  Renderer renderer;
  std::uint64_t pixels = 0;  // hash of the picture
  Snapshot state;            // empty of a scene's first frame, which the scene describes
};

std::uint64_t pixel_hash(const picture::Picture& picture);

/// Reads NAME.json. Throws BadAsset that names the file and what is wrong with it.
GoldenRecord read_golden(const std::filesystem::path& file);
GoldenRecord golden_from(const std::string& text, const std::filesystem::path& file);
std::string golden_text(const GoldenRecord& record);

/// How alike pictures must be: bits on the same driver and processor, otherwise by tolerance.
enum class Tier { exact, same_driver, other_driver };
std::string_view name_of(Tier tier);

struct PictureComparison {
  Tier tier = Tier::exact;
  bool same = false;
  PictureDifference difference;
};

/// Judges a picture drawn by `renderer` from the record's state.
PictureComparison compare(const picture::Picture& actual, const Renderer& renderer,
                          const picture::Picture& golden, const GoldenRecord& record);

/// Where and how much two pictures of one size differ: distances times 8, on the golden's grey
/// ghost.
picture::Picture amplified_difference(const picture::Picture& actual,
                                      const picture::Picture& golden);

}  // namespace taut::golden
