#include "render/study/stability_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "render/chart/html_page.h"
#include "render/options/reproduce.h"
#include "render/program/json.h"

namespace taut::studies {
namespace {

/// In the order of MotionClass; dark to light from bad to good, so that grey print keeps the order.
std::vector<chart::CellKind> kinds() {
  return {{"not run", "-", 0xdddddd},
          {std::string(study::name_of(study::MotionClass::failed)), "F", 0x3b0f70},
          {std::string(study::name_of(study::MotionClass::stretched)), "S", 0x8c2981},
          {std::string(study::name_of(study::MotionClass::over_damped)), "D", 0xde4968},
          {std::string(study::name_of(study::MotionClass::accurate)), "A", 0xfcfdbf},
          {std::string(study::name_of(study::MotionClass::plausible)), "P", 0xfe9f6d}};
}

/// Half way to the neighbours on either side of value `i`; `log`: of the logarithms.
std::pair<double, double> edges(const std::vector<double>& values, std::size_t i, bool log) {
  const auto to = [&](double v) { return log ? std::log(v) : v; };
  const auto back = [&](double v) { return log ? std::exp(v) : v; };
  const double here = to(values[i]);
  const bool first = i == 0, last = i + 1 == values.size();
  double below = first ? 0.5 : (here - to(values[i - 1])) / 2;
  double above = last ? 0.5 : (to(values[i + 1]) - here) / 2;
  if (first && !last) below = above;
  if (last && !first) above = below;
  return {back(here - below), back(here + above)};
}

std::size_t place(const std::vector<double>& values, double value) {
  return static_cast<std::size_t>(std::ranges::find(values, value) - values.begin());
}

/// Where theory ends the stable steps, drawn over the map.
chart::Series law_of(const StabilityMap& map, const options::Contender& contender) {
  const MethodInfo& method = *contender.method;
  chart::Series law{fmt::format("theory, {}: {}", method.name, method.longest_step_law),
                    {0x000000, 1, 0},
                    true,
                    false,
                    false,
                    {}};
  for (std::size_t i = 0; i < map.axis.values.size(); ++i) {
    Settings settings = with_defaults(method, contender.candidate.settings);
    if (!map.axis.setting.empty()) settings[map.axis.setting] = map.axis.values[i];
    const double step = method.longest_step(map.worlds[i], settings);
    if (step > 0 && std::isfinite(step)) law.points.push_back({map.axis.values[i], step});
  }
  return law;
}

/// A cell that took less than its cap has more of it in the command: another run of it may take
/// longer.
std::string command_of(const StabilityStudy& study, const StabilityMap& map,
                       const options::Contender& contender, const MapCell& cell) {
  MethodChoice candidate = contender.candidate;
  candidate.settings[std::string(map_height(*contender.method)->name)] = cell.y;
  if (!map.axis.setting.empty()) candidate.settings[map.axis.setting] = cell.x;
  const World& world = map.worlds[place(map.axis.values, cell.x)];
  const bool scored = study.scored && world.connectors.front().particles() <= kMostForTruth;
  return options::classify_command(
      {study.scene, study.set},
      map.axis.changes ? map.axis.changes(cell.x) : std::vector<scenes::SceneChange>(),
      contender.label, candidate, study.duration,
      cell.over ? study.cap : std::max(study.cap, kTruthCap), scored);
}

/// Why a method has no map; empty: it has one.
std::string unmapped(const options::Contender& contender) {
  if (!map_height(*contender.method)) return "nothing to vary";
  return std::string(contender.method->missing);
}

chart::Panel panel_of(const StabilityStudy& study, const StabilityMap& map, std::size_t index) {
  const options::Contender& contender = study.contenders[index];
  chart::Panel panel;
  panel.title = contender.label;
  panel.x = {map.axis.label, map.axis.log};
  if (!map.axis.log) {
    for (const double value : map.axis.values)
      panel.x.tics.emplace_back(value, options::rounded(value));
  }
  if (const std::string why = unmapped(contender); !why.empty()) {
    panel.remarks.push_back({0.5, 0.5, why});
    return panel;
  }
  const SettingInfo* setting = map_height(*contender.method);
  const std::vector<double> heights = map_heights(*setting, study.quick);
  panel.y = {fmt::format("{} ({})", setting->name, setting->unit), true};
  panel.y.minimum = edges(heights, 0, true).first;
  panel.y.maximum = edges(heights, heights.size() - 1, true).second;
  for (const MapCell& cell : map.cells) {
    if (cell.contender != index) continue;
    const auto x = edges(map.axis.values, place(map.axis.values, cell.x), map.axis.log);
    const auto y = edges(heights, place(heights, cell.y), true);
    panel.cells.push_back({x.first, x.second, y.first, y.second,
                           static_cast<std::size_t>(cell.classification.motion_class), cell.x,
                           cell.y, command_of(study, map, contender, cell)});
  }
  if (contender.method->longest_step && setting->name == "step") {
    panel.series.push_back(law_of(map, contender));
  }
  return panel;
}

/// The methods that keep energy and length in the largest and in the smallest share of their runs.
std::string finding(const StabilityStudy& study, std::span<const StabilityMap> maps) {
  struct Share {
    std::string label;
    double good = 0, all = 0;
    double percent() const { return 100 * good / all; }
  };
  std::vector<Share> shares;
  for (std::size_t c = 0; c < study.contenders.size(); ++c) {
    Share share{study.contenders[c].label, 0, 0};
    for (const StabilityMap& map : maps) {
      for (const MapCell& cell : map.cells) {
        if (cell.contender != c) continue;
        // That depends on the machine: it says nothing about the method.
        if (cell.classification.motion_class == study::MotionClass::over_cap) continue;
        ++share.all;
        share.good += cell.classification.motion_class == study::MotionClass::accurate ||
                      cell.classification.motion_class == study::MotionClass::plausible;
      }
    }
    if (share.all > 0) shares.push_back(std::move(share));
  }
  if (shares.empty()) return "No method took part";
  const auto [worst, best] = std::ranges::minmax(shares, {}, &Share::percent);
  std::string line =
      fmt::format("{} keeps energy and length in {:.0f}% of its runs", best.label, best.percent());
  if (worst.percent() < best.percent()) {
    line += fmt::format(", {} in {:.0f}%", worst.label, worst.percent());
  }
  return line;
}

}  // namespace

std::string stability_finding(const StabilityStudy& study) {
  return finding(study, study.maps);
}

chart::Table stability_table(const StabilityStudy& study) {
  chart::Table table{{"map", "value", "method", "setting", "at", "class", "energy gained",
                      "energy lost", "stretch", "error (share of length)", "reason"},
                     {}};
  for (const StabilityMap& map : study.maps) {
    for (const MapCell& cell : map.cells) {
      const options::Contender& contender = study.contenders[cell.contender];
      const study::Classification& j = cell.classification;
      table.add({map.axis.name, options::rounded(cell.x), contender.label,
                 std::string(map_height(*contender.method)->name), options::rounded(cell.y),
                 std::string(study::name_of(j.motion_class)), options::rounded(j.gain),
                 options::rounded(j.loss), options::rounded(j.stretch), options::rounded(j.error),
                 cell.reason});
    }
  }
  return table;
}

chart::Chart stability_chart(const StabilityStudy& study, const StabilityMap& map) {
  chart::Chart chart;
  chart.title = fmt::format("By {}: {}", map.axis.label, finding(study, {&map, 1}));
  chart.subtitle = fmt::format(
      "{}, runs of {} s. The first class that fits: failed (diverged or gained 10% of the energy), "
      "stretched (a link by 1%), over-damped (lost 10%), accurate (within 1% of the length of "
      "truth{}), plausible; the last two keep energy and length. Not run: what takes more than {} "
      "s of "
      "CPU time. {}",
      study.title, options::rounded(study.duration),
      study.scored ? "" : "; not told from plausible in a quick map", options::rounded(study.cap),
      options::machine());
  chart.kinds = kinds();
  const auto has_map = [&](const options::Contender& contender) {
    return takes_part(contender, map.axis) && unmapped(contender).empty();
  };
  const bool any = std::ranges::any_of(study.contenders, has_map);
  std::string without;
  for (std::size_t c = 0; c < study.contenders.size(); ++c) {
    const options::Contender& contender = study.contenders[c];
    if (any ? has_map(contender) : takes_part(contender, map.axis))
      chart.panels.push_back(panel_of(study, map, c));
    else if (takes_part(contender, map.axis))
      without += fmt::format("{}{} ({})", without.empty() ? ". Without a map: " : ", ",
                             contender.label, unmapped(contender));
  }
  chart.subtitle += without;
  chart.columns = std::clamp<std::size_t>(chart.panels.size(), 1, 4);
  const std::size_t rows = (chart.panels.size() + chart.columns - 1) / chart.columns;
  chart.width = 1400;
  chart.height = static_cast<int>(180 + 290 * rows);
  return chart;
}

std::string stability_section(const StabilityStudy& study) {
  std::string body;
  for (const StabilityMap& map : study.maps) {
    body += chart::html_chart(stability_chart(study, map));
  }
  return body;
}

std::string stability_page(const StabilityStudy& study) {
  return chart::html_page(
      study.title + ": where each method fails",
      fmt::format("<p>Scene: {}. {}.</p>\n{}<h2>Every cell</h2>\n{}",
                  chart::escape_html(study.scene), chart::escape_html(options::machine()),
                  stability_section(study), chart::to_html(stability_table(study))));
}

std::string stability_json(const StabilityStudy& study) {
  program::Json json = {{"scene", study.scene},
                        {"machine", options::machine()},
                        {"duration_s", study.duration},
                        {"cpu_cap_s", study.cap},
                        {"cells", program::Json::array()}};
  for (const StabilityMap& map : study.maps) {
    for (const MapCell& cell : map.cells) {
      const options::Contender& contender = study.contenders[cell.contender];
      const study::Classification& j = cell.classification;
      json["cells"].push_back({{"map", map.axis.name},
                               {"x", cell.x},
                               {"method", contender.label},
                               {"setting", map_height(*contender.method)->name},
                               {"value", cell.y},
                               {"class", study::name_of(j.motion_class)},
                               {"energy_gain", program::number_or_null(j.gain)},
                               {"energy_loss", program::number_or_null(j.loss)},
                               {"stretch_max", program::number_or_null(j.stretch)},
                               {"rms_error", program::number_or_null(j.error)},
                               {"reason", cell.reason}});
    }
  }
  return program::json_text(json) + "\n";
}

}  // namespace taut::studies
