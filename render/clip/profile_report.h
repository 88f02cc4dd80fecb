// What the stages of drawing a frame cost, as a table and as JSON.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "render/chart/table.h"
#include "render/draw/stage_floor.h"
#include "render/gl/profile.h"

namespace taut::cli {

/// The stages' medians, the share of the frames that went through each (scenery is drawn anew only
/// where the camera moved), and what they add up to in a mean frame.
Table stage_table(const Profile& profile, const Profile& unlit, const StageFloor& floor,
                  std::size_t drawn);
nlohmann::ordered_json stage_json(const Profile& profile, const Profile& unlit,
                                  const StageFloor& floor);

}  // namespace taut::cli
