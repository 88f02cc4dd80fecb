#include "render/golden/golden.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "render/golden/snapshot_json.h"
#include "scenes/files/regular_file.h"

namespace taut::golden {
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

}  // namespace taut::golden
