// The costs of the stages of drawing a frame, as a table and as JSON.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "render/chart/table.h"
#include "render/draw/stage_floor.h"
#include "render/gl/profile.h"

namespace taut::clips {

/// The stages' medians, the share of the frames that went through each (scenery is drawn anew only
/// where the camera moved), and what they add up to in a mean frame.
chart::Table stage_table(const gl::Profile& profile, const gl::Profile& unlit,
                         const draw::StageFloor& floor, std::size_t drawn);
nlohmann::ordered_json stage_json(const gl::Profile& profile, const gl::Profile& unlit,
                                  const draw::StageFloor& floor);

}  // namespace taut::clips
