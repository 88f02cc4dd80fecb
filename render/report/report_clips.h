// Small clips of every method, for a page.
#pragma once

#include "render/program/command.h"
#include "render/report/report_page.h"

namespace taut::report {

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
