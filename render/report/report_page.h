// The page of `taut report`: everything that is measured of some scenes, in one file.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "render/program/command.h"
#include "render/study/accuracy_page.h"
#include "render/study/stability_study.h"
#include "scenes/scene/scene.h"
#include "sim/evaluation/run.h"
#include "sim/truth/truth.h"

namespace taut::report {

// One run against the truth: its cost and its error.

/// An error at a time (s), as a share of the length.
struct ErrorAt {
  double time = 0, error = 0;
};

/// RMS over the particles of each frame, up to the horizon; as far as the run came.
std::vector<ErrorAt> errors_over_time(const study::Run& run, const truth::Reference& reference,
                                      double length);

/// Scores the scene's own method down to errors of `share` of the length, as `taut chart` does. The
/// result as JSON: scene, method, settings, horizon_s, self_error, rms_error,
/// cpu_ms_per_simulated_s, diverged_at_s, errors. Throws Misuse where there is nothing to score.
nlohmann::ordered_json run_score(const scenes::Scene& scene, double share);

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

// Small clips of every method, for a page.

/// Makes a clip of each contender that is a method at its own settings, in folders of `folder`,
/// each of at most `most` bytes. A method whose simulation diverges, or that the scene is not for,
/// has none.
std::vector<ReportClip> report_clips(const options::StudyOptions& options,
                                     const std::vector<options::Contender>& contenders,
                                     const std::filesystem::path& folder, std::size_t most,
                                     const program::Common& common);
/// Makes a picture of the middle of the clip, by the scene's own method, in `folder`. Empty where
/// the simulation diverges.
std::filesystem::path report_picture(const options::StudyOptions& options,
                                     const std::filesystem::path& folder,
                                     const program::Common& common);

}  // namespace taut::report
