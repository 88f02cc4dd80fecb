#include "render/clip/profile_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace taut::clips {

chart::Table stage_table(const gl::Profile& profile, const gl::Profile& unlit,
                         const draw::StageFloor& floor, std::size_t drawn) {
  chart::Table table{{"stage", "wall ms", "CPU ms", "floor ms", "% of frames"}, {}};
  gl::Profile::Times sum;
  for (const gl::Profile::Stage& stage : profile.stages()) {
    const auto [cpu, wall] = gl::median(stage);
    const double share =
        std::min(double(stage.frames.size()) / double(std::max<std::size_t>(drawn, 1)), 1.0);
    const std::optional<double> least = floor.of(stage.name, unlit);
    table.add({stage.name, fmt::format("{:.2f}", 1e3 * wall), fmt::format("{:.2f}", 1e3 * cpu),
               least ? fmt::format("{:.2f}", 1e3 * *least) : "",
               fmt::format("{:.0f}", 100 * share)});
    sum.cpu += share * cpu;
    sum.wall += share * wall;
  }
  table.add({"one after another", fmt::format("{:.2f}", 1e3 * sum.wall),
             fmt::format("{:.2f}", 1e3 * sum.cpu), "", ""});
  return table;
}

nlohmann::ordered_json stage_json(const gl::Profile& profile, const gl::Profile& unlit,
                                  const draw::StageFloor& floor) {
  auto stages = nlohmann::ordered_json::array();
  for (const gl::Profile::Stage& stage : profile.stages()) {
    const auto [cpu, wall] = gl::median(stage);
    stages.push_back(
        {{"stage", stage.name}, {"wall", wall}, {"cpu", cpu}, {"frames", stage.frames.size()}});
    if (const auto least = floor.of(stage.name, unlit)) stages.back()["floor"] = *least;
  }
  return stages;
}

}  // namespace taut::clips
