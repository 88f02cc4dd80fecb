#include "render/golden/golden.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "render/chart/html_page.h"
#include "render/chart/table.h"
#include "render/golden/golden_trajectory.h"
#include "scenes/files/files.h"

namespace taut::golden {
namespace {

int distance(const std::uint8_t* a, const std::uint8_t* b) {
  int largest = 0;
  for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(int(a[k]) - int(b[k])));
  return largest;
}

/// The least distance of the pixel of `a` from those of `b` within one of it; no less than 8 is
/// looked for.
int distance_from_nearest(const picture::Picture& a, const picture::Picture& b, int x, int y) {
  int nearest = distance(a.at(x, y), b.at(x, y));
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, b.height - 1) && nearest > 8; ++v)
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, b.width - 1); ++u)
      nearest = std::min(nearest, distance(a.at(x, y), b.at(u, v)));
  return nearest;
}

}  // namespace

PictureDifference difference(const picture::Picture& actual, const picture::Picture& golden) {
  if (actual.width != golden.width || actual.height != golden.height)
    throw std::invalid_argument(fmt::format("pictures of {}x{} and {}x{} cannot be compared",
                                            actual.width, actual.height, golden.width,
                                            golden.height));
  PictureDifference result;
  std::array<double, 3> sums{};
  std::size_t far = 0, far_from_all = 0;
  for (int y = 0; y < golden.height; ++y)
    for (int x = 0; x < golden.width; ++x) {
      const std::uint8_t *a = actual.at(x, y), *g = golden.at(x, y);
      for (std::size_t k = 0; k < 3; ++k) sums[k] += double(a[k]) - double(g[k]);
      const int here = distance(a, g);
      result.largest = std::max(result.largest, here);
      far += here > 2;
      far_from_all += here > 8 && (distance_from_nearest(actual, golden, x, y) > 8 ||
                                   distance_from_nearest(golden, actual, x, y) > 8);
    }
  const double pixels = double(golden.width) * golden.height;
  result.above_2 = double(far) / pixels;
  result.near_above_8 = double(far_from_all) / pixels;
  for (const double sum : sums)
    result.mean_shift = std::max(result.mean_shift, std::abs(sum) / pixels);
  return result;
}

bool same_rendering(const PictureDifference& d) {
  return d.above_2 <= 1e-4 && d.largest <= 16 && d.mean_shift <= 0.3;
}

bool same_picture(const PictureDifference& d) {
  return d.near_above_8 <= 1e-3;
}

namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::string driver_of(const std::string& description) {
  // "BACKEND: NAME (LLVM 15.0.6, 256 bits), OpenGL 4.5": OSMesa and EGL may lead to the same
  // driver.
  const std::size_t colon = description.find(": ");
  return colon == std::string::npos ? description : description.substr(colon + 2);
}

GoldenRecord read_golden(const std::filesystem::path& file) {
  return golden_from(
      scenes::read_regular_file(file, kMaxRecordBytes, "a record of a golden picture"), file);
}

GoldenRecord golden_from(const std::string& text, const std::filesystem::path& file) {
  try {
    const nlohmann::json record = nlohmann::json::parse(text);
    GoldenRecord golden{record.at("driver").get<std::string>(), snapshot_from(record.at("state"))};
    if (record.contains("bones")) {
      for (const auto& character : record.at("bones")) {
        std::vector<Pose>& poses = golden.bones.emplace_back();
        for (const auto& pose : character) poses.push_back(pose_from(pose));
      }
    }
    return golden;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw scenes::BadAsset(
        fmt::format("{}: no record of a golden picture: {}", file.string(), error.what()));
  }
}

std::string golden_text(const GoldenRecord& record) {
  Json json_record = {{"driver", record.driver}, {"state", to_json(record.state)}};
  for (const std::vector<Pose>& character : record.bones) {
    Json poses = Json::array();
    for (const Pose& pose : character) poses.push_back(to_json(pose));
    json_record["bones"].push_back(std::move(poses));
  }
  return json_record.dump() + "\n";
}

std::string_view name_of(Tier tier) {
  switch (tier) {
    case Tier::same_driver:
      return "same driver";
    case Tier::other_driver:
      return "another driver";
  }
  return "";
}

PictureComparison compare(const picture::Picture& actual, const std::string& driver,
                          const picture::Picture& golden, const GoldenRecord& record) {
  PictureComparison result;
  result.difference = difference(actual, golden);
  result.tier = driver == record.driver ? Tier::same_driver : Tier::other_driver;
  result.same = result.tier == Tier::same_driver ? same_rendering(result.difference)
                                                 : same_picture(result.difference);
  return result;
}

picture::Picture amplified_difference(const picture::Picture& actual,
                                      const picture::Picture& golden) {
  constexpr int kGain = 8;
  picture::Picture result(golden.width, golden.height);
  for (int y = 0; y < golden.height; ++y)
    for (int x = 0; x < golden.width; ++x) {
      const std::uint8_t *a = actual.at(x, y), *g = golden.at(x, y);
      const int ghost = (g[0] + g[1] + g[2]) / 12;
      for (int k = 0; k < 3; ++k)
        result.at(x, y)[k] = std::uint8_t(std::min(255, ghost + kGain * std::abs(a[k] - g[k])));
    }
  return result;
}

namespace {

constexpr const char* kViews = R"html(<div class="views">
<figure><div class="pair slider"><img src="{0}/golden.png" alt="golden"><img src="{0}/actual.png" alt="actual"></div>
<input type="range" value="50" aria-label="share that is golden"
 oninput="this.previousElementSibling.style.setProperty('--at', this.value + '%')">
<figcaption>golden on the left, actual on the right</figcaption></figure>
<figure><div class="pair blink"><img src="{0}/golden.png" alt="golden"><img src="{0}/actual.png" alt="actual"></div>
<figcaption>blink: golden and actual by turns</figcaption></figure>
<figure><img src="{0}/difference.png" alt="difference"><figcaption>difference, times 8</figcaption></figure>
</div>
)html";

}  // namespace

std::string golden_page(std::span<const GoldenFailure> failures) {
  std::string body;
  for (const GoldenFailure& failure : failures) {
    body +=
        fmt::format("<h2>{}</h2>\n<p>{}</p>\n", failure.name, chart::escape_html(failure.verdict));
    if (failure.pictures) body += fmt::format(fmt::runtime(kViews), failure.name);
  }
  return chart::html_page("Golden pictures that differ", body);
}

}  // namespace taut::golden
