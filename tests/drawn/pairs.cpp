#include "tests/drawn/pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "sim/features/features.h"
#include "tests/drawn/pieces.h"

namespace taut::drawn {
namespace {

// Scenes have no applied forces.
constexpr std::size_t kSceneFeatures = kFeatureCount - 1;

Feature scene_feature(std::size_t index) {
  return static_cast<Feature>(index +
                              (index < static_cast<std::size_t>(Feature::applied_force) ? 0 : 1));
}

class Pair : Pieces {
 public:
  explicit Pair(unsigned seed) : Pieces(seed) {
    unsigned pair = seed % pair_count(), other = 0;
    for (unsigned one = 0; one < kSceneFeatures; ++one) {
      if (pair <= one) {
        other = one;
        break;
      }
      pair -= one + 1;
    }
    features_ |= scene_feature(pair);
    features_ |= scene_feature(other);
    if (chance(0.3)) features_ |= scene_feature(dice_.pick(kSceneFeatures));
  }

  std::string drawn() {
    length_ = dice_.scale(0.1, 3);
    const double length = length_ * dice_.between(0.5, 1);
    in_plane_ = has(Feature::rest_curvature);
    line("duration = 0.5\nfps = {}\ngravity = {}", kRate,
         text(chance(0.9) ? Vec3(0, -9.81, 0) : 10 * direction()));
    if (has(Feature::air)) line("air = {{ wind = {} }}", text(5 * direction()));
    add_method();
    if (has(Feature::pulley) || has(Feature::sheave) || has(Feature::pulley_friction)) {
      add_reeved();
    }
    add_rope(length);
    add_things(length);
    return text_;
  }

 private:
  static constexpr int kRate = 60;  // frames per second

  /// Where the rope is curved at rest, it moves in the plane across z.
  Vec3 direction() {
    const Vec3 any = dice_.direction();
    return in_plane_ ? Vec3(Vec3(any.x(), any.y() + 0.01, 0).normalized()) : any;
  }

  bool has(Feature one) const { return features_.has(one); }

  void add_method() {
    constexpr const char* kNames[] = {"direct", "direct", "direct", "direct",  "direct",
                                      "direct", "direct", "xpbd",   "springs", "impulse"};
    const std::string name = kNames[dice_.pick(std::size(kNames))];
    line("\n[method]\nname = \"{}\"", name);
    if (name != "direct") return;
    if (chance(0.35)) {
      line("step = {}", 1.0 / kRate / static_cast<int>(dice_.scale(1, 100)));
    } else {
      line("tolerance = {}", length_ * dice_.scale(1e-5, 3e-2));
    }
  }

  std::string load(double size) {
    const std::string where = fmt::format("hangs = {}", text(along_));
    line("\n[bodies.load]\nmass = {}\nshape = {{ sphere = {{ diameter = {} }} }}\n{}",
         dice_.scale(1e-2, 3), size, where);
    if (has(Feature::body_contact) || has(Feature::body_pairs)) line("contact = {{}}");
    return fmt::format("{{ body = \"load\", point = {}", text(-size / 2 * along_));
  }

  /// The rope that has all that one connector can have.
  void add_rope(double length) {
    along_ = chance(0.5) ? Vec3(0, -1, 0) : direction();
    const double weight = 10 * dice_.scale(1e-3, 1);  // N
    const double bending = weight * length * length * dice_.scale(1e-5, 1e-1);
    const bool on_body = has(Feature::clamp_on_body) || has(Feature::material_on_body);
    const bool led = !in_plane_ && chance(0.2);
    const std::string path = led ? add_path(Vec3::Zero()) : "";
    std::string from = led ? fmt::format("{{ path = \"{}\"", path) : "{ fixed = [0, 0, 0]";
    std::string to = "{ free = true";
    if (on_body || has(Feature::free_body)) {
      to = load(0.2 * length);
    } else if (has(Feature::twist) || has(Feature::turning_clamp)) {
      to = fmt::format("{{ fixed = {}", text(0.9 * length * along_));
    } else if (chance(0.5)) {
      to = fmt::format("{{ point_mass = {}", dice_.scale(1e-3, 3));
    }
    const std::string clamp = fmt::format(", clamp = {}", text(along_));
    if (has(Feature::clamp) || has(Feature::twist) || has(Feature::turning_clamp)) {
      from += clamp;
      if (!on_body && !has(Feature::free_body) && to.starts_with("{ fixed")) to += clamp;
    }
    if (has(Feature::turning_clamp)) {
      from += fmt::format(", turn = [{{ t = 0, angle = 0 }}, {{ t = {}, angle = {} }}]",
                          dice_.between(0.2, 1), dice_.between(-10, 10));
    }
    if (has(Feature::clamp_on_body)) to += clamp;
    if (has(Feature::winch)) {
      from += fmt::format(", winch = [{{ t = 0, paid_out = 0 }}, {{ t = {}, paid_out = {} }}]",
                          dice_.between(0.2, 1), length * dice_.between(-0.3, 0.5));
    }
    line("\n[connectors.rope]\nlength = {}\nmass = {}\nparticles = {}", length, weight / 10,
         4 + dice_.pick(8));
    line("from = {} }}\nto = {} }}\nradius = {}", from, to, length * dice_.scale(2e-3, 2e-2));
    if (!to.starts_with("{ fixed")) line("start = {{ direction = {} }}", text(along_));
    if (has(Feature::stretch)) line("axial_stiffness = {}", weight * dice_.scale(10, 1e6));
    const bool bends = has(Feature::bending) || has(Feature::rest_curvature) ||
                       has(Feature::clamp) || has(Feature::turning_clamp) ||
                       has(Feature::clamp_on_body) || has(Feature::twist);
    if (bends) line("bending_stiffness = {}", bending);
    if (has(Feature::bending_damping)) line("bending_damping = {}", bending * 1e-3);
    if (has(Feature::rest_curvature)) {
      line("rest_curvature = {}", text(dice_.between(0.2, 3) / length * Vec3::UnitZ()));
    }
    if (has(Feature::twist) || has(Feature::turning_clamp)) {
      line("twisting_stiffness = {}", bending);
    }
    if (has(Feature::taper)) line("taper = [1, {}]", dice_.between(0.2, 0.9));
    if (has(Feature::taper) && !bends && !has(Feature::stretch)) {
      line("bending_stiffness = {}", bending);
    }
    if (has(Feature::air)) line("drag = {{ across = {}, along = 0.01 }}", dice_.between(0.2, 2));
    if (has(Feature::material_on_body) && !bends && !has(Feature::stretch)) {
      line("axial_stiffness = {}", weight * dice_.scale(10, 1e5));
    }
    if (has(Feature::strings) || has(Feature::string_rebound)) line("links = \"pull\"");
    if (has(Feature::string_rebound)) line("restitution = {}", dice_.between(0.1, 0.9));
    if (has(Feature::links_touch)) line("contact = \"links\"");
    if (has(Feature::self_contact)) {
      line("touches_itself = true");
      if (has(Feature::friction)) line("friction = {}", dice_.scale(0.02, 1.5));
    }
  }

  void add_things(double length) {
    const bool floor = has(Feature::obstacle) || has(Feature::links_touch) ||
                       has(Feature::body_contact) || has(Feature::friction) ||
                       has(Feature::restitution);
    const std::string surface =
        (has(Feature::friction) ? fmt::format("friction = {}\n", dice_.scale(0.02, 1.5)) : "") +
        (has(Feature::restitution) ? fmt::format("restitution = {}\n", dice_.between(0.1, 1)) : "");
    if (floor) {
      const std::string shape =
          chance(0.5) ? "plane = {}" : fmt::format("sphere = {{ diameter = {} }}", length);
      const double depth = shape.starts_with("plane") ? 1 : 1.8;
      line("\n[obstacles.floor]\nshape = {{ {} }}\nposition = {}\n{}", shape,
           text(Vec3(0, -depth * length * dice_.between(1.02, 1.5), 0)), surface);
    }
    if (has(Feature::moving_obstacle)) {
      const Vec3 from = length * Vec3(1.5, -0.5, 0), to = length * Vec3(-0.5, -0.6, 0.1);
      line(
          "\n[paths.hand]\nkeys = [{{ t = 0, position = {}, ease = true }}, {{ t = {}, "
          "position = {} }}]",
          text(from), dice_.between(0.3, 2), text(to));
      line("\n[obstacles.hand]\nshape = {{ sphere = {{ diameter = {} }} }}\npath = \"hand\"\n{}",
           0.3 * length, surface);
    }
    if (has(Feature::body_contact)) add_ball("dropped", length * Vec3(0.6, -0.2, 0.6), length);
    if (has(Feature::body_pairs) || has(Feature::bead_pairs)) {
      add_ball("left", length * Vec3(0.7, -0.4, -0.3), length);
      add_ball("right", length * Vec3(1.1, -0.4, -0.3), length);
      line("\n[touching.balls]\nbodies = [\"left\", \"right\"]\n{}{}",
           has(Feature::bead_pairs) ? "connectors = [\"rope\"]\n" : "", surface);
    }
    if (has(Feature::connector_pairs)) {  // a rope across the way of the first one
      line(
          "\n[connectors.across]\nlength = {}\nmass = {}\nparticles = {}\nradius = {}\nfrom = {{ "
          "fixed = {} }}\nto = {}\nstart = {{ direction = [0, 0, 1] }}",
          length, dice_.scale(1e-3, 1), 3 + dice_.pick(8), length * dice_.scale(2e-3, 2e-2),
          text(length * Vec3(dice_.between(0.1, 0.3), -0.3, -0.5)),
          chance(0.5) ? "{ free = true }" : "{ point_mass = 0.2 }");
      line("\n[touching.ropes]\nconnectors = [\"rope\", \"across\"]\n{}", surface);
    }
    if (has(Feature::joint)) {
      line(
          "\n[connectors.branch]\nlength = {}\nmass = {}\nparticles = {}\nfrom = {{ connector = "
          "\"rope\", at = {} }}\nto = {{ free = true }}\nstart = {{ direction = {} }}",
          0.5 * length, dice_.scale(1e-3, 1), 2 + dice_.pick(5), chance(0.5) ? length : 0,
          text(dice_.direction()));
    }
    if (has(Feature::loop)) {
      line(
          "\n[connectors.ring]\nlength = {}\nmass = {}\nparticles = {}\nfrom = {{ free = true }}\n"
          "to = {{ connector = \"ring\", at = 0.0 }}\nstart = {{ circle = {{ centre = {}, axis = "
          "{} }} }}",
          length, dice_.scale(1e-3, 1), 5 + dice_.pick(6), text(Vec3(3 * length, 0, 0)),
          text(dice_.direction()));
    }
    if (has(Feature::span)) {
      line(
          "\n[connectors.cord]\nmodel = \"span\"\nlength = {}\nmass = 0\nparticles = "
          "2\nrestitution "
          "= {}\nfrom = {{ fixed = {} }}\nto = {{ point_mass = 0.1 }}\nstart = {{ direction = {} "
          "}}",
          0.5 * length, dice_.between(0, 1), text(Vec3(-2 * length, 0, 0)),
          text(dice_.direction()));
    }
    if (has(Feature::hinge)) {
      line("\n[bodies.earring]\nmass = {}\nshape = {{ sphere = {{ diameter = {} }} }}\nhangs = {}",
           dice_.scale(1e-3, 1), 0.1 * length, text(dice_.direction()));
      line(
          "\n[connectors.hinge]\nlength = 0\nmass = 0.001\nparticles = 2\nfrom = {{ fixed = {} "
          "}}\nto = {{ body = \"earring\", point = {} }}",
          text(Vec3(-length, 0, 0)), text(Vec3(0, 0.1 * length, 0)));
    }
    const bool acts = has(Feature::pin) || has(Feature::cut);
    const std::string rope = acts && has(Feature::winch) ? "other" : "rope";  // with no winch
    if (rope == "other") {
      line(
          "\n[connectors.other]\nlength = {}\nmass = 0.1\nparticles = 5\nfrom = {{ fixed = {} "
          "}}\nto "
          "= {{ free = true }}\nstart = {{ direction = {} }}",
          length, text(Vec3(-3 * length, 0, 0)), text(along_));
    }
    if (has(Feature::pin)) {
      line("\n[[pins]]\nconnector = \"{}\"\nat = {}\nfrom = {}\nuntil = {}", rope,
           length * dice_.between(0.3, 1), dice_.between(0, 0.2), dice_.between(0.21, 0.5));
    }
    if (has(Feature::cut)) {
      line("\n[[cuts]]\nconnector = \"{}\"\nat = {}\nt = {}", rope,
           length * dice_.between(0.1, 0.9), dice_.between(0, 0.4));
    }
  }

  void add_ball(const char* name, const Vec3& at, double length) {
    line(
        "\n[bodies.{}]\nmass = {}\nshape = {{ sphere = {{ diameter = {} }} }}\nposition = {}\n"
        "velocity = {}\ncontact = {{}}",
        name, dice_.scale(1e-2, 3), 0.2 * length, text(at),
        text(chance(0.5) ? Vec3(length * dice_.direction() + Vec3(-2 * length, 0, 0))
                         : Vec3(Vec3::Zero())));
  }

  /// A rope over two eyes.
  void add_reeved() {
    std::string turns;
    if (has(Feature::sheave)) turns += fmt::format(", inertia = {}", dice_.scale(1e-3, 1));
    if (has(Feature::pulley_friction)) {
      turns += fmt::format(", {} = {}", has(Feature::sheave) ? "bearing" : "friction",
                           dice_.scale(1e-2, 0.3));
    }
    const Vec3 one(5 * length_, 0, 0), other = one + length_ * Vec3(0.6, 0, 0.1);
    line("\n[pulleys]\none = {{ fixed = {}{} }}\nother = {{ fixed = {}{} }}", text(one), turns,
         text(other), turns);
    line(
        "\n[connectors.reeved]\nlength = {}\nmass = {}\nparticles = {}\nover = [\"one\", "
        "\"other\"]\nfrom = {{ point_mass = {} }}\nto = {{ point_mass = {} }}\nradius = "
        "0.005\nstart = {{ before = {} }}",
        2 * length_, dice_.scale(1e-3, 1), 3 + dice_.pick(5), dice_.scale(0.1, 2),
        dice_.scale(0.1, 2), length_ * dice_.between(0.4, 0.8));
  }

  Features features_;
  bool in_plane_ = false;
  Vec3 along_ = Vec3(0, -1, 0);
};

}  // namespace

std::string pair_text(unsigned seed) {
  return Pair(seed).drawn();
}

unsigned pair_count() {
  return kSceneFeatures * (kSceneFeatures + 1) / 2;
}

}  // namespace taut::drawn
