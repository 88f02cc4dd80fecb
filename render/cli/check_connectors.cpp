#include "render/cli/check_connectors.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "scenes/scene/names.h"

namespace taut::cli::check_command {

namespace {

/// Particles that are joined with others, as connector and number.
using Joined = std::set<std::pair<std::size_t, std::size_t>>;

Joined joined_particles(const World& world) {
  Joined found;
  for (const Joint& joint : world.joints) {
    for (const auto& [connector, particle] : joint.particles) found.emplace(connector, particle);
  }
  return found;
}

std::string held_by(const World& world, const Connector& connector, std::size_t particle) {
  for (const Hold& hold : connector.holds) {
    if (hold.particle != particle) continue;
    if (hold.to.kind == Attachment::Kind::fixed) return "a fixed point";
    if (hold.to.kind == Attachment::Kind::path) return "a path";
    return world.bodies[hold.to.body].name;
  }
  return "nothing";
}

std::string ends_text(const World& world, std::size_t index, const Joined& joined) {
  const Connector& connector = world.connectors[index];
  const auto end = [&](std::size_t particle) -> std::string {
    const std::string holder = held_by(world, connector, particle);
    return holder == "nothing" && joined.contains({index, particle}) ? "a joint" : holder;
  };
  const std::string first = end(0), last = end(connector.particles() - 1);
  return first == "nothing" && last == "nothing" ? "free"
                                                 : fmt::format("held by {} and {}", first, last);
}

/// The connector's material, where it is more than rigid links.
std::string material_text(const Connector& connector) {
  if (connector.sections.empty()) return "";
  const Section& first = connector.sections.front();
  std::string text;
  if (connector.stretches()) text += fmt::format(", EA {:.6g} N", first.axial_stiffness);
  if (first.bending_stiffness > 0)
    text += fmt::format(", EI {:.6g} N m^2", first.bending_stiffness);
  if (first.twisting_stiffness > 0)
    text += fmt::format(", GJ {:.6g} N m^2", first.twisting_stiffness);
  if (connector.drag.across > 0 || connector.drag.along > 0) {
    text +=
        fmt::format(", drag {} across and {} along", connector.drag.across, connector.drag.along);
  }
  return text;
}

/// A net's connectors from `first` to before `last`.
std::string net_text(const World& world, std::size_t first, std::size_t last) {
  const auto& all = world.connectors;
  double shortest = all[first].length, longest = shortest, mass = 0;
  std::size_t particles = 0, held = 0;
  for (std::size_t c = first; c < last; ++c) {
    shortest = std::min(shortest, all[c].length);
    longest = std::max(longest, all[c].length);
    mass += all[c].mass;
    particles += all[c].particles();
    held += all[c].holds.size();
  }
  const auto joints = std::ranges::count_if(world.joints, [&](const Joint& joint) {
    return joint.particles.front().connector >= first && joint.particles.front().connector < last;
  });
  const std::string lengths = shortest == longest
                                  ? fmt::format("{:.6g} m", shortest)
                                  : fmt::format("{:.6g} to {:.6g} m", shortest, longest);
  return fmt::format("net {}: {} cords of {}, {:.6g} kg, {} particles{}, {} joints, {} held",
                     scenes::written_name(all[first].name), last - first, lengths, mass, particles,
                     material_text(all[first]), joints, held);
}

}  // namespace

std::vector<std::string> connector_lines(const World& world) {
  const Joined joined = joined_particles(world);
  const auto& all = world.connectors;
  const auto words = [&](std::size_t c) {
    return fmt::format("{} m, {:.6g} kg, {} particles{}, {}", all[c].length, all[c].mass,
                       all[c].particles(), material_text(all[c]), ends_text(world, c, joined));
  };
  std::vector<std::string> lines;
  for (std::size_t first = 0, last = 0; first < all.size(); first = last) {
    const std::string_view name = scenes::written_name(all[first].name);
    last = first + 1;
    if (all[first].name.ends_with("#1")) {
      while (last < all.size() && scenes::written_name(all[last].name) == name) ++last;
      lines.push_back(net_text(world, first, last));
      continue;
    }
    const std::string text = words(first);
    while (last < all.size() && scenes::written_name(all[last].name) == name && words(last) == text)
      ++last;
    lines.push_back(last == first + 1 ? fmt::format("connector {}: {}", all[first].name, text)
                                      : fmt::format("connectors {} to {}: each {}", all[first].name,
                                                    all[last - 1].name, text));
  }
  return lines;
}

program::Json material_json(const Connector& connector) {
  const Section& first = connector.sections.front();
  program::Json json;
  json["axial_stiffness_n"] =
      connector.stretches() ? program::Json(first.axial_stiffness) : program::Json();
  json["bending_stiffness_n_m2"] = first.bending_stiffness;
  json["twisting_stiffness_n_m2"] = first.twisting_stiffness;
  json["drag"] = {{"across", connector.drag.across}, {"along", connector.drag.along}};
  return json;
}

}  // namespace taut::cli::check_command
