#include "render/golden/golden.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "render/golden/snapshot_json.h"
#include "scenes/files/regular_file.h"
#include "sim/motion/hash.h"

namespace taut::golden {
namespace {

using Json = nlohmann::ordered_json;

/// The first line of /proc/cpuinfo that starts with `key`, without it.
std::string processor_line(const std::string& key) {
  std::ifstream file("/proc/cpuinfo");
  file.exceptions(std::ios::badbit);  // or running out of memory would end the file
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with(key) && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

Renderer renderer_of(const std::string& description) {
  // "WAY: NAME (LLVM 15.0.6, 256 bits), OpenGL 4.5": OSMesa and EGL may lead to the same driver.
  const std::size_t colon = description.find(": ");
  std::string driver = colon == std::string::npos ? description : description.substr(colon + 2);
  std::string width = "unknown width";
  const std::size_t end = driver.find(" bits");
  const std::size_t begin = end == std::string::npos ? end : driver.rfind(", ", end);
  if (begin != std::string::npos) {
    width = driver.substr(begin + 2, end - begin - 2) + " bits";
    driver.erase(begin, end + 5 - begin);
  }
  return {std::move(driver), fmt::format("{}, vectors of {}", processor(), width)};
}

std::string processor() {
  return fmt::format("{}, features {:016x}", processor_line("model name"),
                     Hash().text(processor_line("flags")).value());
}

std::uint64_t pixel_hash(const picture::Picture& picture) {
  return Hash()
      .number(picture.width)
      .number(picture.height)
      .bytes(picture.pixels.data(), picture.pixels.size())
      .value();
}

GoldenRecord read_golden(const std::filesystem::path& file) {
  return golden_from(
      scenes::read_regular_file(file, kMaxRecordBytes, "a record of a golden picture"), file);
}

GoldenRecord golden_from(const std::string& text, const std::filesystem::path& file) {
  try {
    const nlohmann::json record = nlohmann::json::parse(text);
    return {{record.at("driver").get<std::string>(), record.at("processor").get<std::string>()},
            std::stoull(record.at("pixels").get<std::string>(), nullptr, 16),
            snapshot_from(record.at("state"))};
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw scenes::BadAsset(
        fmt::format("{}: no record of a golden picture: {}", file.string(), error.what()));
  }
}

std::string golden_text(const GoldenRecord& record) {
  const Json json_record = {{"driver", record.renderer.driver},
                            {"processor", record.renderer.processor},
                            {"pixels", fmt::format("{:016x}", record.pixels)},
                            {"state", to_json(record.state)}};
  return json_record.dump() + "\n";
}

std::string_view name_of(Tier tier) {
  switch (tier) {
    case Tier::exact:
      return "every pixel equal";
    case Tier::same_driver:
      return "same driver, other processor";
    case Tier::other_driver:
      return "another driver";
  }
  return "";
}

PictureComparison compare(const picture::Picture& actual, const Renderer& renderer,
                          const picture::Picture& golden, const GoldenRecord& record) {
  PictureComparison result;
  result.difference = difference(actual, golden);
  if (renderer.driver != record.renderer.driver) {
    result.tier = Tier::other_driver;
    result.same = same_picture(result.difference);
  } else if (renderer.processor != record.renderer.processor) {
    result.tier = Tier::same_driver;
    result.same = same_rendering(result.difference);
  } else {
    result.same = pixel_hash(actual) == record.pixels && pixel_hash(golden) == record.pixels;
  }
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
