#include "render/study/stability_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace taut::studies
