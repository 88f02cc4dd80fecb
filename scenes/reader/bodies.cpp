#include <fmt/format.h>

#include "scenes/reader/reader.h"
#include "sim/motion/rotation.h"

namespace taut::scenes {

namespace {

MassProperties read_shape(const Value& shape, double mass) {
  const Value& kind = shape.children.front();
  if (kind.name == "cylinder") {
    return solid_cylinder(mass, kind.find("length")->number, kind.find("diameter")->number);
  }
  if (kind.name == "sphere") return solid_sphere(mass, kind.find("diameter")->number);
  return solid_box(mass, kind.find("size")->vec3());
}

MassProperties read_inertia(const Document& document, const Value& body, double mass) {
  const Value& list = *body.find("inertia");
  if (list.children.size() != 3 && list.children.size() != 6) {
    document.mismatch(list, "a list of 3 or 6 numbers");
  }
  double v[6] = {};
  for (std::size_t i = 0; i < list.children.size(); ++i) v[i] = list.children[i].number;
  Mat3 inertia;
  inertia << v[0], v[3], v[5], v[3], v[1], v[4], v[5], v[4], v[2];
  // Mass that is somewhere has principal moments above zero, none larger than the other two
  // together (equal for a flat plate, hence the rounding).
  const Vec3 moments = principal_axes(inertia).moments;
  if (!(moments[0] > 0) || moments[2] > (moments[0] + moments[1]) * (1 + 1e-9)) {
    document.fail(list, fmt::format("found principal moments {}, {}, {}, expected all above 0 and "
                                    "none above the sum of the others",
                                    moments[0], moments[1], moments[2]));
  }
  return {mass, vec3_or(body, "centre", Vec3::Zero()), inertia};
}

/// As which a free body touches obstacles: by default a cylinder's capsule, or the ball itself.
BodyCapsule read_capsule(const Document& document, const Value& value, const Value* shape) {
  const Value* kind = shape ? &shape->children.front() : nullptr;
  const Value *radius = value.find("radius"), *from = value.find("from"), *to = value.find("to");
  const bool has_diameter = kind && kind->name != "box";
  if (!radius && !has_diameter) document.fail_at_key(value, "radius is missing");
  BodyCapsule made;
  made.radius = radius ? radius->number : kind->find("diameter")->number / 2;
  if (!from != !to) {
    document.fail_at_key(from ? *from : *to, fmt::format("needs {}", from ? "to" : "from"));
  }
  if (from) {
    made.from = from->vec3();
    made.to = to->vec3();
  } else if (kind && kind->name == "cylinder") {
    const double half = kind->find("length")->number / 2 - made.radius;
    if (half < 0) {
      document.fail_at_key(value, fmt::format("from and to are missing, which a cylinder shorter "
                                              "than {} m gives no line",
                                              2 * made.radius));
    }
    made.from = -half * Vec3::UnitY();
    made.to = half * Vec3::UnitY();
  } else if (!kind || kind->name == "box") {
    document.fail_at_key(value, "from and to are missing");
  }
  return made;
}

std::shared_ptr<const Path> read_driver(const Document& document, const Value& driver,
                                        Motions& motions) {
  if (const Value* path = driver.find("path")) return motions.path(*path);
  if (driver.find("bone")) return motions.bone(driver);
  const std::size_t index = motions.character_named(*driver.find("character"));
  if (!driver.find("hand"))
    document.fail(driver, "hand is missing, expected one of: right; or a bone");
  return motions.hand(index);
}

Body read_body(const Document& document, const Value& value, Motions& motions) {
  Body body;
  body.name = value.name;
  const Value *driver = value.find("driven_by"), *fixed = value.find("fixed");
  const bool driven = driver || fixed;
  if (!driven && !value.find("mass")) {
    document.fail(value, "mass is missing, expected a number above 0 (kg)");
  }
  const double mass = number_or(value, "mass", 1);
  const Value* shape = value.find("shape");
  body.mass_properties = shape ? read_shape(*shape, mass) : read_inertia(document, value, mass);
  const auto only_with = [&](const char* key, bool allowed, const char* other) {
    const Value* member = value.find(key);
    if (member && !allowed) document.fail_at_key(*member, fmt::format("needs {}", other));
  };
  only_with("centre", !shape, "inertia, a shape has its own centre");
  only_with("grip", driver, "driven_by");
  only_with("rotation", value.find("position") || fixed, "position or fixed");
  only_with("velocity", !driven, "a free body, without driven_by or fixed");
  only_with("spin", !driven, "a free body, without driven_by or fixed");
  only_with("contact", !driven,
            "a free body, without driven_by or fixed: an obstacle may be carried by it");

  if (const Value* contact = value.find("contact")) {
    body.capsule = read_capsule(document, *contact, shape);
  }
  body.grip = vec3_or(value, "grip", Vec3::Zero());
  body.velocity = vec3_or(value, "velocity", Vec3::Zero());
  body.spin = vec3_or(value, "spin", Vec3::Zero());
  const Value* turn = value.find("rotation");
  if (driven) {
    const Quat turned = turn ? rotation(document, *turn) : Quat::Identity();
    body.path =
        driver
            ? read_driver(document, *driver, motions)
            : std::make_shared<const Path>(std::vector<PathKey>{{0, fixed->vec3(), turned, false}});
    const Pose frame = driven_frame(body, 0).pose();
    body.position = frame.to_world(body.mass_properties.centre);
    body.rotation = frame.rotation;
  } else if (const Value* position = value.find("position")) {
    if (turn) body.rotation = rotation(document, *turn);
    body.position = position->vec3() + body.rotation * body.mass_properties.centre;
  }
  return body;
}

}  // namespace

bool is_driven(const Value& body) {
  return body.find("driven_by") || body.find("fixed");
}

std::vector<Body> read_bodies(const Document& document, Motions& motions) {
  std::vector<Body> bodies;
  if (const Value* table = document.root.find("bodies")) {
    for (const Value& value : table->children) {
      bodies.push_back(read_body(document, value, motions));
    }
  }
  return bodies;
}

}  // namespace taut::scenes
