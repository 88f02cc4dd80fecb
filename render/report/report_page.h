// The page of `taut report`: everything that is measured of some scenes, in one file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/report/run_score.h"
#include "render/study/accuracy_page.h"
#include "render/study/stability_maps.h"

namespace taut::report {

/// A method's clip.
struct ReportClip {
  std::string method;
  std::string command;         // that makes it
  std::filesystem::path file;  // .webm; empty: there is none
  std::string words;           // why there is none
};

/// A method's errors over time, at its own settings.
struct ReportErrors {
  options::Contender contender;
  std::vector<ErrorAt> errors;
};

struct SceneReport {
  studies::AccuracyStudy accuracy;
  studies::StabilityStudy stability;  // no maps: the scene has pins, which maps do not follow
  std::vector<ReportErrors> errors;
  std::vector<ReportClip> clips;
  std::filesystem::path picture;  // .webp; empty: there is none
};

/// The most bytes that a page may have.
inline constexpr std::size_t kMostBytes = 5'000'000;

/// The page, with its clips in it. Throws BadAsset where one cannot be read.
std::string report_page(const std::vector<SceneReport>& scenes);

}  // namespace taut::report
