#include "scenes/scene/stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "scenes/model/load_model.h"
#include "scenes/reader/common.h"
#include "scenes/reader/joints.h"
#include "scenes/reader/reader.h"

namespace taut::scenes {

namespace {

const Vec3 kBackground(0.16530606184503005, 0.181895792503865, 0.20362917723338914);

using ModelPointer = std::shared_ptr<const Model>;

ModelPointer make_shape(const Value& body, const Value& shape);

/// Models by file and by shape, so that two bodies of one mesh share it.
class Models {
 public:
  explicit Models(const Document& document) : document_(document) {}

  ModelPointer get(const Value& value) {
    const FoundFile found = find_asset(document_, value);
    ModelPointer& model = loaded_[found.file];
    if (!model) {
      model = with_place(document_, value, [&] {
        auto loaded = std::make_shared<Model>(load_model(found.file, found.within));
        make_rigid(*loaded, found.file.string());
        return ModelPointer(std::move(loaded));
      });
    }
    return model;
  }

  /// A model of the body's shape; null for a body that has only an inertia.
  ModelPointer shape(const Value& body) {
    const Value* shape = body.find("shape");
    if (!shape) return nullptr;
    const Value& kind = shape->children.front();
    std::vector<double> numbers{double(kind.name.size())};  // no two kinds have as many letters
    const auto add = [&](const Value* value) {
      if (!value) return;
      numbers.push_back(value->number);
      for (const Value& child : value->children) numbers.push_back(child.number);
    };
    for (const Value& member : kind.children) add(&member);
    add(body.find("color"));
    ModelPointer& model = shapes_[numbers];
    if (!model) model = make_shape(body, *shape);
    return model;
  }

 private:
  const Document& document_;
  std::map<std::filesystem::path, ModelPointer> loaded_;
  std::map<std::vector<double>, ModelPointer> shapes_;
};

/// Fails where neither a body nor a connector has that name.
void check_followed(const Document& document, const Value& name) {
  std::vector<std::string_view> names;
  for (const char* kind : {"bodies", "connectors"}) {
    const Value* table = document.root.find(kind);
    for (std::size_t i = 0; table && i < table->children.size(); ++i)
      names.push_back(table->children[i].name);
  }
  Names(std::move(names)).index_of(document, name, "body or connector");
}

std::vector<CameraKey> read_camera(const Document& document, const Value& list) {
  std::vector<CameraKey> keys;
  for (const Value& entry : list.children) {
    const Value& time = *entry.find("t");
    if (!keys.empty() && !(time.number > keys.back().time)) {
      document.mismatch(
          time, fmt::format("a time after {} s, that of the key before it", keys.back().time));
    }
    CameraKey key{.time = time.number, .target = entry.find("target")->vec3()};
    key.follow = text_or(entry, "follow", "");
    if (!keys.empty() && key.follow != keys.back().follow) {
      const Value* named = entry.find("follow");
      document.fail(named ? *named : entry,
                    fmt::format("all keys of a camera follow the same, the one before it {}",
                                keys.back().follow.empty() ? "nothing" : keys.back().follow));
    }
    if (const Value* followed = entry.find("follow")) check_followed(document, *followed);
    if (const Value* orbit = entry.find("orbit")) {
      key.orbit = Vec3(number_or(*orbit, "azimuth", 0), number_or(*orbit, "elevation", 0),
                       orbit->find("distance")->number);
      key.position = key.target + on_orbit(*key.orbit);
    } else {
      key.position = entry.find("position")->vec3();
    }
    if (key.follow.empty() && (key.target - key.position).isZero()) {
      document.mismatch(*entry.find("target"), "a point other than the camera's position");
    }
    key.field_of_view = number_or(entry, "field_of_view", key.field_of_view);
    if (const Value* stop = entry.find("aperture")) key.relative_aperture = 1 / stop->number;
    if (const Value* focus = entry.find("focus")) key.focus = focus->number;
    keys.push_back(key);
  }
  return keys;
}

Light read_light(const Document& document, const Value& value) {
  Light light;
  if (const Value* along = value.find("direction")) light.direction = direction(document, *along);
  light.color = vec3_or(value, "color", light.color);
  light.sky = vec3_or(value, "sky", light.sky);
  light.ground = vec3_or(value, "ground", light.ground);
  light.rim = vec3_or(value, "rim", light.rim);
  if (const Value* casts = value.find("scenery_casts")) light.scenery_casts = casts->flag;
  return light;
}

/// Every shot has a camera of its own; keys of so many at most.
constexpr std::size_t kMostCameraKeys = 1000000;

/// The shots, or the whole scene as one.
std::vector<Shot> read_shots(const Document& document, const Value* list, double duration,
                             const std::vector<CameraKey>& camera) {
  if (!list) return {{.until = duration, .camera = camera}};
  std::vector<Shot> shots;
  std::size_t camera_keys = 0;
  for (const Value& entry : list->children) {
    const Value& until = *entry.find("until");
    Shot shot{entry.find("from")->number, until.number, number_or(entry, "rate", 1), camera};
    if (!(shot.until > shot.from)) {
      document.mismatch(until, fmt::format("a time after {} s", shot.from));
    }
    if (shot.until > duration) {
      document.mismatch(until, fmt::format("at most the scene's duration, {} s", duration));
    }
    if (const Value* keys = entry.find("camera")) shot.camera = read_camera(document, *keys);
    camera_keys += shot.camera.size();
    if (camera_keys > kMostCameraKeys) {
      document.fail(entry, fmt::format("the shots have {} camera keys so far, expected at most {}",
                                       camera_keys, kMostCameraKeys));
    }
    shots.push_back(std::move(shot));
  }
  return shots;
}

Card read_card(const Value* value) {
  if (!value) return {};
  return {value->find("duration")->number, value->find("heading")->text,
          std::string(text_or(*value, "text", ""))};
}

std::vector<Caption> read_captions(const Document& document, const Value& list) {
  std::vector<Caption> captions;
  for (const Value& entry : list.children) {
    const Value& until = *entry.find("until");
    captions.push_back({entry.find("from")->number, until.number, entry.find("text")->text,
                        std::string(text_or(entry, "list", ""))});
    if (!(until.number > captions.back().from)) {
      document.mismatch(until, fmt::format("a time after {} s", captions.back().from));
    }
  }
  return captions;
}

/// Of a world whose bodies and connectors begin with those of the document, in its order.
std::vector<Trail> read_trails(const Document& document, const Value& list, const World& world) {
  const Names bodies(document.root.find("bodies"));
  std::vector<std::string_view> names;
  for (const Connector& connector : world.connectors) names.push_back(connector.name);
  const Names connectors(std::move(names));
  std::vector<Trail> trails;
  for (const Value& entry : list.children) {
    Trail trail;
    if (const Value* body = entry.find("body")) {
      trail.index = bodies.index_of(document, *body, "body");
      trail.point = vec3_or(entry, "point", Vec3::Zero());
    } else {
      trail.connector = true;
      trail.index = connectors.index_of(document, *entry.find("connector"), "connector");
      const Connector& connector = world.connectors[trail.index];
      const double at = number_or(entry, "at", connector.length);
      if (at > connector.length * (1 + kRounding)) {
        document.mismatch(*entry.find("at"),
                          fmt::format("at most the connector's length, {} m", connector.length));
      }
      const auto links = double(connector.particles() - 1);
      trail.particle = connector.length > 0
                           ? std::size_t(std::lround(std::min(at / connector.length, 1.0) * links))
                           : 0;
    }
    trail.lasts = number_or(entry, "lasts", trail.lasts);
    trail.from = number_or(entry, "from", trail.from);
    trail.until = number_or(entry, "until", trail.until);
    if (!(trail.until > trail.from)) {
      document.mismatch(*entry.find("until"), fmt::format("a time after {} s", trail.from));
    }
    trail.width = number_or(entry, "width", trail.width);
    trail.color = vec3_or(entry, "color", trail.color);
    trails.push_back(trail);
  }
  return trails;
}

ModelPointer make_shape(const Value& body, const Value& shape) {
  const Vec3 color = vec3_or(body, "color", Vec3(0.45, 0.27, 0.14));
  const Value& kind = shape.children.front();
  const double diameter = number_or(kind, "diameter", 0);
  if (kind.name == "cylinder") {
    return std::make_shared<const Model>(
        cylinder_model(kind.find("length")->number, diameter, color));
  }
  return std::make_shared<const Model>(kind.name == "sphere"
                                           ? sphere_model(diameter, color)
                                           : box_model(kind.find("size")->vec3(), color));
}

void for_each(const Value* table, auto&& use) {
  if (!table) return;
  for (const Value& member : table->children) use(member);
}

ConnectorLook read_look(const Value& connector) {
  using Kind = ConnectorLook::Kind;
  static const std::map<std::string_view, Kind> kinds = {
      {"chain", Kind::chain}, {"rope", Kind::rope}, {"cord", Kind::cord}};
  ConnectorLook look;
  look.kind = kinds.at(text_or(connector, "look", "rope"));
  if (look.kind == Kind::chain) look.color = Vec3(0.56, 0.57, 0.58);  // iron and steel
  if (const Value* radius = connector.find("radius")) look.diameter = 2 * radius->number;
  look.diameter = number_or(connector, "diameter", look.diameter);
  look.color = vec3_or(connector, "color", look.color);
  return look;
}

/// Obstacles that stand still are scenery; a driven body goes with each of the others.
void show_obstacles(const Value* table, const World& world, Stage& stage) {
  constexpr double kPlane = 4;  // m
  const Vec3 grey(0.36, 0.35, 0.33);
  for (std::size_t i = 0; i < world.obstacles.size(); ++i) {
    const Obstacle& obstacle = world.obstacles[i];
    const Value& value = table->children[i];
    if (!shows_obstacle(value)) continue;
    const Value* shape = value.find("shape");
    const double size = shape ? number_or(shape->children.front(), "size", kPlane) : kPlane;
    auto model = std::make_shared<const Model>(
        obstacle_model(obstacle.shape, size, obstacle.place, vec3_or(value, "color", grey)));
    (obstacle.path ? stage.body_models : stage.scenery).push_back(std::move(model));
  }
}

}  // namespace

void check_models(const Document& document) {
  Models models(document);
  for_each(document.root.find("bodies"), [&](const Value& body) {
    if (const Value* mesh = body.find("mesh")) models.get(*mesh);
  });
}

void read_stage(const Document& document, Motions& motions, Scene& scene) {
  const Value& root = document.root;
  const Value& value = *root.find("stage");
  Models models(document);
  Stage stage;
  const Value* camera = value.find("camera");
  stage.camera = camera ? read_camera(document, *camera) : std::vector{CameraKey{}};
  stage.shots = read_shots(document, value.find("shots"), scene.duration, stage.camera);
  stage.title = read_card(value.find("title"));
  stage.end = read_card(value.find("end"));
  stage.shutter = number_or(value, "shutter", stage.shutter);
  if (const Value* light = value.find("light")) stage.light = read_light(document, *light);
  stage.background = vec3_or(value, "background", kBackground);
  if (const Value* captions = value.find("captions")) {
    stage.captions = read_captions(document, *captions);
  }
  if (const Value* trails = value.find("trails")) {
    stage.trails = read_trails(document, *trails, scene.world);
  }
  for_each(value.find("scenery"),
           [&](const Value& file) { stage.scenery.push_back(models.get(file)); });
  for_each(root.find("bodies"), [&](const Value& body) {
    const Value* mesh = body.find("mesh");
    stage.body_models.push_back(mesh ? models.get(*mesh) : models.shape(body));
  });
  show_obstacles(root.find("obstacles"), scene.world, stage);
  for_each(root.find("connectors"),
           [&](const Value& connector) { stage.connector_looks.push_back(read_look(connector)); });
  const Value* connectors = root.find("connectors");
  for (std::size_t i = 0; connectors && i < connectors->children.size(); ++i) {
    const ConnectorLook look = stage.connector_looks[i];
    stage.connector_looks.insert(
        stage.connector_looks.end(),
        repeat_count(connectors->children[i]) * span_count(connectors->children[i]) - 1, look);
  }
  for_each(root.find("nets"), [&](const Value& net) {
    stage.connector_looks.insert(stage.connector_looks.end(), cord_count(net), read_look(net));
  });
  for (const TimedCut& cut : in_order_of_time(scene.timeline.cuts)) {  // as divided() adds them
    stage.connector_looks.push_back(ConnectorLook(stage.connector_looks[cut.connector]));
  }
  for (std::size_t i = 0; i < motions.characters(); ++i) {
    const Character& character = motions.character(i);
    stage.characters.push_back(character.model);
    scene.performances.push_back(character.performance);
  }
  scene.stage = std::move(stage);
}

}  // namespace taut::scenes
