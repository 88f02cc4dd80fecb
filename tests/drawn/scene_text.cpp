#include "tests/drawn/scene_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "tests/support/dice.h"

namespace taut::drawn {
namespace {

std::string text(const Vec3& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

constexpr const char* kFree = "{ free = true }";

class Scene {
 public:
  explicit Scene(unsigned seed) : dice_(seed) {}

  std::string drawn() {
    constexpr int kRates[] = {1, 5, 24, 24, 30, 30, 60, 60, 60, 120, 120, 240};
    const bool falls = chance(0.9);
    const Vec3 gravity =
        chance(0.8) ? Vec3(0, -9.81, 0) : dice_.scale(0.1, 100) * dice_.direction();
    length_ = dice_.scale(0.1, 5);
    text_ =
        fmt::format("duration = 1.0\nfps = {}\ngravity = {}\n\n[method]\nname = \"direct\"\n",
                    kRates[dice_.pick(std::size(kRates))], text(falls ? gravity : Vec3::Zero()));
    text_ += fmt::format("tolerance = {}\n", length_ * dice_.scale(1e-6, 1e-1));
    const bool spans = chance(0.15);
    most_ = chance(0.1) ? 40 : 10;
    const int connectors = 1 + dice_.pick(3);
    for (int i = 0; i < connectors; ++i) add_connector(i, spans && chance(0.7));
    if (!spans) {
      for (int i = 0; i < connectors; ++i) {
        while (chance(0.25)) add_pin(i);
        while (chance(0.15)) add_cut(i);
      }
    }
    if (!spans && chance(0.25)) {
      for (int i = 1 + dice_.pick(2); i > 0; --i) add_obstacle(i);
    }
    return text_;
  }

 private:
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
    std::string keys = fmt::format("{{ t = 0, position = {}, ease = true }}", text(start));
    Vec3 place = start;
    double time = 0;
    for (int i = dice_.pick(4); i > 0; --i) {
      time += dice_.between(0.15, 0.6);
      place += dice_.within(0.1 * length_);
      keys += fmt::format(", {{ t = {}, position = {}{}{} }}", time, text(place),
                          chance(0.3) ? ", ease = true" : "",
                          chance(0.2) ? fmt::format(", axis = {}", text(dice_.direction())) : "");
    }
    line("keys = [{}]", keys);
    return name;
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
    return name;
  }

  /// What holds the first end, and where that is.
  std::string first_end(Vec3& place, bool span) {
    place = dice_.within(length_);
    const double kind = dice_.between(0, 1);
    if (kind < 0.4) return fmt::format("{{ fixed = {} }}", text(place));
    if (kind < 0.6) return fmt::format("{{ path = \"{}\" }}", add_path(place));
    const Vec3 point = dice_.within(0.02 * length_);
    if (kind < 0.7) {
      const std::string path = add_path(place);
      const std::string body = add_body(fmt::format("driven_by = {{ path = \"{}\" }}", path));
      return fmt::format("{{ body = \"{}\", point = {} }}", body, text(point));
    }
    if (kind < 0.85) {
      const std::string body =
          add_body(fmt::format("position = {}\nvelocity = {}\nspin = {}", text(place),
                               text(dice_.within(length_)), text(dice_.within(5))));
      return fmt::format("{{ body = \"{}\", point = {} }}", body, text(point));
    }
    if (kind < 0.93 || span) return fmt::format("{{ fixed = {} }}", text(place));
    return kFree;
  }

  std::string last_end(const Vec3& from, const Vec3& along, double length, bool& straight,
                       bool span) {
    const double kind = dice_.between(0, 1);
    straight = true;
    if (kind < 0.25 && !span) return kFree;
    if (kind < 0.5) return fmt::format("{{ point_mass = {} }}", dice_.scale(1e-3, 10));
    if (kind < 0.75) {
      const std::string body = add_body(fmt::format("hangs = {}", text(along)));
      return fmt::format("{{ body = \"{}\", point = {} }}", body,
                         text(dice_.scale(0.01, 0.1) * length_ * dice_.direction()));
    }
    straight = false;
    const Vec3 there = from + dice_.between(0.2, 0.95) * length * along;
    if (kind < 0.85) return fmt::format("{{ fixed = {} }}", text(there));
    if (kind < 0.92) return fmt::format("{{ path = \"{}\" }}", add_path(there));
    const std::string body = add_body(fmt::format("position = {}", text(there)));
    return fmt::format("{{ body = \"{}\" }}", body);
  }

  void add_connector(int number, bool span) {
    constexpr const char* kLooks[] = {"chain", "rope", "cord"};
    Vec3 place;
    const std::string from = first_end(place, span);
    const Vec3 along = dice_.direction();
    const double length = length_ * dice_.between(0.3, 1);
    bool straight = true;
    const std::string to = last_end(place, along, length, straight, span);
    line("\n[connectors.c{}]", number);
    lengths_[number] = length;
    line("length = {}", length);
    if (span) {
      line("model = \"span\"\nparticles = 2\nmass = 0\nrestitution = {}", dice_.between(0, 1));
    } else {
      line("mass = {}", dice_.scale(1e-3, 1));
      line("particles = {}", static_cast<int>(dice_.scale(straight ? 2 : 4, most_)));
    }
    line("from = {}\nto = {}", from, to);
    // Without a start it hangs between its ends, or straight down from the one that has a place.
    const bool adrift = from == kFree;
    if (straight && (adrift || chance(0.8))) {
      line("start = {{ {} = {} }}", adrift ? "points" : "direction",
           adrift ? fmt::format("[{}, {}]", text(place), text(place + 1.001 * length * along))
                  : text(along));
    }
    line("look = \"{}\"", kLooks[dice_.pick(3)]);
    line("radius = {}", length * dice_.scale(1e-3, 1e-2));
    if (from.find("fixed") != from.npos && to.find("body") == to.npos && chance(0.1)) {
      line("repeat = [{{ count = {}, by = {} }}]", 1 + dice_.pick(4), text(dice_.within(length)));
    }
  }

  void add_pin(int number) {
    line("\n[[pins]]\nconnector = \"c{}\"", number);
    line("at = {}", lengths_[number] * dice_.between(0, 1));
    const double from = dice_.between(0, 0.9);
    line("from = {}", from);
    if (chance(0.7)) line("until = {}", from + dice_.scale(1e-3, 0.5));
  }

  void add_cut(int number) {
    line("\n[[cuts]]\nconnector = \"c{}\"", number);
    line("at = {}\nt = {}", lengths_[number] * dice_.between(0.01, 0.99), dice_.between(0, 0.99));
  }

  void add_obstacle(int number) {
    constexpr const char* kRound[] = {"capsule", "cylinder"};
    const double size = length_ * dice_.scale(0.03, 0.5);
    const bool plane = number == 1 && chance(0.5);
    std::string shape = "plane = {}", path;
    if (!plane) {
      switch (dice_.pick(3)) {
        case 0:
          shape = fmt::format("sphere = {{ diameter = {} }}", size);
          break;
        case 1:
          shape = fmt::format("box = {{ size = {}, rounding = {} }}",
                              text(size * (Vec3::Constant(1.1) + dice_.within(0.8))), 0.1 * size);
          break;
        default:
          shape = fmt::format("{} = {{ length = {}, diameter = {} }}", kRound[dice_.pick(2)],
                              size * dice_.between(1, 5), size);
      }
      if (chance(0.2)) path = add_path(2 * length_ * dice_.direction());
    }
    line("\n[obstacles.o{}]\nshape = {{ {} }}", number, shape);
    if (!path.empty()) line("path = \"{}\"", path);
    const Vec3 below = Vec3(0, -length_ * dice_.between(0.5, 2), 0);
    line("position = {}", text(plane          ? below
                               : path.empty() ? Vec3(below + dice_.within(length_))
                                              : Vec3::Zero()));
    if (chance(0.6)) line("friction = {}", dice_.scale(0.01, 2));
    if (chance(0.3)) line("restitution = {}", dice_.between(0, 1));
  }

  Dice dice_;
  std::string text_;
  double length_ = 1;  // m, which all sizes go by
  double lengths_[3] = {};
  double most_ = 0;  // particles: few find as much as many, and take less time
  int paths_ = 0, bodies_ = 0;
};

}  // namespace

std::string scene_text(unsigned seed) {
  return Scene(seed).drawn();
}

}  // namespace taut::drawn
