// Nets, rope ladders and webs, made of a few numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "scenes/reader/reader.h"

namespace taut::scenes {
namespace {

constexpr double kMostInANet = 1e6;  // of all cords of a net

/// A cord that waves sideways: where its particles are along the way and aside, in its own length.
struct Wave {
  std::vector<double> along, aside;
};

/// Links of equal length whose directions swing by as much as makes them shorter by the share
/// `slack`, in so many whole waves: both ends are on the line.
Wave wave(std::size_t links, double slack, double pleats) {
  const double n = static_cast<double>(links);
  const auto turn = [&](std::size_t k, double most) {
    const double at = (static_cast<double>(k) + 0.5) / n;
    return most * std::sin(2 * std::numbers::pi * pleats * at);
  };
  const auto length = [&](double most) {
    double sum = 0;
    for (std::size_t k = 0; k < links; ++k) sum += std::cos(turn(k, most));
    return sum / n;
  };
  double low = 0, high = slack > 0 ? std::numbers::pi / 2 : 0;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (length(middle) > 1 - slack ? low : high) = middle;
  }
  Wave wave{{0}, {0}};
  for (std::size_t k = 0; k < links; ++k) {
    wave.along.push_back(wave.along.back() + std::cos(turn(k, low)) / n);
    wave.aside.push_back(wave.aside.back() + std::sin(turn(k, low)) / n);
  }
  return wave;
}

std::size_t cell(const Value& net, std::size_t index) {
  return static_cast<std::size_t>(net.find("cells")->children[index].number);
}

std::size_t links_of(const Value& net) {
  return static_cast<std::size_t>(number_or(net, "links", 1));
}

class NetReader {
 public:
  NetReader(const Document& document, const Value& net, World& world)
      : document_(document),
        net_(net),
        world_(world),
        kind_(net.find("kind")->text),
        held_(net.find("held")->text),
        columns_(cell(net, 0)),
        rows_(cell(net, 1)),
        links_(links_of(net)),
        slack_(number_or(net, "slack", 0)),
        first_(world.connectors.size()) {
    const Value& size = *net.find("size");
    width_ = size.children[0].number;
    height_ = size.children[1].number;
    origin_ = net.find("origin")->vec3();
    across_ = direction(document, *net.find("across"));
    down_ = direction(document, *net.find("down"));
    normal_ = across_.cross(down_).stableNormalized();
    if (normal_.norm() < 0.5) {
      document.mismatch(*net.find("down"), "another direction than across");
    }
  }

  void read() {
    check();
    kind_ == "web" ? web() : grid();
    weigh();
    for (std::size_t c = first_; c < world_.connectors.size(); ++c) {
      Connector& cord = world_.connectors[c];
      cord.name = fmt::format("{}#{}", net_.name, c - first_ + 1);
      cord.pulls = text_or(net_, "cords", "rigid") == "pull";
      read_cord(document_, net_, cord);
      std::ranges::sort(cord.holds, {}, &Hold::particle);
    }
  }

 private:
  void check() const {
    const double across = static_cast<double>(columns_ * bars());
    const double down = static_cast<double>(rows_ * links_);
    if (2 * (across + 1) * (down + 1) > kMostInANet) {
      document_.mismatch(*net_.find("cells"),
                         fmt::format("at most {} particles in all", kMostInANet));
    }
    if (kind_ == "web" && columns_ < 3) {
      document_.mismatch(net_.find("cells")->children[0], "at least 3 spokes of a web");
    }
    if (kind_ == "web" && held_ != "nothing" && held_ != "edges") {
      document_.mismatch(*net_.find("held"), "nothing or edges, of a web");
    }
    const double pleats = number_or(net_, "pleats", 1);
    double links = std::numeric_limits<double>::infinity();  // of the shorter cords in waves
    if (waves_across()) links = across;
    if (waves_down()) links = std::min(links, down);
    if (slack_ > 0 && links < 4 * pleats) {
      document_.fail_at_key(*net_.find("slack"),
                            fmt::format("lays cords of {} links in {} waves, expected at least 4 "
                                        "links for each",
                                        links, pleats));
    }
    if (!net_.find("axial_stiffness") && !net_.find("material") && slack_ == 0 && is_stretched()) {
      document_.fail_at_key(*net_.find("held"),
                            "holds rigid cords at their full length, which leaves no room to "
                            "move; expected slack above 0, axial_stiffness or material");
    }
  }

  /// Links across a cell.
  std::size_t bars() const { return kind_ == "ladder" ? 1 : links_; }
  bool waves_across() const { return kind_ != "web" && columns_ * bars() > 1; }
  bool waves_down() const { return kind_ == "web" || held_ == "corners" || held_ == "edges"; }

  /// Whether there are cords of several links between two places that are held.
  bool is_stretched() const {
    if (held_ == "nothing") return false;
    if (waves_down()) return true;
    return held_ == "upper edge" ? bars() > 1 : columns_ * bars() > 1;
  }

  bool is_held(std::size_t row, std::size_t column) const {
    const bool side = column == 0 || column == columns_;
    const bool top = row == 0, end = top || row == rows_;
    if (held_ == "edges") return side || end;
    if (held_ == "upper edge") return top;
    if (held_ == "corners") return side && end;
    return held_ == "upper corners" && side && top;
  }

  /// A cord through these places, of links that are `rest` (m) long, or as long as they are there.
  Connector& add(std::vector<Vec3> places, std::optional<double> rest = {}) {
    Connector cord;
    const std::size_t n = places.size();
    cord.velocity.assign(n, Vec3::Zero());
    cord.position = std::move(places);
    for (std::size_t k = 0; k + 1 < n; ++k) {
      cord.rest.push_back(rest.value_or((cord.position[k + 1] - cord.position[k]).norm()));
      cord.length += cord.rest.back();
    }
    if (rest) cord.length = *rest * static_cast<double>(n - 1);
    world_.connectors.push_back(std::move(cord));
    return world_.connectors.back();
  }

  static void hold(Connector& cord, std::size_t particle) {
    Hold made;
    made.particle = particle;
    made.to.point = cord.position[particle];
    cord.holds.push_back(made);
  }

  /// Ropes downwards; across them cords or, in a ladder, a rung for each cell.
  void grid() {
    const double pleats = number_or(net_, "pleats", 1);
    const std::size_t each = bars(), wide = columns_ * each, high = rows_ * links_;
    const Wave x = wave(wide, wide > 1 ? slack_ : 0, pleats);
    const Wave y = wave(high, waves_down() ? slack_ : 0, pleats);
    const auto place = [&](std::size_t i, std::size_t k) -> Vec3 {
      return origin_ + width_ * x.along[i] * across_ + height_ * y.along[k] * down_ +
             (width_ * x.aside[i] + height_ * y.aside[k]) * normal_;
    };
    const std::size_t joints = world_.joints.size();
    for (std::size_t column = 0; column <= columns_; ++column) {
      std::vector<Vec3> places;
      for (std::size_t k = 0; k <= high; ++k) places.push_back(place(column * each, k));
      Connector& rope = add(std::move(places), height_ / static_cast<double>(high));
      for (std::size_t row = 0; row <= rows_; ++row) {
        world_.joints.push_back({{{first_ + column, row * links_}}});
        if (is_held(row, column)) hold(rope, row * links_);
      }
    }
    const auto joint = [&](std::size_t row, std::size_t column) -> Joint& {
      return world_.joints[joints + column * (rows_ + 1) + row];
    };
    const std::size_t part = kind_ == "ladder" ? 1 : columns_;  // cells that a cord goes across
    for (std::size_t row = 0; row <= rows_; ++row) {
      for (std::size_t column = 0; column < columns_; column += part) {
        std::vector<Vec3> places;
        for (std::size_t i = 0; i <= part * each; ++i) {
          places.push_back(place(column * each + i, row * links_));
        }
        add(std::move(places), width_ / static_cast<double>(wide));
        for (std::size_t c = 0; c <= part; ++c) {
          joint(row, column + c).particles.push_back({world_.connectors.size() - 1, c * each});
        }
      }
    }
  }

  /// Spokes from the hub, and rings that go round.
  void web() {
    const Wave out = wave(rows_ * links_, slack_, number_or(net_, "pleats", 1));
    const std::size_t hub = world_.joints.size();
    world_.joints.emplace_back();
    const auto joint = [&](std::size_t ring, std::size_t spoke) {
      return hub + 1 + spoke * rows_ + ring - 1;
    };
    for (std::size_t spoke = 0; spoke < columns_; ++spoke) {
      const double angle = 2 * std::numbers::pi * double(spoke) / double(columns_);
      const Vec3 along =
          width_ / 2 * std::cos(angle) * across_ + height_ / 2 * std::sin(angle) * down_;
      std::vector<Vec3> places;
      for (std::size_t k = 0; k < out.along.size(); ++k) {
        places.push_back(origin_ + out.along[k] * along + along.norm() * out.aside[k] * normal_);
      }
      Connector& cord = add(std::move(places));
      world_.joints[hub].particles.push_back({first_ + spoke, 0});
      for (std::size_t ring = 1; ring <= rows_; ++ring) {
        world_.joints.push_back({{{first_ + spoke, ring * links_}}});
      }
      if (held_ == "edges") hold(cord, rows_ * links_);
    }
    for (std::size_t ring = 1; ring <= rows_; ++ring) {
      if (ring == rows_ && held_ == "edges") continue;  // what holds the rim needs none
      std::vector<Vec3> places;
      for (std::size_t spoke = 0; spoke <= columns_; ++spoke) {
        const Connector& cord = world_.connectors[first_ + spoke % columns_];
        places.push_back(cord.position[ring * links_]);
      }
      add(std::move(places));
      for (std::size_t spoke = 0; spoke <= columns_; ++spoke) {
        world_.joints[joint(ring, spoke % columns_)].particles.push_back(
            {world_.connectors.size() - 1, spoke});
      }
    }
    std::erase_if(world_.joints, [](const Joint& made) { return made.particles.size() < 2; });
  }

  /// Every metre of cord weighs the same; each link gives half to either end.
  void weigh() {
    double length = 0;
    for (std::size_t c = first_; c < world_.connectors.size(); ++c) {
      length += world_.connectors[c].length;
    }
    const double density =  // kg/m
        net_.find("material") ? mass_of(net_, 1) : net_.find("mass")->number / length;
    for (std::size_t c = first_; c < world_.connectors.size(); ++c) {
      Connector& cord = world_.connectors[c];
      cord.mass = density * cord.length;
      cord.particle_mass.assign(cord.particles(), 0.0);
      for (std::size_t k = 0; k < cord.links(); ++k) {
        cord.particle_mass[k] += density * cord.rest[k] / 2;
        cord.particle_mass[k + 1] += density * cord.rest[k] / 2;
      }
    }
  }

  const Document& document_;
  const Value& net_;
  World& world_;
  std::string kind_, held_;
  std::size_t columns_, rows_, links_;
  double slack_;
  std::size_t first_;  // of its connectors
  double width_ = 0, height_ = 0;
  Vec3 origin_, across_, down_, normal_;
};

}  // namespace

std::size_t cord_count(const Value& net) {
  const std::size_t columns = cell(net, 0), rows = cell(net, 1);
  const std::string& kind = net.find("kind")->text;
  if (kind == "web") return columns + rows - (net.find("held")->text == "edges" ? 1 : 0);
  return columns + 1 + (rows + 1) * (kind == "ladder" ? columns : 1);
}

void read_nets(const Document& document, World& world) {
  const Value* nets = document.root.find("nets");
  if (!nets) return;
  const Value* connectors = document.root.find("connectors");
  for (const Value& net : nets->children) {
    if (connectors && connectors->find(net.name)) {
      document.fail_at_key(net, "is the name of a connector already, expected another");
    }
    NetReader(document, net, world).read();
  }
}

}  // namespace taut::scenes
