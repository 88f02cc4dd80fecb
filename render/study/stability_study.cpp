#include "render/study/stability_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <span>

#include "render/base/child.h"
#include "render/base/interrupt.h"
#include "render/chart/html_page.h"
#include "render/options/method_options.h"
#include "render/program/output.h"
#include "render/program/part.h"
#include "render/study/study_target.h"
#include "scenes/files/error.h"

namespace taut::studies {
namespace {

std::vector<double> thinned(std::vector<double> values, bool quick) {
  if (!quick) return values;
  std::vector<double> some;
  for (std::size_t i = 0; i < values.size(); i += 2) some.push_back(values[i]);
  return some;
}

/// Mass (kg) at the last particle, beside its own.
double load_of(const scenes::Scene& scene) {
  const Connector& rope = scene.world.connectors.front();
  const std::size_t last = rope.particles() - 1;
  for (const Hold& hold : rope.holds) {
    if (hold.particle != last) continue;
    const bool free =
        hold.to.kind == Attachment::Kind::body && !scene.world.bodies[hold.to.body].driven();
    return free ? scene.world.bodies[hold.to.body].mass_properties.mass : 0;
  }
  return rope.particle_mass.back() - rope.mass / static_cast<double>(rope.particles());
}

std::string toml(const Vec3& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
}

MapAxis mass_ratio(const scenes::Scene& scene, double load) {
  const std::string key = options::connector_key(scene, "mass");
  return {"mass_ratio",
          "mass of the load / mass of the rope",
          true,
          {1, 10, 100, 1e3, 1e4, 1e5, 1e6},
          [key, load](double ratio) {
            return std::vector<scenes::SceneChange>{{key, fmt::format("{:.17g}", load / ratio)}};
          },
          "",
          true};
}

MapAxis particles(const scenes::Scene& scene) {
  // Where a free body hangs from what has a winch, the last link keeps its length.
  const double least = scene.world.connectors.front().winch ? 3 : 2;
  return {"particles",
          "particles",
          true,
          {least, 5, 11, 41, 101, 321, 1000},
          [key = options::connector_key(scene, "particles")](double n) {
            return std::vector<scenes::SceneChange>{{key, fmt::format("{:.0f}", n)}};
          },
          "",
          true};
}

MapAxis start_angle(const scenes::Scene& scene) {
  return {"start_angle",
          "start, degrees from hanging",
          false,
          {5, 30, 60, 90, 120, 150, 175},
          [key = options::connector_key(scene, "start")](double degrees) {
            const double a = degrees * std::numbers::pi / 180;
            return std::vector<scenes::SceneChange>{
                {key, fmt::format("{{ direction = {} }}", toml({std::sin(a), -std::cos(a), 0}))}};
          },
          ""};
}

/// The first end goes up by half the length from rest to rest: the lower end whips.
MapAxis driven_speed(const scenes::Scene& scene) {
  const Connector& rope = scene.world.connectors.front();
  return {"driven_speed",
          "peak speed of the driven end (m/s)",
          true,
          {0.1, 0.3, 1, 3, 10, 30, 100},
          [from = options::connector_key(scene, "from"), at = rope.holds.front().to.point,
           travel = rope.length / 2](double speed) {
            const double time = 1.875 * travel / speed;  // a quintic's peak is 15/8 of its mean
            return std::vector<scenes::SceneChange>{
                {"paths.study", fmt::format("{{ keys = [ {{ t = 0, position = {}, ease = true }}, "
                                            "{{ t = {:.17g}, position = {}, ease = true }} ] }}",
                                            toml(at), time, toml(at + Vec3(0, travel, 0)))},
                {from, "{ path = \"study\" }"}};
          },
          ""};
}

MapAxis stiffness() {
  return {"stiffness", "stiffness of a link (N/m)",
          true,        {1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8},
          nullptr,     "stiffness",
          true};
}

/// A stiffness of the rope's material, which its scene gives under `key`: `unit` times powers of
/// ten.
MapAxis material_axis(const scenes::Scene& scene, const std::string& key, const std::string& label,
                      double unit, double from, double until) {
  MapAxis axis{key,
               label,
               true,
               {},
               [key = options::connector_key(scene, key)](double value) {
                 return std::vector<scenes::SceneChange>{{key, fmt::format("{:.17g}", value)}};
               },
               ""};
  const double decade = std::pow(10, std::ceil(std::log10(unit)));
  for (double share = from; share < 2 * until; share *= 10) axis.values.push_back(share * decade);
  return axis;
}

/// The stiffnesses that the rope's sections have: EA in its load's and its own weight, EI in that
/// times the length squared.
void add_material_axes(const scenes::Scene& scene, std::vector<MapAxis>& axes) {
  const Connector& rope = scene.world.connectors.front();
  if (rope.sections.empty()) return;
  const Section& section = rope.sections.front();
  const double weight = (rope.mass + load_of(scene)) * scene.world.gravity.norm();
  if (!(weight > 0 && rope.length > 0)) return;
  if (std::isfinite(section.axial_stiffness)) {
    axes.push_back(
        material_axis(scene, "axial_stiffness", "axial stiffness EA (N)", weight, 10, 1e6));
  }
  if (section.bending_stiffness > 0) {
    axes.push_back(material_axis(scene, "bending_stiffness", "bending stiffness EI (N m²)",
                                 weight * rope.length * rope.length, 1e-6, 1));
  }
}

/// Whether the scene can have the value: its start may need more particles, and a stiffness follow
/// from another key.
bool is_possible(const options::StudyOptions& options, const MapAxis& axis, double value) {
  try {
    if (axis.changes) options::study_scene(options, axis.changes(value));
    return true;
  } catch (const scenes::BadScene&) {
    return false;
  }
}

}  // namespace

std::vector<MapAxis> map_axes(const options::StudyOptions& options, const scenes::Scene& scene) {
  const Connector& rope = scene.world.connectors.front();
  std::vector<MapAxis> axes;
  if (const double load = load_of(scene); load > 0) axes.push_back(mass_ratio(scene, load));
  axes.push_back(particles(scene));
  axes.push_back(stiffness());
  add_material_axes(scene, axes);
  if (rope.holds.size() == 1 && rope.holds.front().particle == 0 &&
      rope.holds.front().to.kind == Attachment::Kind::fixed) {
    axes.push_back(driven_speed(scene));
    axes.push_back(start_angle(scene));
  }
  for (MapAxis& axis : axes) {
    axis.values = thinned(axis.values, options.quick);
    std::erase_if(axis.values, [&](double value) { return !is_possible(options, axis, value); });
  }
  std::erase_if(axes, [](const MapAxis& axis) { return axis.values.size() < 2; });
  return axes;
}

bool takes_part(const options::Contender& contender, const MapAxis& axis) {
  return axis.setting.empty() || find_setting(*contender.method, axis.setting);
}

const SettingInfo* map_height(const MethodInfo& method) {
  const SettingInfo* step = nullptr;
  const SettingInfo* swept = nullptr;
  for (const SettingInfo& setting : method.settings) {
    if (!std::holds_alternative<double>(setting.fallback)) continue;
    if (setting.name == "step") step = &setting;
    if (!setting.sweep.empty() && !swept) swept = &setting;
  }
  // A method that has a tolerance beside its step is swept by that.
  return step && (!swept || swept == step || method.longest_step) ? step : swept;
}

std::vector<double> map_heights(const SettingInfo& setting, bool quick) {
  std::vector<double> values;
  if (setting.name == "step") {
    for (double step = 1.0 / 60; step > 1.0 / 20000; step /= 2) values.push_back(step);
  } else {
    for (const Setting& value : setting.sweep) values.push_back(std::get<double>(value));
  }
  std::ranges::sort(values);
  if (setting.name != "step") {
    // Sweeps go over many decades: a value in each is a row that can be read.
    std::vector<double> apart;
    for (const double value : values) {
      if (apart.empty() || value > 9 * apart.back()) apart.push_back(value);
    }
    values = std::move(apart);
  }
  return thinned(std::move(values), quick);
}

namespace {

/// CPU time shared out evenly among pieces of work: the rest of one goes to the others.
class Shares {
 public:
  Shares(double seconds, std::size_t pieces)
      : end_(render::process_seconds() + seconds), pieces_(pieces) {}
  /// The next piece's share, s.
  double next() {
    const double left = std::max(0.0, end_ - render::process_seconds());
    return left / static_cast<double>(std::max<std::size_t>(1, pieces_--));
  }

 private:
  double end_;  // s of CPU time of this process
  std::size_t pieces_;
};

/// One value of a map's axis.
struct Column {
  study::Problem problem;
  std::optional<truth::Reference> reference;
};

Column column_of(const options::StudyOptions& options, const MapAxis& axis, double value,
                 double duration, bool with_truth) {
  const scenes::Scene scene = axis.changes ? options::study_scene(options, axis.changes(value))
                                           : options::study_scene(options);
  Column column{{scene.world, study::frame_times(duration, scene.fps)}, {}};
  const Connector& rope = scene.world.connectors.front();
  if (with_truth && rope.particles() <= kMostForTruth) {
    column.reference = quick_reference(column.problem, 0.01 * rope.length, kTruthCap);
  }
  return column;
}

MapCell cell_from(std::size_t contender, double x, double y,
                  const std::vector<std::string>& cells) {
  MapCell cell{contender, x, y, {}, cells.at(5), cells.at(6) == "over"};
  cell.classification.motion_class =
      static_cast<study::MotionClass>(program::number_in(cells.at(0)));
  cell.classification.gain = program::number_in(cells.at(1));
  cell.classification.loss = program::number_in(cells.at(2));
  cell.classification.stretch = program::number_in(cells.at(3));
  cell.classification.error = program::number_in(cells.at(4));
  return cell;
}

std::vector<std::string> cells_of(const MapCell& cell) {
  const study::Classification& j = cell.classification;
  return {std::to_string(static_cast<int>(j.motion_class)),
          program::exact(j.gain),
          program::exact(j.loss),
          program::exact(j.stretch),
          program::exact(j.error),
          cell.reason,
          cell.over ? "over" : "in time"};
}

std::string key_of(const MapAxis& axis, const options::Contender& contender, double x, double y) {
  return fmt::format("{} {} {} {}", axis.name, contender.label, program::exact(x),
                     program::exact(y));
}

/// The heights of a contender's cells, from cheap to dear.
std::vector<double> heights_of(const options::Contender& contender, bool quick) {
  std::vector<double> heights = map_heights(*map_height(*contender.method), quick);
  std::ranges::reverse(heights);
  return heights;
}

MapCell cell_not_run(std::size_t index, double x, double y) {
  MapCell cell{index, x, y, {}, "not run: a cheaper one was over its CPU cap", true};
  cell.classification.motion_class = study::MotionClass::over_cap;
  return cell;
}

/// A run's place in the map, with its class.
MapCell cell_of(const MapAxis& axis, std::size_t index, const StabilityStudy& study,
                const Column& column, double x, double y, double cap) {
  const options::Contender& contender = study.contenders[index];
  MethodChoice candidate = contender.candidate;
  candidate.settings[std::string(map_height(*contender.method)->name)] = y;
  if (!axis.setting.empty()) candidate.settings[axis.setting] = x;
  const study::Run result = taut::study::run(column.problem, candidate, cap);
  const truth::Reference* reference = column.reference ? &*column.reference : nullptr;
  return {index,
          x,
          y,
          study::classify(column.problem, result, reference),
          result.reason,
          result.end == study::Run::End::over_cap};
}

/// Runs a contender over a map's cells, or takes them from the journal. Within `seconds` of CPU
/// time; a cell is not run where one that costs less was over its cap.
void fill(StabilityMap& map, std::size_t index, const StabilityStudy& study,
          const std::vector<Column>& columns, double seconds, program::Journal& journal,
          const std::function<void()>& finished) {
  const options::Contender& contender = study.contenders[index];
  const std::vector<double> heights = heights_of(contender, study.quick);
  std::vector<bool> over_before(heights.size(), false);
  const double start = render::process_seconds();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double x = map.axis.values[i];
    bool over = false;  // in this column
    for (std::size_t h = 0; h < heights.size(); ++h) {
      render::stop_if_interrupted();
      const double y = heights[h];
      const std::string key = key_of(map.axis, contender, x, y);
      over = over || (map.axis.dearer && over_before[h]);
      const double left = seconds - (render::process_seconds() - start);
      MapCell cell = cell_not_run(index, x, y);
      const auto* const cells = journal.find(key);
      if (cells && !over) {
        cell = cell_from(index, x, y, *cells);
      } else if (!cells) {
        if (!over && left > 0) {
          cell = cell_of(map.axis, index, study, columns[i], x, y, std::min(left, study.cap));
        }
        journal.add(key, cells_of(cell));
      }
      over = over_before[h] = cell.over;
      map.cells.push_back(std::move(cell));
      finished();
    }
  }
}

bool is_mapped(const options::Contender& contender, const MapAxis& axis) {
  return contender.method->missing.empty() && map_height(*contender.method) &&
         takes_part(contender, axis);
}

/// Where a cell is in the maps.
struct CellPlace {
  std::size_t axis = 0, column = 0, contender = 0, height = 0;
};

/// All cells, neighbours in a column beside each other: they share its truth.
std::vector<CellPlace> all_places(const StabilityStudy& study, const std::vector<MapAxis>& axes) {
  std::vector<CellPlace> places;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    for (std::size_t i = 0; i < axes[a].values.size(); ++i) {
      for (std::size_t c = 0; c < study.contenders.size(); ++c) {
        if (!is_mapped(study.contenders[c], axes[a])) continue;
        const std::size_t heights = heights_of(study.contenders[c], study.quick).size();
        for (std::size_t h = 0; h < heights; ++h) places.push_back({a, i, c, h});
      }
    }
  }
  return places;
}

program::Pieces shared_work(const StabilityStudy& study, const std::vector<MapAxis>& axes,
                            const std::vector<CellPlace>& places) {
  program::Pieces pieces{"stability", "cells", program::Share::neighbours, {}};
  for (const CellPlace& at : places) {
    const options::Contender& contender = study.contenders[at.contender];
    pieces.keys.push_back(key_of(axes[at.axis], contender, axes[at.axis].values[at.column],
                                 heights_of(contender, study.quick)[at.height]));
  }
  return pieces;
}

}  // namespace

StabilityStudy stability_study(const options::StudyOptions& options, const scenes::Scene& scene) {
  StabilityStudy study;
  study.scene = options.scene;
  study.title = scene.title;
  study.set = options.inputs.set;
  study.quick = options.quick;
  study.scored = !options.quick;
  study.duration = options.quick ? 0.5 : 1.0;
  study.contenders = options::chosen_contenders(options);
  const std::size_t total = all_places(study, map_axes(options, scene)).size();
  // Most cells take far less than their share, so a cell may take several.
  study.cap = 8 * options.budget / static_cast<double>(std::max<std::size_t>(1, total));
  return study;
}

program::Journal map_all(StabilityStudy& study, const options::StudyOptions& options,
                         const scenes::Scene& scene, const std::filesystem::path& folder,
                         const std::string& journal_name, const program::Common& common,
                         const std::function<void(const StabilityMap&)>& mapped) {
  const bool merge = options.part.merge;
  const std::vector<MapAxis> axes = map_axes(options, scene);
  const std::vector<CellPlace> places = all_places(study, axes);
  std::size_t pieces = 0;
  for (const MapAxis& axis : axes) {
    pieces += std::size_t(std::ranges::count_if(
        study.contenders, [&](const options::Contender& one) { return is_mapped(one, axis); }));
  }
  program::Journal journal =
      merge ? program::merged_journal(shared_work(study, axes, places), folder,
                                      options::stamp_of(options))
            : program::Journal(folder / journal_name, options::stamp_of(options));
  if (!common.quiet && journal.kept() > 0 && !merge) {
    program::note("going on after {} cells of maps that were stopped\n", journal.kept());
  }
  {
    program::Progress progress(merge ? "merging" : "mapping", "cells", places.size(), common.quiet);
    Shares shares(options.budget, pieces);
    std::size_t done = 0;
    for (const MapAxis& axis : axes) {
      StabilityMap map{axis, {}, {}};
      std::vector<Column> columns;
      for (const double value : axis.values) {
        render::stop_if_interrupted();
        columns.push_back(column_of(options, axis, value, study.duration, study.scored && !merge));
        map.worlds.push_back(columns.back().problem.world);
      }
      for (std::size_t c = 0; c < study.contenders.size(); ++c) {
        if (!is_mapped(study.contenders[c], axis)) continue;
        fill(map, c, study, columns, shares.next(), journal, [&] { progress.update(++done); });
      }
      if (mapped) mapped(map);
      study.maps.push_back(std::move(map));
    }
  }
  return journal;
}

int map_part(const StabilityStudy& study, const options::StudyOptions& options,
             const scenes::Scene& scene, const program::Common& common) {
  const std::vector<MapAxis> axes = map_axes(options, scene);
  const std::vector<CellPlace> places = all_places(study, axes);
  std::optional<Column> column;
  CellPlace of_column;
  const auto work = [&](std::size_t i, const program::Journal& journal) {
    const CellPlace at = places[i];
    const MapAxis& axis = axes[at.axis];
    const options::Contender& contender = study.contenders[at.contender];
    const std::vector<double> heights = heights_of(contender, study.quick);
    const double x = axis.values[at.column], y = heights[at.height];
    // Runs that merging leaves out need not be made, as far as this part can tell.
    const auto is_over = [&](double left, double below) {
      const auto* cells = journal.find(key_of(axis, contender, left, below));
      return cells && cell_from(at.contender, left, below, *cells).over;
    };
    if ((at.height > 0 && is_over(x, heights[at.height - 1])) ||
        (axis.dearer && at.column > 0 && is_over(axis.values[at.column - 1], y))) {
      return cells_of(cell_not_run(at.contender, x, y));
    }
    if (!column || of_column.axis != at.axis || of_column.column != at.column) {
      column = column_of(options, axis, x, study.duration, study.scored);
      of_column = at;
    }
    return cells_of(cell_of(axis, at.contender, study, *column, x, y, study.cap));
  };
  return program::do_part(options.part, shared_work(study, axes, places),
                          options::study_folder(options), options::stamp_of(options), common, work);
}

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
