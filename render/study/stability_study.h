// The runs behind stability maps: all of them, those of a part, and the merge of parts.
#pragma once

#include <filesystem>
#include <functional>

#include "render/program/command.h"
#include "render/program/journal.h"
#include "render/study/stability_maps.h"

namespace taut::studies {

/// The subject of a study of the options, without cells.
StabilityStudy stability_study(const options::StudyOptions& options, const scenes::Scene& scene);

/// Fills the maps within the options' budget, or from all parts where they say so, and calls
/// `mapped` for each that is complete. Cells that were done are in `journal` of the folder; returns
/// it, to be finished once results are written.
program::Journal map_all(StabilityStudy& study, const options::StudyOptions& options,
                         const scenes::Scene& scene, const std::filesystem::path& folder,
                         const std::string& journal, const program::Common& common,
                         const std::function<void(const StabilityMap&)>& mapped);

/// The cells of the options' part.
int map_part(const StabilityStudy& study, const options::StudyOptions& options,
             const scenes::Scene& scene, const program::Common& common);

}  // namespace taut::studies
