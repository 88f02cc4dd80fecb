// Golden pictures: the record of a frame, and the comparison of today's picture with it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "render/golden/picture_difference.h"
#include "render/picture/picture.h"
#include "sim/run/trajectory.h"

namespace taut::golden {

/// The driver that draws in a context with this description (Context::description): its name and
/// version, without the backend. A software rasteriser tells the width of its vectors, too: on
/// processors with others it has other instructions, which round otherwise.
std::string driver_of(const std::string& description);

/// The poses of characters' bones, [character][bone], world space.
using Bones = std::vector<std::vector<Pose>>;

/// The record of a frame beside its picture. State and bones are those of the accepted picture, not
/// to be simulated again: slack cords and hanging cloth are chaotic and differ between machines.
struct GoldenRecord {
  std::string driver;  // that drew the picture
  Snapshot state;      // empty of a scene's first frame, which the scene describes
  Bones bones = {};    // likewise
};

/// Reads NAME.json. Throws BadAsset that names the file and what is wrong with it.
GoldenRecord read_golden(const std::filesystem::path& file);
GoldenRecord golden_from(const std::string& text, const std::filesystem::path& file);
std::string golden_text(const GoldenRecord& record);

/// Which tolerance pictures are compared with: same_rendering() or same_picture().
enum class Tier { same_driver, other_driver };
std::string_view name_of(Tier tier);

struct PictureComparison {
  Tier tier = Tier::same_driver;
  bool same = false;
  PictureDifference difference;
};

/// Compares a picture that `driver` drew from the record's state with the accepted one.
PictureComparison compare(const picture::Picture& actual, const std::string& driver,
                          const picture::Picture& golden, const GoldenRecord& record);

/// Where and how much two pictures of one size differ: distances times 8, on the golden's grey
/// ghost.
picture::Picture amplified_difference(const picture::Picture& actual,
                                      const picture::Picture& golden);

}  // namespace taut::golden
