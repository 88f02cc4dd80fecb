#include "scenes/load/faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "scenes/character/skeleton.h"
#include "scenes/format/format.h"
#include "scenes/format/scene_format.h"
#include "scenes/load/default_stage.h"
#include "scenes/load/load_scene.h"
#include "scenes/reader/reader.h"
#include "scenes/scene/clip.h"
#include "scenes/scene/scene.h"
#include "scenes/scene/stage.h"
#include "sim/choreography/choreography.h"
#include "sim/choreography/flat_fit.h"
#include "sim/contact/capsule.h"
#include "sim/motion/stop.h"

namespace taut::scenes {
namespace {

/// The part of the document that is left out once something in it is wrong: one named thing, one
/// element of a list, one key of the stage, or else a key at the top.
std::string entry_of(const std::string& key) {
  static const std::set<std::string_view> tables = {
      "paths", "characters", "bodies", "connectors", "obstacles", "touching", "stage"};
  const std::size_t dot = key.find('.');
  const std::string first = key.substr(0, dot);
  if (dot == std::string::npos || !tables.contains(first)) return first;
  const std::size_t end = key.find_first_of(".[", dot + 1);
  return key.substr(0, end);
}

const Value* value_at(const Value& from, const std::string& path) {
  for (const Value& child : from.children) {
    if (child.path == path) return &child;
    const bool within = path.starts_with(child.path) &&
                        (path[child.path.size()] == '.' || path[child.path.size()] == '[');
    if (within) return value_at(child, path);
  }
  return nullptr;
}

bool remove(Value& from, const std::string& path) {
  const auto found = std::ranges::find(from.children, path, &Value::path);
  if (found != from.children.end()) {
    from.children.erase(found);
    return true;
  }
  return std::ranges::any_of(from.children, [&](Value& child) {
    return path.starts_with(child.path) && remove(child, path);
  });
}

/// Also what a scene without a stage does not show.
void read_all(const Document& document) {
  if (read_scene(document, true).stage) return;
  Motions(document).check_characters();
  check_models(document);
}

class Search {
 public:
  explicit Search(Document document) : document_(std::move(document)) {}

  Faults run() && {
    rename_old_keys(document_);
    FirstFaults wrong_format = format_faults(document_);
    const std::size_t count = wrong_format.count();
    for (const SceneFault& fault : std::move(wrong_format).list()) note(fault);
    if (count > found_.count()) return {std::move(found_).list(), count - FirstFaults::kMost};
    for (const std::string& entry : wrong_) leave_out(entry);
    // Each look at the rest reads it anew.
    while (!stuck_) {
      if (found_.count() >= FirstFaults::kMost) return {std::move(found_).list(), std::nullopt};
      try {
        read_all(document_);
        break;
      } catch (const SceneFault& fault) {
        if (!follows(fault)) {
          note(fault);
          look_beside(fault);
        }
        leave_out(entry_of(fault.place.key));
      } catch (const BadScene& fault) {
        found_.add({fault.what(), {.file = document_.file.string(), .fault = fault.what()}});
        stuck_ = true;
      }
    }
    return {std::move(found_).list()};
  }

 private:
  void note(const SceneFault& fault) {
    found_.add(fault);
    wrong_.insert(entry_of(fault.place.key));
  }

  /// Other faults of the same entry: its first ones hide them, unless a look without their keys
  /// shows them. A fault of what lacks such a key is none.
  void look_beside(const SceneFault& fault) {
    constexpr int kLooks = 20;
    const std::string entry = entry_of(fault.place.key);
    Document rest = document_;
    std::vector<std::string> without;
    std::set<std::string> others;  // names of entries that have faults of their own
    std::string key = fault.place.key;
    for (int look = 0; look < kLooks && found_.count() < FirstFaults::kMost; ++look) {
      const std::string wrong = entry_of(key);
      if (wrong != entry) {
        others.insert(wrong.substr(wrong.find('.') + 1));
        key = wrong;
      } else {
        without.push_back(key);
      }
      if (key == entry || !remove(rest.root, key)) return;
      try {
        read_all(rest);
        return;
      } catch (const SceneFault& other) {
        key = other.place.key;
        if (entry_of(key) != entry) continue;
        const Value* value = value_at(document_.root, key);
        const bool lacks = !value || others.contains(value->text) ||
                           other.place.fault.find("needs ") != std::string::npos ||
                           std::ranges::any_of(without, [&](const std::string& gone) {
                             return gone.starts_with(key);
                           });
        if (lacks || follows(other)) return;
        note(other);
      } catch (const BadScene&) {
        return;
      }
    }
  }

  void leave_out(std::string entry) {
    // Of a list of tables one is left out, of a list of numbers all.
    const Value* element = value_at(document_.root, entry);
    if (element && entry.ends_with(']') && element->kind != Value::Kind::table) {
      entry.resize(entry.rfind('['));
    }
    const bool lasts = document_.root.find("duration") != nullptr;
    if ((entry == "duration" || (entry.empty() && !lasts)) && !lasts_) {  // no scene without one
      change(document_, "duration", "60");
      lasts_ = true;
      return;
    }
    // Without what cannot be left out there is no other look.
    if (entry.empty() || entry == "duration" || !remove(document_.root, entry)) {
      stuck_ = true;
      return;
    }
    gone_.insert(entry.substr(entry.find('.') + 1));
    const std::string table = entry.substr(0, entry.find('.'));  // perhaps misspelt
    connectors_gone_ = connectors_gone_ || !suggestion(table, {"connectors"}).empty();
    bodies_gone_ = bodies_gone_ || !suggestion(table, {"bodies"}).empty();
  }

  /// True for what is only wrong because something was left out.
  bool follows(const SceneFault& fault) const {
    const std::string& key = fault.place.key;
    const Value* value = value_at(document_.root, key);
    if (value && value->kind == Value::Kind::text && gone_.contains(value->text)) return true;
    if (connectors_gone_ && (key.ends_with(".hangs") || key.ends_with(".connector"))) return true;
    if (bodies_gone_ && key.ends_with(".body")) return true;
    if (lasts_ && fault.place.fault.find("duration") != std::string::npos) return true;
    // A connector as a whole: its ends have no place without what held them.
    return (connectors_gone_ || bodies_gone_) && key.starts_with("connectors.") &&
           key == entry_of(key) && value && hangs_on_others(*value);
  }

  /// True for what names a body or a connector, and so may have no place without another.
  static bool hangs_on_others(const Value& value) {
    static const std::set<std::string_view> others = {"body", "connector", "bone"};
    return others.contains(value.name) || std::ranges::any_of(value.children, hangs_on_others);
  }

  Document document_;
  FirstFaults found_;
  std::set<std::string> wrong_, gone_;
  /// Whether it lasts as long as somebody had to choose for it.
  bool lasts_ = false;
  bool stuck_ = false, connectors_gone_ = false, bodies_gone_ = false;
};

}  // namespace

Faults faults_of(const std::filesystem::path& file, const std::vector<SceneChange>& changes) {
  try {
    Document document = read_document(file);
    for (const auto& [key, value] : changes) change(document, key, value);
    std::erase_if(document.root.children, [](const Value& v) { return v.name == "plan"; });
    return Search(std::move(document)).run();
  } catch (const SceneFault& fault) {
    return {{fault}};
  } catch (const BadScene& fault) {
    return {{{fault.what(), {.file = file.string(), .fault = fault.what()}}}};
  }
}

namespace {

constexpr double kSamples = 30;       // a second of the scene, at most
constexpr double kOutOfReach = 0.05;  // m
constexpr double kEdge = 1.02;        // of half the picture

/// A thing's times in the picture and out of it.
struct Sight {
  double shown = 0, hidden = 0;              // samples
  double first_hidden = 0, last_hidden = 0;  // s
};

bool is_shown(const Scene& scene, const std::vector<const Shot*>& shots, double time,
              const Outline& thing) {
  const double aspect = static_cast<double>(scene.width) / scene.height;
  return std::ranges::any_of(shots, [&](const Shot* shot) {
    const CameraView camera = camera_at(shot->camera, time);
    return std::ranges::any_of(thing.points, [&](const Vec3& point) {
      const auto at = on_picture(camera, aspect, point);
      return at && at->cwiseAbs().maxCoeff() < kEdge;
    });
  });
}

void look_through_camera(const Scene& scene, const KnownRun& run,
                         std::vector<std::string>& warnings) {
  std::map<std::string, Sight> sights;
  const Outlines outlines(scene);
  const int every = frames_between_looks(scene);
  std::size_t looks = 0, unknown = 0;
  for (int frame = 0; frame < scene.frames(); frame += every, ++looks) {
    check_stop();
    const double time = static_cast<double>(frame) / scene.fps;
    std::vector<const Shot*> shots;
    for (const Shot& shot : scene.stage->shots)
      if (shot.from <= time && time < shot.until) shots.push_back(&shot);
    if (shots.empty()) continue;
    if (looks >= run.states.size()) {
      ++unknown;
      continue;
    }
    for (const Outline& thing : outlines.of(run.states[looks])) {
      Sight& sight = sights[thing.name];
      if (is_shown(scene, shots, time, thing)) {
        ++sight.shown;
        continue;
      }
      if (sight.hidden++ == 0) sight.first_hidden = time;
      sight.last_hidden = time;
    }
  }
  if (!run.diverged.empty()) {
    warnings.push_back(fmt::format("the simulation diverges: {}", run.diverged));
  } else if (unknown > 0) {
    warnings.push_back(
        run.states.empty()
            ? std::string("what the camera shows is left out: it is too much to simulate")
            : fmt::format("what the camera shows after {:.3g} s is left out: it is too much to "
                          "simulate",
                          run.states.back().time));
  }
  for (const auto& [name, sight] : sights) {
    if (sight.hidden == 0) continue;
    warnings.push_back(
        sight.shown == 0
            ? fmt::format("{} is never in the camera's picture", name)
            : fmt::format("{} is out of the camera's picture {:.0f}% of the time, from {:.3g} s "
                          "until {:.3g} s",
                          name, 100 * sight.hidden / (sight.hidden + sight.shown),
                          sight.first_hidden, sight.last_hidden));
  }
}

void look_at_hands(const Scene& scene, std::vector<std::string>& warnings) {
  for (const auto& performance : scene.performances) {
    double most = 0, worst = 0, first = -1;
    for (int frame = 0; frame < scene.frames(); ++frame) {
      const double time = static_cast<double>(frame) / scene.fps;
      const double beyond = beyond_reach(*performance, time);
      if (beyond > kOutOfReach && first < 0) first = time;
      if (beyond > most) most = beyond, worst = time;
    }
    if (most <= kOutOfReach) continue;
    warnings.push_back(fmt::format(
        "the hand's path is out of the arm's reach from {:.3g} s, most at {:.3g} s, by {:.2f} m: "
        "it drags the body along",
        first, worst, most));
  }
}

/// The longest link (m) that lies on a surface bent by `radius` with its middle no deeper in it
/// than `depth`.
double longest_link(double radius, double depth) {
  return 2 * std::sqrt(depth * (2 * radius - depth));
}

/// Connectors that overlap, at the start or in a later state, and pass through each other.
void look_at_connectors(const Scene& scene, const KnownRun& run,
                        std::vector<std::string>& warnings) {
  constexpr std::size_t kMost = 300;  // connectors, of which all pairs are looked at
  const World& world = scene.world;
  World other = world;
  other.connector_pairs.clear();
  std::vector<std::size_t> connector_of;
  std::vector<Vec3> places;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    places.insert(places.end(), connector.position.begin(), connector.position.end());
    connector_of.insert(connector_of.end(), connector.particles(), c);
    if (c >= kMost || !(connector.radius > 0)) continue;
    for (std::size_t b = 0; b < c; ++b) {
      const bool touch = std::ranges::any_of(world.connector_pairs, [&](const ConnectorPair& pair) {
        return std::minmax(pair.a, pair.b) == std::minmax(b, c);
      });
      if (!touch && world.connectors[b].radius > 0) other.connector_pairs.push_back({b, c});
    }
  }
  contact::NearLinks near;
  near.rebuild(other);
  if (!near.any()) return;
  std::set<std::pair<std::string_view, std::string_view>> told;
  std::vector<contact::LinkPair> pairs;
  const auto look = [&](double time) {
    near.find({places.data()->data(), 3 * places.size()}, 0, pairs);
    for (const contact::LinkPair& pair : pairs) {
      const std::string_view a = written_name(world.connectors[connector_of[pair.a]].name),
                             b = written_name(world.connectors[connector_of[pair.b]].name);
      if (!told.emplace(a, b).second) continue;
      const std::string when = time > 0 ? fmt::format(" at {:.3g} s", time) : "";
      warnings.push_back(
          a == b ? fmt::format("connectors {} pass through each other{}: touches_itself = true "
                               "lets them touch",
                               a, when)
                 : fmt::format("connectors {} and {} pass through each other{}: a table of "
                               "touching with both lets them touch",
                               a, b, when));
    }
  };
  look(0);
  if (!scene.timeline.pins.empty() || !scene.timeline.cuts.empty()) return;  // other particles
  for (const Snapshot& state : run.states) {
    check_stop();
    places.clear();
    for (const std::vector<Vec3>& particles : state.connectors)
      places.insert(places.end(), particles.begin(), particles.end());
    look(state.time);
  }
}

/// Free bodies that come into an obstacle, which nothing says that they touch.
void look_at_bodies(const Scene& scene, const KnownRun& run, std::vector<std::string>& warnings) {
  const World& world = scene.world;
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    const Body& body = world.bodies[b];
    if (body.driven() || body.capsule.touches()) continue;
    for (const Obstacle& obstacle : world.obstacles) {
      const auto inside = std::ranges::find_if(run.states, [&](const Snapshot& state) {
        const Vec3 centre = state.bodies[b].to_world(body.mass_properties.centre);
        return gap(obstacle, obstacle.frame(state.time).pose(), centre, 0).distance < 0;
      });
      if (inside == run.states.end()) continue;
      warnings.push_back(
          fmt::format("body {} passes through obstacle {} at {:.3g} s: contact = {{}} in the body "
                      "lets it touch",
                      body.name, obstacle.name, inside->time));
    }
  }
}

/// Beads touch obstacles, the links between them do not.
void look_at_beads(const World& world, std::vector<std::string>& warnings) {
  constexpr double kDip = 0.05;  // of the obstacle's radius, or the rope's own if that is more
  for (const Obstacle& obstacle : world.obstacles) {
    const double sharpest = obstacle.shape.sharpest();
    if (std::isinf(sharpest)) continue;
    for (const Connector& connector : world.connectors) {
      if (is_numbered(connector.name)) continue;  // as the first of them
      if (!obstacle.touches(connector.category) || connector.links_touch) continue;
      const double bent = sharpest + connector.radius;
      if (bent == 0) {
        warnings.push_back(fmt::format(
            "obstacle {} has sharp edges and connector {} no radius: its links cut the edges off, "
            "however many there are",
            obstacle.name, connector.name));
        continue;
      }
      const double link = std::ranges::max(connector.rest);
      const double allowed = longest_link(bent, std::max(connector.radius, kDip * sharpest));
      if (link <= allowed) continue;
      warnings.push_back(
          fmt::format("connector {} has too few particles for obstacle {}: a link of {:.4g} m "
                      "between two beads "
                      "at it cuts into it{}; {:.0f} particles would do",
                      connector.name, obstacle.name, link, link > 2 * bent ? ", or slips past" : "",
                      std::ceil(connector.length / allowed) + 1));
    }
  }
}

/// Rigid links push. A drum that pays out while its load stands on an obstacle folds the rope.
void look_at_winches(const World& world, double until, std::vector<std::string>& warnings) {
  constexpr int kTimes = 1000;
  const auto pays_out = [&](const Winch& winch) {
    for (int i = 0; i <= kTimes; ++i) {
      if (winch.longer(until * i / kTimes).rate > 1e-9) return true;
    }
    return false;
  };
  const auto may_land = [&](const Hold& hold) {
    if (hold.to.kind != Attachment::Kind::body) return false;
    const Body& body = world.bodies[hold.to.body];
    const auto touches = [&](const Obstacle& at) { return at.touches(body.capsule.category); };
    return !body.driven() && body.capsule.touches() &&
           std::ranges::any_of(world.obstacles, touches);
  };
  for (const Connector& connector : world.connectors) {
    if (!connector.winch || connector.pulls || connector.stretches()) continue;
    if (std::ranges::none_of(connector.holds, may_land) || !pays_out(*connector.winch)) continue;
    warnings.push_back(fmt::format(
        "connector {} has links that push and a winch that pays out; when its load lands, they "
        "fold at any speed: links = \"pull\" lets the rope go slack",
        connector.name));
  }
}

}  // namespace

int frames_between_looks(const Scene& scene) {
  return std::max(1, static_cast<int>(std::lround(scene.fps / kSamples)));
}

std::vector<std::string> warnings_of(const Scene& scene, const KnownRun& run) {
  std::vector<std::string> warnings;
  const bool anything =
      !scene.world.connectors.empty() ||
      std::ranges::any_of(scene.world.bodies, [](const Body& body) { return !body.driven(); });
  if (!anything) {
    warnings.emplace_back("nothing is simulated: there is no connector and no free body");
  }
  look_at_connectors(scene, run, warnings);
  look_at_bodies(scene, run, warnings);
  look_at_beads(scene.world, warnings);
  look_at_winches(scene.world, scene.duration, warnings);
  if (!scene.stage) return warnings;
  std::ranges::copy(left_out(*scene.stage), std::back_inserter(warnings));
  look_at_hands(scene, warnings);
  look_through_camera(scene, run, warnings);
  return warnings;
}

std::optional<std::string> choreography_warning(const Scene& scene,
                                                const std::vector<SceneChange>& changes) {
  const std::optional<Choreographed> asked = load_choreography(scene.file, changes);
  if (!asked) return std::nullopt;
  try {
    const double worst =
        std::ranges::max(choreography::misses(asked->problem, scene.world, asked->within));
    if (worst <= asked->within) return std::nullopt;
    return fmt::format(
        "choreography: a waypoint is missed by {:.3g} mm, asked: {:.3g} mm; taut "
        "choreograph finds the path anew",
        1e3 * worst, 1e3 * asked->within);
  } catch (const Diverged& error) {
    return fmt::format("choreography: {}", error.what());
  }
}

}  // namespace taut::scenes
