#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/reader/reader.h"

namespace taut::scenes {

namespace {

constexpr double kAirDensity = 1.225;   // kg/m^3, at sea level and 15 degrees
constexpr double kPoissonsRatio = 0.3;  // of most metals; rubber has nearly 0.5

double area(double diameter) {
  return std::numbers::pi * diameter * diameter / 4;
}

/// The share of its diameter that a connector has at the middle of a link.
double taper_at(const Value* taper, double share) {
  if (!taper) return 1;
  const double place = share * static_cast<double>(taper->children.size() - 1);
  const std::size_t before = std::min(static_cast<std::size_t>(place), taper->children.size() - 2);
  const double ahead = place - static_cast<double>(before);
  return (1 - ahead) * taper->children[before].number + ahead * taper->children[before + 1].number;
}

/// Half of each link's mass at either end; links are as heavy as `weight` says, together as before.
void weigh_by_links(const std::vector<double>& weight, Connector& connector) {
  double sum = 0;
  for (const double link : weight) sum += link;
  std::ranges::fill(connector.particle_mass, 0.0);
  for (std::size_t k = 0; k < weight.size(); ++k) {
    const double half = connector.mass * weight[k] / sum / 2;
    connector.particle_mass[k] += half;
    connector.particle_mass[k + 1] += half;
  }
}

void check(const Document& document, const Value& value, const Connector& connector,
           const Value& key) {
  if (connector.model == ConnectorModel::span) {
    document.fail_at_key(key, "needs model = \"links\", a massless span has none");
  }
  if (connector.length == 0) {
    document.fail_at_key(key, "needs links that have a length, a joint has none");
  }
  if (key.name == "drag" && !document.root.find("air")) {
    document.fail_at_key(key, "needs a table air");
  }
  const auto needs = [&](std::string_view one, std::string_view other) {
    const Value* found = value.find(one);
    if (found && !value.find(other) && !value.find("material")) {
      document.fail_at_key(*found, fmt::format("needs {} or material", other));
    }
  };
  needs("axial_damping", "axial_stiffness");
  needs("rest_curvature", "bending_stiffness");
  needs("twisting_stiffness", "bending_stiffness");
  needs("twisting_damping", "twisting_stiffness");
  needs("rest_twist", "twisting_stiffness");
  const Value *twist = value.find("rest_twist"), *curvature = value.find("rest_curvature");
  if (twist && twist->number != 0 && curvature) {
    document.fail_at_key(*twist,
                         "stands beside rest_curvature: what is curved at rest moves in a "
                         "plane and is not twisted");
  }
}

/// Whether its last particle is joined to its first.
bool is_loop(const Value& connector) {
  const Value* to = connector.find("to");  // a net has none
  const Value* joined = to ? to->find("connector") : nullptr;
  return joined && joined->text == connector.name &&
         number_or(*connector.find("to"), "at", -1) == 0;
}

bool is_clamped(const Value& connector) {
  return connector.find("from")->find("clamp") && connector.find("to")->find("clamp");
}

void check_turn(const Document& document, const Value& connector, const Value& turn) {
  const auto fails = [&](const char* what) { document.fail_at_key(turn, what); };
  if (!connector.find("twisting_stiffness") && !connector.find("material")) {
    fails("needs twisting_stiffness or material");
  }
  if (!is_clamped(connector)) fails("needs a clamp at both ends: nothing twists without");
  if (connector.find("rest_curvature")) {
    fails("turns a connector with rest_curvature, which moves in a plane and is not twisted");
  }
}

}  // namespace

double mass_of(const Value& connector, double length) {
  const Value* material = connector.find("material");
  if (!material) return connector.find("mass")->number;
  return material->find("density")->number * area(material->find("diameter")->number) * length;
}

void read_cord(const Document& document, const Value& value, Connector& connector) {
  connector.restitution = number_or(value, "restitution", 0);
  connector.radius =
      number_or(value, "radius", number_or(value, "diameter", ConnectorLook().diameter) / 2);
  connector.links_touch = text_or(value, "contact", "beads") == "links";
  const Value* taper = value.find("taper");
  const Value* first = nullptr;
  for (const std::string_view key :
       {"axial_stiffness", "axial_damping", "bending_stiffness", "bending_damping",
        "rest_curvature", "twisting_stiffness", "twisting_damping", "rest_twist", "material",
        "drag", "taper"}) {
    if (!first) first = value.find(key);
  }
  for (const char* end : {"from", "to"}) {
    const Value* held = value.find(end);  // a net has none
    if (!held) continue;
    const Value* clamp = held->find("clamp");
    if (clamp && !value.find("bending_stiffness") && !value.find("material")) {
      document.fail_at_key(*clamp,
                           "needs bending_stiffness or material: what bends freely has no "
                           "direction at its end");
    }
    if (const Value* turn = held->find("turn")) check_turn(document, value, *turn);
  }
  // The particle where a loop closes is as heavy as the others.
  if (is_loop(value)) weigh_by_links(std::vector<double>(connector.links(), 1.0), connector);
  if (!first) return;
  check(document, value, connector, *first);
  Section section;
  section.axial_stiffness = number_or(value, "axial_stiffness", section.axial_stiffness);
  section.axial_damping = number_or(value, "axial_damping", 0);
  section.bending_stiffness = number_or(value, "bending_stiffness", 0);
  section.bending_damping = number_or(value, "bending_damping", 0);
  section.rest_curvature = vec3_or(value, "rest_curvature", Vec3::Zero());
  section.twisting_stiffness = number_or(value, "twisting_stiffness", 0);
  section.twisting_damping = number_or(value, "twisting_damping", 0);
  section.rest_twist = number_or(value, "rest_twist", 0);
  section.diameter = 2 * connector.radius;
  if (const Value* material = value.find("material")) {
    const double modulus = material->find("youngs_modulus")->number;
    section.diameter = material->find("diameter")->number;
    section.axial_stiffness = modulus * area(section.diameter);
    section.bending_stiffness =
        section.axial_stiffness * section.diameter * section.diameter / 16;  // pi d^4 / 64
    section.twisting_stiffness =  // E / 2 (1 + nu) times twice the area's second moment
        section.bending_stiffness / (1 + number_or(*material, "poissons_ratio", kPoissonsRatio));
  }
  connector.sections.assign(connector.links(), section);
  std::vector<double> weight;
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const double middle = (static_cast<double>(k) + 0.5) / static_cast<double>(connector.links());
    const double thick = taper_at(taper, middle), squared = thick * thick;
    Section& own = connector.sections[k];
    own.axial_stiffness *= squared;
    own.axial_damping *= squared;
    own.bending_stiffness *= squared * squared;
    own.bending_damping *= squared * squared;
    own.twisting_stiffness *= squared * squared;
    own.twisting_damping *= squared * squared;
    own.diameter *= thick;
    weight.push_back(squared * (connector.rest[k] / connector.rest[0]));
  }
  if (taper || value.find("material")) weigh_by_links(weight, connector);
  if (const Value* drag = value.find("drag")) {
    connector.drag = {number_or(*drag, "across", 0), number_or(*drag, "along", 0)};
  }
}

void check_curvatures(const Document& document, const World& world, const Timeline& timeline) {
  const Value* table = document.root.find("connectors");
  for (std::size_t c = 0; table && c < table->children.size(); ++c) {
    const Value* key = table->children[c].find("rest_curvature");
    if (!key || key->vec3().isZero()) continue;
    const Connector& connector = world.connectors[c];
    const Vec3 axis = key->vec3().normalized(), origin = connector.position[0];
    const auto lies = [&](const Vec3& way) {
      return std::abs(axis.dot(way)) <= kRounding * std::max(way.norm(), connector.length);
    };
    const auto joins = [&](const Joint& joint) {
      return std::ranges::any_of(joint.particles,
                                 [&](const auto& at) { return at.connector == c; });
    };
    bool plane = lies(world.gravity) &&
                 (world.air.density == 0 || (lies(world.air.wind) && !world.air.gusts)) &&
                 std::ranges::none_of(world.joints, joins);
    for (const Vec3& at : connector.position) plane = plane && lies(at - origin);
    for (const Vec3& velocity : connector.velocity) plane = plane && lies(velocity);
    for (const Hold& hold : connector.holds) {
      plane = plane && hold.to.kind == Attachment::Kind::fixed && lies(hold.clamp);
    }
    for (const TimedPin& pin : timeline.pins) {
      if (pin.connector != c || !pin.to) continue;
      plane = plane && pin.to->kind == Attachment::Kind::fixed && lies(pin.to->point - origin);
    }
    if (plane) continue;
    document.fail_at_key(*key,
                         "needs a motion in the plane across it: the connector, gravity, wind, "
                         "clamps and pins in that, and ends that are free or fixed");
  }
}

Air read_air(const Document& document) {
  const Value* air = document.root.find("air");
  if (!air) return {};
  Air made{number_or(*air, "density", kAirDensity), vec3_or(*air, "wind", Vec3::Zero())};
  if (const Value* file = air->find("file")) {
    const auto found = find_file(document, *file);
    made.gusts = with_place(document, *file,
                            [&] { return std::make_shared<const Path>(read_path_csv(found)); });
  }
  return made;
}

}  // namespace taut::scenes
