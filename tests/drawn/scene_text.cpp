#include "tests/drawn/scene_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "tests/drawn/pieces.h"

namespace taut::drawn {
namespace {

constexpr const char* kFree = "{ free = true }";

class Scene : Pieces {
 public:
  explicit Scene(unsigned seed)
      : Pieces(seed), own_dice_(~seed), meeting_dice_(seed ^ 0x2545f491u) {}

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
    most_ = chance(0.1) ? 40 : 10;
    const double kind = dice_.between(0, 1);
    const bool spans = kind < 0.15;
    const bool obstacles = kind > 0.85;
    const bool joins = kind > 0.5 && kind < 0.7;
    sections_ = kind > 0.35 && kind < 0.55;
    strings_ = !spans && !joins && !sections_ && own_dice_.between(0, 1) < 0.25;
    const bool alone = !spans && !joins && !sections_ && !obstacles;
    const bool meets = alone && meeting_dice_.between(0, 1) < 0.3;
    winches_ = alone && !meets && !strings_ && winch_dice_.between(0, 1) < 0.3;
    if (sections_) add_air();
    const int connectors = 1 + dice_.pick(3);
    for (int i = 0; i < connectors; ++i) {
      if (joins && chance(0.25)) {
        i == 0 && chance(0.4) ? add_loop() : add_net();
      } else if (joins && !strands_.empty() && chance(0.8)) {
        add_branch();
      } else {
        add_connector(spans && chance(0.7));
      }
    }
    if (obstacles) {
      for (int i = 1 + dice_.pick(2); i > 0; --i) add_obstacle(i);
    }
    if (meets) add_meeting();
    if (!spans) {
      for (const Strand& strand : std::vector(strands_)) {
        if (strand.winched) continue;
        while (chance(0.25)) add_pin(strand);
        while (chance(0.15)) add_cut(strand);
      }
    }
    if (winches_ && pulley_dice_.between(0, 1) < 0.6) add_route(most_);
    return text_;
  }

 private:
  /// A strand that can be pinned, cut and joined to.
  struct Strand {
    std::string name;
    double length = 0;  // m
    int particles = 0;
    Vec3 place;            // m, of its first end, or near
    bool winched = false;  // neither pinned nor cut
  };

  /// The hold of the first end, and its place.
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

  void add_connector(bool span) {
    constexpr const char* kLooks[] = {"chain", "rope", "cord"};
    Vec3 place;
    std::string from = first_end(place, span);
    const Vec3 along = dice_.direction();
    const double length = length_ * dice_.between(0.3, 1);
    bool straight = true;
    std::string to = last_end(place, along, length, straight, span);
    const int particles = span ? 2 : static_cast<int>(dice_.scale(straight ? 2 : 4, most_));
    std::string section;
    // Few methods follow a free body on what stretches.
    if (sections_ && !span && (is_led(from) || chance(0.05)) && (is_led(to) || chance(0.05))) {
      const Vec3 way = chance(0.8) ? along : dice_.direction();
      section = add_section(length, from, to, way);
    }
    const std::string name = begin_connector(length, particles, place);
    line("length = {}\nparticles = {}", length, particles);
    if (span) {
      line("model = \"span\"\nmass = 0\nrestitution = {}", dice_.between(0, 1));
    } else if (section.find("density") == section.npos) {
      line("mass = {}", mass_);
    }
    const bool pulls = strings_ && own_dice_.between(0, 1) < 0.7;
    if (pulls) line("links = \"pull\"");
    const bool winched = winches_ && has_place(from) && (is_led(to) || particles > 2);
    if (winched) {
      add_winch(length, straight, from);
      if (has_place(to) && winch_dice_.between(0, 1) < 0.3) add_winch(length, false, to);
      strands_.back().winched = true;
      section = winched_section(mass_ * length * length);
    }
    line("from = {}\nto = {}", from, to);
    // Without a start it hangs between its ends, or straight down from the one that has a place.
    const bool adrift = from == kFree;
    if (straight && (adrift || chance(0.8))) {
      std::string start = fmt::format("direction = {}", text(along));
      if (adrift) {
        const double way = pulls ? own_dice_.between(0.2, 1.1) : 1.001;
        start = fmt::format("points = [{}, {}]", text(place), text(place + way * length * along));
      } else if (to == kFree && particles > 3 && chance(0.2)) {
        start =
            fmt::format("hanging_to = {}", text(place + dice_.between(0.2, 0.95) * length * along));
      } else if (to == kFree && chance(0.3)) {
        start += fmt::format(", spin = {}", text(dice_.within(5)));
      }
      line("start = {{ {} }}", start);
    }
    const int look = dice_.pick(3);
    line("look = \"{}\"", winched ? "rope" : kLooks[look]);
    line("radius = {}", length * dice_.scale(1e-3, 1e-2));
    text_ += section;
    if (from.find("fixed") != from.npos && to.find("path") == to.npos && is_led(to) &&
        chance(0.1) && !winched) {
      line("repeat = [{{ count = {}, by = {} }}]", 1 + dice_.pick(4), text(dice_.within(length)));
    }
  }

  static bool is_led(const std::string& end) { return end.find("body") == end.npos; }

  /// The table of a connector; all that follows stands in it.
  std::string begin_connector(double length, int particles, const Vec3& place) {
    const std::string name = fmt::format("c{}", strands_.size());
    strands_.push_back({name, length, particles, place});
    mass_ = dice_.scale(1e-3, 1);
    line("\n[connectors.{}]", name);
    return name;
  }

  /// The place of one of its particles.
  std::string joined_to(const Strand& strand, int particle) const {
    return fmt::format("{{ connector = \"{}\", at = {} }}", strand.name,
                       strand.length / (strand.particles - 1) * particle);
  }

  /// Hangs from a particle of one that there is.
  void add_branch() {
    const Strand trunk =
        strands_[static_cast<std::size_t>(dice_.pick(static_cast<int>(strands_.size())))];
    if (trunk.name.starts_with("net")) return add_net();
    const Vec3 along = dice_.direction();
    const double length = length_ * dice_.between(0.2, 1), kind = dice_.between(0, 1);
    std::string to = kFree;
    if (kind < 0.3) to = fmt::format("{{ point_mass = {} }}", dice_.scale(1e-3, 10));
    if (kind > 0.7) {
      to = fmt::format("{{ body = \"{}\", point = {} }}",
                       add_body(fmt::format("hangs = {}", text(along))),
                       text(dice_.scale(0.01, 0.1) * length_ * dice_.direction()));
    }
    const int particles = static_cast<int>(dice_.scale(2, most_));
    begin_connector(length, particles, trunk.place);
    line("length = {}\nparticles = {}\nmass = {}", length, particles, mass_);
    line("from = {}\nto = {}", joined_to(trunk, dice_.pick(trunk.particles)), to);
    line("start = {{ direction = {} }}", text(along));
  }

  void add_loop() {
    const Vec3 centre = dice_.within(length_);
    const double length = length_ * dice_.between(0.5, 2);
    const int particles = 5 + dice_.pick(static_cast<int>(most_));
    const std::string name = begin_connector(length, particles, centre);
    line("length = {}\nparticles = {}\nmass = {}", length, particles, mass_);
    line("from = {}\nto = {{ connector = \"{}\", at = 0.0 }}", kFree, name);
    line("start = {{ circle = {{ centre = {}, axis = {} }}{} }}", text(centre),
         text(dice_.direction()),
         chance(0.5) ? fmt::format(", spin = {}", text(dice_.within(8))) : "");
    if (chance(0.7)) return;
    const double spoke = length * dice_.between(0.3, 1);  // the circle is a sixth of it away
    begin_connector(spoke, 5, centre);
    line("length = {}\nparticles = 5\nmass = {}", spoke, mass_);
    line("from = {{ fixed = {} }}\nto = {{ connector = \"{}\", at = 0.0 }}", text(centre), name);
  }

  void add_net() {
    constexpr const char* kKinds[] = {"net", "net", "ladder", "web"};
    constexpr const char* kHeld[] = {"nothing", "upper corners", "upper edge", "corners", "edges"};
    const std::string kind = kKinds[dice_.pick(4)];
    const bool web = kind == "web";
    const std::string held = web ? kHeld[4 * dice_.pick(2)] : kHeld[dice_.pick(5)];
    const Vec3 across = dice_.direction(), place = dice_.within(length_);
    const double width = length_ * dice_.between(0.3, 1), height = length_ * dice_.between(0.3, 1);
    const std::string name = fmt::format("net{}", nets_++);
    line("\n[nets.{}]\nkind = \"{}\"\nheld = \"{}\"", name, kind, held);
    line("origin = {}\nacross = {}\ndown = {}", text(place), text(across),
         text(across.unitOrthogonal()));
    const bool stretches = chance(0.4);
    const bool waves = (!stretches && held != "nothing") || chance(0.3);
    const int least = waves ? 4 : 1;  // cells: a wave is of four links
    line("size = [{}, {}]\ncells = [{}, {}]\nlinks = {}", width, height,
         std::max(least, web ? 3 : 1) + dice_.pick(3), least + dice_.pick(3), 1 + dice_.pick(3));
    line("mass = {}", dice_.scale(1e-3, 1));
    if (stretches) line("axial_stiffness = {}", dice_.scale(0.1, 1e5));
    if (stretches && chance(0.5)) line("axial_damping = {}", dice_.scale(1e-4, 1));
    if (waves) line("slack = {}", dice_.between(0.02, 0.2));
    strands_.push_back({name + "#1", std::min(width, height), 2, place});
  }

  void add_pin(const Strand& strand) {
    line("\n[[pins]]\nconnector = \"{}\"", strand.name);
    const double at = strand.length * dice_.between(0, 1);
    line("at = {}", at);
    const double from = dice_.between(0, 0.9);
    line("from = {}", from);
    if (chance(0.7)) line("until = {}", from + dice_.scale(1e-3, 0.5));
    if (paths_ > 0 && chance(0.1)) {
      line("path = \"path{}\"", dice_.pick(paths_));
    } else if (chance(0.2)) {
      line("point = {}", text(strand.place + dice_.within(0.5 * at)));
    } else {
      return;
    }
    line("over = {}", dice_.scale(0.01, 0.5));  // taken there at once, links are torn
  }

  void add_cut(const Strand& strand) {
    line("\n[[cuts]]\nconnector = \"{}\"", strand.name);
    line("at = {}\nt = {}", strand.length * dice_.between(0.01, 0.99), dice_.between(0, 0.99));
  }

  /// Over a round obstacle that stands still, or wound on it.
  void add_wound(const std::string& obstacle, double diameter) {
    const double turns = chance(0.6) ? 0.5 : dice_.between(0.3, 2.5);
    const double before = length_ * dice_.between(0.1, 1), radius = 0.005 * length_;
    const double wound = 3.2 * (diameter + 2 * radius) * turns;
    const double length = 1.1 * wound + before + length_ * dice_.between(0.1, 1);
    begin_connector(length, static_cast<int>(dice_.scale(10, 4 * most_)), Vec3::Zero());
    line("length = {}\nparticles = {}\nmass = {}", length, strands_.back().particles, mass_);
    for (const char* end : {"from", "to"}) {
      line("{} = {}", end,
           chance(0.3) ? std::string(kFree)
                       : fmt::format("{{ point_mass = {} }}", dice_.scale(1e-3, 10)));
    }
    line("start = {{ over = {{ obstacle = \"{}\", turns = {}, before = {} }} }}", obstacle, turns,
         before);
    line("radius = {}", radius);
  }

  void add_obstacle(int number) {
    constexpr const char* kRound[] = {"capsule", "cylinder"};
    const std::string name = fmt::format("o{}", number);
    const double size = length_ * dice_.scale(0.03, 0.5);
    const bool plane = number == 1 && chance(0.5);
    bool round = false;
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
          round = true;
          shape = fmt::format("{} = {{ length = {}, diameter = {} }}", kRound[dice_.pick(2)],
                              size * dice_.between(1, 5), size);
      }
      if (chance(0.2)) path = add_path(2 * length_ * dice_.direction());
    }
    line("\n[obstacles.{}]\nshape = {{ {} }}", name, shape);
    if (!path.empty()) line("path = \"{}\"", path);
    const Vec3 below = Vec3(0, -length_ * dice_.between(0.5, 2), 0);
    line("position = {}", text(plane          ? below
                               : path.empty() ? Vec3(below + dice_.within(length_))
                                              : Vec3::Zero()));
    if (path.empty() && chance(0.2)) {
      line("rotation = [1, {}, {}, {}]", dice_.between(-1, 1), dice_.between(-1, 1),
           dice_.between(-1, 1));
    }
    const double friction = chance(0.6) ? dice_.scale(0.01, 2) : 0;
    if (friction > 0) line("friction = {}", friction);
    if (friction > 0 && chance(0.2)) {
      line("static_friction = {}", friction * dice_.between(1, 2));
    }
    if (chance(0.3)) line("restitution = {}", dice_.between(0, 1));
    if (!strands_.empty() && own_dice_.between(0, 1) < 0.15) {
      line("ignores = [\"{}\"]", strands_.front().name);
    }
    if (round && path.empty() && chance(0.3)) add_wound(name, size);
  }

  /// Sticks on their way to one that hangs or flies.
  void add_meeting() {
    Dice& dice = meeting_dice_;
    const Vec3 middle = dice.within(length_);
    const double size = length_ * dice.scale(0.02, 0.3);
    const int count = 2 + dice.pick(2);
    std::string names;
    for (int i = 0; i < count; ++i) {
      const std::string name = fmt::format("stick{}", i);
      names += (i > 0 ? ", \"" : "\"") + name + '"';
      line("\n[bodies.{}]\nmass = {}", name, dice.scale(1e-2, 10));
      const double diameter = size * dice.between(0.05, 0.4);
      line("shape = {{ cylinder = {{ length = {}, diameter = {} }} }}\ncontact = {{}}", size,
           diameter);
      const bool hangs = i == 0 && dice.between(0, 1) < 0.5;
      const Vec3 way = dice.direction();
      if (hangs) {
        line("hangs = [0, -1, 0]");
        hang(name, middle + size / 2 * Vec3::UnitY(), size);
        continue;
      }
      // Each comes from a distance at which none can reach another.
      const Vec3 apart = i == 0 ? Vec3(Vec3::Zero()) : Vec3(3.0 * i * size * way);
      line("position = {}\nspin = {}", text(middle + apart), text(dice.within(8)));
      line("velocity = {}", text(-dice.between(1, 6) * apart));
      line("rotation = [{}, {}, {}, {}]", dice.between(0.1, 1), dice.between(-1, 1),
           dice.between(-1, 1), dice.between(-1, 1));
    }
    text_ += hung_;
    line("\n[touching.sticks]\nbodies = [{}]", names);
    if (dice.between(0, 1) < 0.6) line("friction = {}", dice.scale(0.01, 2));
    if (dice.between(0, 1) < 0.5) line("restitution = {}", dice.between(0, 1));
  }

  /// The connector from which a stick hangs by its upper end, at `end`.
  void hang(const std::string& body, const Vec3& end, double size) {
    const double length = length_ * meeting_dice_.between(0.2, 0.6);
    hung_ = fmt::format(
        "\n[connectors.hung]\nlength = {}\nparticles = {}\nmass = {}\nfrom = {{ fixed = {} }}\n"
        "to = {{ body = \"{}\", point = {} }}\nstart = {{ direction = [0, -1, 0] }}\n",
        length, 2 + meeting_dice_.pick(8), meeting_dice_.scale(1e-3, 1),
        text(end + length * Vec3::UnitY()), body, text(size / 2 * Vec3::UnitY()));
  }

  double most_ = 0;        // particles: few find as much as many, and take less time
  double mass_ = 1;        // kg, of the last connector
  bool sections_ = false;  // connectors stretch, bend or meet the air
  bool strings_ = false;   // links of connectors only pull
  Dice own_dice_;          // for what came later, so that what else is drawn stays
  Dice meeting_dice_;      // for what came later still
  bool winches_ = false;
  std::string hung_;  // the connector of a stick that hangs
  std::vector<Strand> strands_;
  int nets_ = 0;
};

}  // namespace

std::string scene_text(unsigned seed) {
  return Scene(seed).drawn();
}

}  // namespace taut::drawn
