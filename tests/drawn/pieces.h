// Paths, bodies, the air and what connectors are made of, drawn.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "tests/support/dice.h"

namespace taut::drawn {

inline std::string text(const Vec3& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

/// A scene that grows.
class Pieces {
 protected:
  explicit Pieces(unsigned seed)
      : dice_(seed),
        twist_dice_(seed ^ 0x5bd1e995u),
        winch_dice_(seed ^ 0x9e3779b9u),
        pulley_dice_(seed ^ 0x85ebca6bu) {}

  bool chance(double share) { return dice_.between(0, 1) < share; }

  template <typename... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    text_ += fmt::format(format, std::forward<Args>(args)...) + '\n';
  }

  /// A path from that place on, at walking pace.
  std::string add_path(const Vec3& start) {
    const std::string name = fmt::format("path{}", paths_++);
    line("\n[paths.{}]", name);
    if (chance(0.4)) {
      const Vec3 axis = dice_.direction();
      const Vec3 radius = dice_.scale(0.02, 0.3) * length_ * axis.unitOrthogonal();
      line("circle = {{ centre = {}, start = {}, axis = {}, frequency = {}, ramp = {} }}",
           text(start + radius), text(start), text(axis), dice_.between(0.2, 2),
           dice_.between(0.1, 0.6));
      return name;
    }
    if (chance(0.2)) {
      line(
          "axle = {{ position = {}, axis = {}, pitch = {}, keys = [{{ t = {}, angle = 0 }}, "
          "{{ t = {}, angle = {} }}] }}",
          text(start), text(dice_.direction()), dice_.between(-0.1, 0.1) * length_,
          dice_.between(0, 0.2), dice_.between(0.4, 1.2), dice_.between(-6, 6));
      return name;
    }
    std::string keys = fmt::format("{{ t = 0, position = {}, ease = true }}", text(start));
    Vec3 place = start;
    double time = 0;
    for (int i = dice_.pick(4); i > 0; --i) {
      time += dice_.between(0.15, 0.6);
      place += dice_.within(0.1 * length_);
      keys += fmt::format(", {{ t = {}, position = {}{}{} }}", time, text(place),
                          chance(0.3) ? ", ease = true" : "",
                          chance(0.2) ? fmt::format(", axis = {}", text(dice_.direction())) : "");
      if (chance(0.1)) {
        keys.replace(keys.size() - 2, 2, fmt::format(", hold = {} }}", dice_.between(0.05, 0.2)));
        time += 0.2;
      }
    }
    line("keys = [{}]", keys);
    return name;
  }

  /// Whether it is fixed, or on a path.
  static bool has_place(const std::string& end) {
    return end.find("fixed") != end.npos || end.find("path") != end.npos;
  }

  /// Lets the end pay out, or take in where it may.
  void add_winch(double length, bool takes_in, std::string& end) {
    Dice& dice = winch_dice_;
    std::string keys = "{ t = 0, paid_out = 0 }";
    double time = 0, paid_out = 0;
    for (int i = 1 + dice.pick(3); i > 0; --i) {
      time += dice.between(0.15, 0.6);
      const double least = takes_in ? -0.7 * length : 0;
      paid_out = std::max(paid_out + length * dice.between(takes_in ? -0.4 : 0, 0.4), least);
      keys += fmt::format(", {{ t = {}, paid_out = {}{} }}", time, paid_out,
                          dice.between(0, 1) < 0.3 ? ", ease = true" : "");
    }
    end.insert(end.size() - 2, fmt::format(", winch = [{}]", keys));
  }

  /// The section of a rope with a winch: `stiffness` (N m^2) is much.
  std::string winched_section(double stiffness) {
    if (winch_dice_.between(0, 1) > 0.3) return {};
    return fmt::format("bending_stiffness = {}\n", stiffness * winch_dice_.scale(1e-5, 1));
  }

  std::string shape() {
    const double size = length_ * dice_.scale(0.02, 0.3);
    switch (dice_.pick(3)) {
      case 0:
        return fmt::format("{{ sphere = {{ diameter = {} }} }}", size);
      case 1:
        return fmt::format("{{ cylinder = {{ length = {}, diameter = {} }} }}",
                           size * dice_.between(1, 4), size * dice_.between(0.1, 1));
      default:
        return fmt::format("{{ box = {{ size = {} }} }}",
                           text(size * (Vec3::Constant(1.2) + dice_.within(1))));
    }
  }

  std::string add_body(const std::string& how) {
    const std::string name = fmt::format("body{}", bodies_++);
    line("\n[bodies.{}]", name);
    line("mass = {}", dice_.scale(1e-3, 10));
    if (chance(0.8)) {
      line("shape = {}", shape());
    } else {
      const double moment = dice_.scale(1e-5, 1e-2);
      line("inertia = [{}, {}, {}]", moment, moment * dice_.between(0.5, 1),
           moment * dice_.between(0.6, 1.4));
    }
    line("{}", how);
    if (how.starts_with("position") && chance(0.3)) {
      line("rotation = [{}, {}, {}, {}]", dice_.between(0.1, 1), dice_.between(-1, 1),
           dice_.between(-1, 1), dice_.between(-1, 1));
    }
    return name;
  }

  void add_air() {
    const std::string density =
        chance(0.3) ? fmt::format("density = {}, ", dice_.scale(0.1, 100)) : "";
    text_.insert(0, fmt::format("air = {{ {}wind = {} }}\n", density,
                                text(chance(0.5) ? dice_.within(10) : Vec3::Zero())));
  }

  /// The section of the rope; clamps of its ends stand in these.
  std::string add_section(double length, std::string& from, std::string& to, const Vec3& along) {
    std::string section;
    const auto key = [&](const char* name, double value) {
      section += fmt::format("{} = {}\n", name, value);
    };
    const double weight = 10 * dice_.scale(1e-3, 1);  // N, about
    bool bends = true;
    if (chance(0.2)) {
      section += fmt::format("material = {{ youngs_modulus = {}, diameter = {}, density = {} }}\n",
                             dice_.scale(1e5, 1e9), length * dice_.scale(1e-3, 5e-2),
                             dice_.scale(100, 8000));
    } else {
      const bool stretches = chance(0.6);
      bends = chance(0.6);
      const double axial = weight * dice_.scale(3, 1e6);
      if (stretches) key("axial_stiffness", axial);
      if (stretches && chance(0.5)) key("axial_damping", axial * dice_.scale(1e-6, 1e-3));
      const double bending = weight * length * length * dice_.scale(1e-6, 0.1);
      if (bends) key("bending_stiffness", bending);
      if (bends && chance(0.5)) key("bending_damping", bending * dice_.scale(1e-6, 1e-3));
    }
    if (chance(0.4)) {
      section += fmt::format("drag = {{ across = {}, along = {} }}\n", dice_.between(0.1, 2),
                             dice_.between(0, 0.1));
    }
    if (chance(0.2)) {
      section += fmt::format("taper = [{}, {}, {}]\n", dice_.between(0.3, 1), dice_.between(0.3, 1),
                             dice_.between(0.3, 1));
    }
    for (std::string* end : {&from, &to}) {
      const bool held = end->find("fixed") != end->npos || end->find("path") != end->npos;
      if (bends && held && chance(0.3)) {
        end->replace(end->size() - 2, 2, fmt::format(", clamp = {} }}", text(along)));
      }
    }
    const auto clamped = [](const std::string& end) { return end.find("clamp") != end.npos; };
    if (clamped(from) && clamped(to)) add_twist(weight * length * length, to, section);
    return section;
  }

  /// Most connectors between two clamps resist twist, and some are twisted.
  void add_twist(double stiffness, std::string& to, std::string& section) {
    const bool solid = section.find("material") != section.npos;
    if (!solid && twist_dice_.between(0, 1) < 0.3) return;
    if (!solid) {
      const double twisting = stiffness * twist_dice_.scale(1e-6, 0.1);
      section += fmt::format("twisting_stiffness = {}\n", twisting);
      if (twist_dice_.between(0, 1) < 0.5) {
        section += fmt::format("twisting_damping = {}\n", twisting * twist_dice_.scale(1e-6, 1e-3));
      }
    }
    if (twist_dice_.between(0, 1) < 0.3) {
      section += fmt::format("rest_twist = {}\n", twist_dice_.between(-5, 5));
    }
    if (twist_dice_.between(0, 1) < 0.5) {
      to.replace(to.size() - 2, 2,
                 fmt::format(", turn = [{{ t = 0, angle = {} }}, {{ t = {}, angle = {} }}] }}",
                             twist_dice_.between(-2, 2), twist_dice_.between(0.3, 2),
                             twist_dice_.between(-20, 20)));
    }
  }

  /// A rope over pulleys, which are fixed, on paths or on bodies.
  void add_route(double most) {
    Dice& dice = pulley_dice_;
    const bool massless = dice.between(0, 1) < 0.3;
    Vec3 place = dice.within(length_);
    std::string names, pulleys;
    double length = 0;
    for (int i = 0, count = 1 + dice.pick(3); i < count; ++i) {
      const double apart = length_ * dice.between(0.3, 1), kind = dice.between(0, 1);
      if (i > 0) place += apart * dice.direction();
      if (i > 0) length += apart;
      std::string held = fmt::format("fixed = {}", text(place));
      if (kind > 0.5) held = fmt::format("path = \"{}\"", add_path(place));
      if (kind > 0.7) {
        held = fmt::format("body = \"{}\"", add_body(fmt::format("position = {}", text(place))));
      }
      const double inertia = dice.between(0, 1) < 0.5 ? dice.scale(1e-3, 1) : 0;
      std::string turns = fmt::format("inertia = {}", inertia);
      if (kind < 0.7 && dice.between(0, 1) < 0.2) {
        turns = fmt::format("passed = [{{ t = 0, passed = 0 }}, {{ t = {}, passed = {} }}]",
                            dice.between(0.2, 1), length_ * dice.between(-0.1, 0.1));
      } else if (kind < 0.7 || massless) {
        const double rubs = dice.between(0, 1);
        if (rubs < 0.3) turns += fmt::format(", friction = {}", dice.scale(1e-2, 1));
        if (rubs > 0.7) turns += fmt::format(", bearing = {}", dice.scale(1e-2, 0.3));
      }
      pulleys += fmt::format("p{} = {{ {}, {} }}\n", i, held, turns);
      names += fmt::format("{}\"p{}\"", i > 0 ? ", " : "", i);
    }
    const auto mass = [&] { return fmt::format("{{ point_mass = {} }}", dice.scale(1e-2, 1)); };
    const double before = length_ * dice.between(0.3, 1), after = length_ * dice.between(0.3, 1);
    const Vec3 along = dice.direction();
    const double kind = dice.between(0, 1);
    std::string to = mass(), taut;
    if (kind > 0.4 && !massless) to = "{ free = true }";
    if (kind > 0.6 && kind < 0.8) {
      to = fmt::format("{{ body = \"{}\", point = {} }}",
                       add_body(fmt::format("hangs = {}", text(along))),
                       text(dice.scale(0.01, 0.1) * length_ * dice.direction()));
    }
    if (kind > 0.8) to = fmt::format("{{ fixed = {} }}", text(place + after * along));
    length += before + after * (kind > 0.8 && !massless ? dice.between(1, 1.3) : 1);
    line("\n[pulleys]\n{}\n[connectors.route]", pulleys);
    line("length = {}\nmass = {}\nparticles = {}\nover = [{}]", length,
         massless ? 0 : dice.scale(1e-3, 1), massless ? 2 : static_cast<int>(dice.scale(4, most)),
         names);
    line("from = {}\nto = {}\nradius = 0.005", mass(), to);
    line("start = {{ before = {}, direction = {} }}", before, text(along));
  }

  Dice dice_;
  Dice twist_dice_, winch_dice_, pulley_dice_;  // of their own, so that what else is drawn stays
  std::string text_;
  double length_ = 1;  // m, which all sizes go by
  int paths_ = 0, bodies_ = 0;
};

}  // namespace taut::drawn
