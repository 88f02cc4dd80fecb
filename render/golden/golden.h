// Golden pictures: the record of a frame, today's picture compared with it, and the page that
// shows both.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/picture/picture.h"
#include "sim/run/trajectory.h"

namespace taut::golden {

// How two pictures differ: the measures by which golden pictures are compared.

struct PictureDifference {
  double above_2 = 0;     // share of pixels with a channel more than 2 (of 255) apart
  int largest = 0;        // the largest distance of any channel
  double mean_shift = 0;  // the largest channel's |mean difference|
  // Share of pixels that lie, in one of the pictures, more than 8 away from every pixel within one
  // of them in the other.
  double near_above_8 = 0;
};

/// Throws std::invalid_argument where the sizes differ.
PictureDifference difference(const picture::Picture& actual, const picture::Picture& golden);

/// As two runs of one driver should be: at most 0.01% of the pixels differ by more than 2, none by
/// more than 16, and the means by at most 0.3.
bool same_rendering(const PictureDifference& difference);

/// As two drivers may be: edges may move by a pixel, 0.1% of the pixels may differ by more than 8.
bool same_picture(const PictureDifference& difference);

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

// The page on which a person looks at golden pictures that no longer match.

/// One picture that differs. NAME/actual.png, NAME/golden.png and NAME/difference.png lie beside
/// the page.
struct GoldenFailure {
  std::string name;     // letters, digits, _ and -
  std::string verdict;  // one sentence
  bool pictures = true;
};

/// One HTML file without scripts from elsewhere: each picture with a slider between golden and
/// actual, a blink view, and the amplified difference.
std::string golden_page(std::span<const GoldenFailure> failures);

}  // namespace taut::golden
