#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <stdexcept>

#include "scenes/reader/common.h"
#include "scenes/reader/joints.h"
#include "scenes/reader/reader.h"
#include "scenes/scene/scene.h"
#include "sim/material/sections.h"
#include "sim/motion/rotation.h"
#include "sim/world/hanging.h"
#include "sim/world/places.h"

namespace taut::scenes {
namespace {

/// Of all connectors together; more would fill a machine's memory before anything is simulated.
constexpr std::size_t kMostInAll = 1000000;

/// One end of a connector as the file describes it.
struct End {
  const Value* value;
  std::optional<Attachment> to;  // none: nothing holds it
  double point_mass = 0;         // kg
  std::optional<Joint::Particle> joined = {};
  const Value* hanging = nullptr;  // `hangs` of the body that holds it and has no place yet

  /// True where it has a place, or will have.
  bool fixed() const { return (to && !hanging) || joined; }
};

class Layout {
 public:
  Layout(const Document& document, Motions& motions, World& world)
      : document_(document), motions_(motions), world_(world), routes_(document, motions, world) {
    const Value* bodies = document.root.find("bodies");
    for (std::size_t i = 0; i < world.bodies.size(); ++i) {
      unplaced_.push_back(bodies->children[i].find("hangs"));
    }
    waiting_.resize(world.bodies.size());
  }

  /// Lays connectors whose ends are known until none is left (one may hang from a body that another
  /// holds), in rounds, each in the order of the file.
  void run() {
    const Value* table = document_.root.find("connectors");
    if (table) {
      for (const Value& value : table->children) add(value);
      joined_.emplace(document_, table, world_);
      std::vector<bool>& laid = laid_;
      laid.resize(table->children.size());
      lines_ = lines_of(*table, world_, *joined_);
      lay_all(*table);
      if (std::ranges::find(laid, false) != laid.end() && !lines_.empty()) {
        lines_.clear();  // those that wait for each other are laid one by one
        lay_all(*table);
      }
      for (std::size_t i = 0; i < laid.size(); ++i) {
        if (!laid[i]) {
          document_.fail(table->children[i],
                         "neither end has a place at the start, expected one that has, or "
                         "start = { points = [...] }");
        }
      }
    }
    if (table) {
      for (std::size_t i = 0; i < table->children.size(); ++i)
        if (!routes_.passes(i)) check_digits(table->children[i], world_.connectors[i]);
      joined_->join(world_);
      for (std::size_t i = 0; i < table->children.size(); ++i) {
        repeat(table->children[i], i);
        routes_.add(i, world_);
      }
    }
    routes_.check_passed();
    for (const Value* hangs : unplaced_) {
      if (hangs) document_.fail(*hangs, "no connector holds the body, expected one to hang from");
    }
  }

 private:
  void lay_all(const Value& table) {
    std::set<std::pair<std::size_t, std::size_t>> next;  // round, connector
    for (std::size_t i = 0; i < laid_.size(); ++i) next.emplace(0, i);
    while (!next.empty()) {
      const auto [round, i] = *next.begin();
      next.erase(next.begin());
      placed_.clear();
      if (laid_[i]) continue;
      for (const std::size_t now : lay_with_neighbours(table, i)) {
        laid_[now] = true;
        for (const std::size_t waits : joined_->joined_to(now)) {
          if (!laid_[waits]) next.emplace(round + (waits < i), waits);
        }
      }
      for (const std::size_t body : placed_) {
        for (const std::size_t waits : waiting_[body]) next.emplace(round + (waits < i), waits);
      }
    }
  }

  /// Lays a connector, or the line that it is of. Returns all that have their shapes by it.
  std::vector<std::size_t> lay_with_neighbours(const Value& table, std::size_t index) {
    const auto line = std::ranges::find_if(lines_, [&](const Line& one) {
      return std::ranges::find(one, index, &InLine::connector) != one.end();
    });
    if (line != lines_.end() && outer(table, *line, false).fixed() &&
        outer(table, *line, true).fixed()) {
      return lay_line(table, *line);
    }
    if (!lay(table.children[index], world_.connectors[index])) return {};
    return {index};
  }

  /// Rigid links have their lengths, as far as the coordinates of their particles have digits.
  void check_digits(const Value& value, const Connector& connector) const {
    if (connector.model != ConnectorModel::links || connector.pulls || connector.stretches() ||
        connector.winch)
      return;
    constexpr double kNear = 1e-3;  // of a link
    for (std::size_t k = 0; k + 1 < connector.position.size(); ++k) {
      const double rest = connector.rest[k];
      const double length = (connector.position[k + 1] - connector.position[k]).norm();
      if (rest == 0 || std::abs(length - rest) <= kNear * rest) continue;
      document_.fail(value, fmt::format("a link of {:.3g} m at [{:.3g}] comes out {:.3g} m long, "
                                        "expected places whose digits hold its length",
                                        rest, fmt::join(connector.position[k], ", "), length));
    }
  }

  /// The first end of a line, or its last.
  End outer(const Value& table, const Line& line, bool last) {
    const InLine& one = last ? line.back() : line.front();
    const bool to = last != one.against;
    const std::size_t particle = to ? world_.connectors[one.connector].links() : 0;
    End end = read_end(*table.children[one.connector].find(to ? "to" : "from"));
    end.joined = joined_->target(one.connector, particle);
    return end;
  }

  std::vector<std::size_t> lay_line(const Value& table, const Line& line) {
    const End from = outer(table, line, false), to = outer(table, line, true);
    const auto first = place(from), last = place(to);
    if (!first || !last) return {};
    const Value& value = table.children[line.back().connector];
    const double length = length_of(line, world_), apart = (*last - *first).norm();
    if (apart > length + apart_by_rounding(length, largest(from, to))) {
      document_.fail(value, fmt::format("the ends of the line of {} connectors joined end to end "
                                        "are {:.6g} m apart, expected at most its length, {:.6g} m",
                                        line.size(), apart, length));
    }
    try {
      hang_line(world_, line, *first, *last);
    } catch (const std::invalid_argument& error) {
      document_.fail(value, fmt::format("{}, expected a start", error.what()));
    }
    std::vector<std::size_t> laid;
    for (const InLine& one : line) laid.push_back(one.connector);
    return laid;
  }

  void add(const Value& value) {
    const double length = value.find("length")->number;
    const double mass = mass_of(value, length);
    const auto particles = static_cast<std::size_t>(value.find("particles")->number);
    if (length == 0 && particles > 2) {
      document_.mismatch(*value.find("length"),
                         fmt::format("a number above 0 for {} particles (a joint of length 0 has "
                                     "2)",
                                     particles));
    }
    particles_ += particles * repeat_count(value) * span_count(value);
    if (particles_ > kMostInAll) {
      document_.mismatch(*value.find("particles"),
                         fmt::format("at most {} in all connectors together", kMostInAll));
    }
    Connector connector =
        straight_connector(value.name, length, mass, particles, Vec3::Zero(), Vec3::UnitY());
    if (text_or(value, "model", "links") == "span") connector.model = ConnectorModel::span;
    connector.pulls = text_or(value, "links", "rigid") == "pull";
    if (connector.pulls && connector.model == ConnectorModel::span) {
      document_.fail_at_key(*value.find("links"),
                            "needs model = \"links\", a massless span has none");
    }
    if (connector.pulls && length == 0) {
      document_.fail_at_key(*value.find("links"),
                            "needs links that have a length, a joint has none");
    }
    read_cord(document_, value, connector);
    if (value.find("over")) return add_route(value, std::move(connector));
    add_end(value, "from", 0, connector);
    add_end(value, "to", particles - 1, connector);
    const bool all_held = connector.holds.size() == particles;
    if (mass == 0 && connector.model == ConnectorModel::links && !all_held) {
      document_.mismatch(*value.find("mass"),
                         "a number above 0 (kg), unless model is span or both of 2 particles are "
                         "held");
    }
    read_winches(document_, value, world_, connector);
    world_.connectors.push_back(std::move(connector));
  }

  void add_route(const Value& value, Connector connector) {
    std::ranges::fill(connector.particle_mass, 0);  // once spans have their lengths
    Connector last = connector;
    add_end(value, "from", 0, connector);
    add_end(value, "to", connector.links(), last);
    routes_.divide(value, world_, world_.connectors.size(), connector, std::move(last));
    world_.connectors.push_back(std::move(connector));
  }

  /// Adds a connector's copies behind all that the file names.
  void repeat(const Value& value, std::size_t index) {
    const Value* list = value.find("repeat");
    if (!list) return;
    for (const char* key : {"from", "to"}) {
      const Value& end = *value.find(key);
      const Value* path = end.find("path");
      const bool circle = path && motions_.path_value(*path).find("circle");
      if (circle || end.find("body") || end.find("bone") || end.find("connector")) {
        document_.fail_at_key(*list, "needs ends that are free, fixed, or on a path of keys");
      }
    }
    const std::vector<Repeat> all = repeats(value);
    for (std::size_t k = 1; k < all.size(); ++k) {
      world_.connectors.push_back(repeated(world_.connectors[index], k, all[k]));
    }
  }

  End read_end(const Value& value) {
    End end{&value, {}};
    const Value* point = value.find("point");
    if (point && !value.find("body") && !value.find("path") && !value.find("bone")) {
      document_.fail_at_key(*point, "needs body, path or bone");
    }
    if (const Value* mass = value.find("point_mass")) {
      end.point_mass = mass->number;
    } else if (!value.find("free") && !value.find("connector")) {
      end.to = read_attachment(document_, value, "fixed", motions_);
      if (end.to->kind == Attachment::Kind::body) end.hanging = unplaced_[end.to->body];
    }
    return end;
  }

  void add_end(const Value& value, const char* key, std::size_t particle, Connector& connector) {
    const End end = read_end(*value.find(key));
    connector.particle_mass[particle] += end.point_mass;
    if (end.to) connector.holds.push_back({particle, *end.to});
    if (const Value* clamp = value.find(key)->find("clamp")) {
      if (!end.to) document_.fail_at_key(*clamp, "needs an end that is held");
      connector.holds.back().clamp = direction(document_, *clamp);
    }
    if (const Value* turn = value.find(key)->find("turn")) {
      connector.holds.back().turn = read_number_keys(document_, *turn, "angle");
    }
    if (end.hanging) waiting_[end.to->body].push_back(world_.connectors.size());
  }

  std::optional<Vec3> place(const End& end) const {
    if (end.joined && laid_[end.joined->connector]) {
      return world_.connectors[end.joined->connector].position[end.joined->particle];
    }
    if (!end.to || end.hanging) return {};
    return hold_motion(world_, *end.to, 0).position;
  }

  /// The largest coordinate (m) that the places of both ends come from.
  double largest(const End& a, const End& b) const {
    double most = 0;
    for (const End* end : {&a, &b}) {
      if (!end->to) continue;
      const Attachment& to = *end->to;
      most = std::max({most, to.point.cwiseAbs().maxCoeff(),
                       hold_motion(world_, to, 0).position.cwiseAbs().maxCoeff()});
      if (to.kind != Attachment::Kind::body) continue;
      most = std::max(most, world_.bodies[to.body].position.cwiseAbs().maxCoeff());
    }
    return most;
  }

  /// Gives the connector its shape, and what hangs from it its place. False while neither end is
  /// known.
  bool lay(const Value& value, Connector& connector) {
    const auto index = static_cast<std::size_t>(&connector - world_.connectors.data());
    End from = read_end(*value.find("from")), to = read_end(*value.find("to"));
    from.joined = joined_->target(index, 0);
    to.joined = joined_->target(index, connector.particles() - 1);
    const Value* start = value.find("start");
    const Value* points = start ? start->find("points") : nullptr;
    const Value* over = start ? start->find("over") : nullptr;
    const Value* circle = start ? start->find("circle") : nullptr;
    const Value* before = start ? start->find("before") : nullptr;
    if (before && !value.find("over")) document_.fail_at_key(*before, "needs over, with pulleys");
    const auto first = place(from), last = place(to);
    if (routes_.passes(index)) {
      routes_.lay(world_, index, connector, first, last);
      return finish(value, connector, from, first, routes_.last(index), to, last);
    }
    const bool loop = joined_->is_loop(index, connector.particles() - 1);
    if (loop && !points && !circle) {
      document_.fail(value, "is a closed loop, expected start = { circle = ... } or points");
    }
    if (points) {
      connector.position = on_points(*points, connector, to.fixed());
    } else if (over) {
      connector.position = on_obstacle(*over, connector);
    } else if (circle) {
      if (!loop) {
        document_.fail_at_key(*circle,
                              "needs an end that is joined to the connector's first "
                              "particle, at = 0 of itself");
      }
      connector.position = polygon(direction(document_, *circle->find("axis")),
                                   circle->find("centre")->vec3(), connector, first);
    } else if ((from.joined && !first) || (to.joined && !last && !start)) {
      return false;  // what it is joined to has no place yet
    } else if (first) {
      connector.position = shape(value, connector, *first, last, largest(from, to));
    } else if (last) {
      connector.position = shape(value, connector, *last, first, largest(from, to));
      std::ranges::reverse(connector.position);
    } else {
      return false;
    }
    return finish(value, connector, from, first, connector, to, last);
  }

  /// Lets a connector that has its shape turn, and brings together its ends and what holds them.
  bool finish(const Value& value, Connector& connector, const End& from,
              const std::optional<Vec3>& first, Connector& behind, const End& to,
              const std::optional<Vec3>& last) {
    const Value* start = value.find("start");
    const Value* circle = start ? start->find("circle") : nullptr;
    if (const Value* spin = start ? start->find("spin") : nullptr) {
      if (to.to || (to.joined && !circle)) {
        document_.fail_at_key(*spin, "needs a last particle that nothing holds");
      }
      const Vec3 about = circle ? circle->find("centre")->vec3() : behind.position.front();
      for (std::size_t i = 0; i < behind.particles(); ++i) {
        behind.velocity[i] = spin->vec3().cross(behind.position[i] - about);
      }
    }
    meet(value, connector, from, first, connector.position.front());
    meet(value, connector, to, last, behind.position.back());
    return true;
  }

  /// `held`: something has its last particle.
  std::vector<Vec3> on_points(const Value& points, const Connector& connector, bool held) const {
    std::vector<Vec3> corners;
    for (const Value& corner : points.children) corners.push_back(corner.vec3());
    return on_line(points, corners, connector, held);
  }

  std::vector<Vec3> on_obstacle(const Value& over, const Connector& connector) const {
    const Value& name = *over.find("obstacle");
    const Value* table = document_.root.find("obstacles");
    const Names names(table);
    const std::size_t named = names.index_of(document_, name, "round obstacle");
    const Value& value = table->children[named];
    const Obstacle around = read_obstacle(document_, value, motions_, world_);
    const bool round =
        around.shape.kind == Shape::Kind::cylinder || around.shape.kind == Shape::Kind::capsule;
    if (!round || around.path) {
      document_.mismatch(name, "a cylinder or capsule that stands still");
    }
    const Winding winding{number_or(over, "turns", 0.5), over.find("before")->number,
                          connector.length};
    const double wound =
        winding.turns * 2 * std::numbers::pi * (around.shape.radius + connector.radius);
    if (winding.before + wound > connector.length) {
      document_.fail(over, fmt::format("takes {:.6g} m, expected at most the length, {} m",
                                       winding.before + wound, connector.length));
    }
    return on_line(over, wound_line(around, connector.radius, world_.gravity, winding), connector,
                   false);
  }

  /// Strings are laid evenly along a line that is shorter than they are. What stretches is laid
  /// evenly along a longer one if it is held at its end: it starts under tension.
  std::vector<Vec3> on_line(const Value& said, const std::vector<Vec3>& corners,
                            const Connector& connector, bool held) const {
    double way = 0;
    for (std::size_t i = 1; i < corners.size(); ++i) way += (corners[i] - corners[i - 1]).norm();
    const bool tense = connector.stretches() && held && way > (1 + kRounding) * connector.length;
    if (tense || (connector.pulls && way < connector.length)) {
      return evenly_along(corners, connector.particles());
    }
    auto line = along_line(corners, connector.particles(), connector.rest.front());
    if (line.size() < connector.particles()) {
      document_.fail(said, fmt::format("the line has room for {} of {} links of {} m",
                                       line.size() - 1, connector.links(), connector.rest.front()));
    }
    return line;
  }

  /// The shape that starts at `origin`, which is a known end's place; `far` is the other's. No
  /// coordinate that both come from is beyond `largest` (m).
  std::vector<Vec3> shape(const Value& value, const Connector& connector, const Vec3& origin,
                          const std::optional<Vec3>& far, double largest) const {
    const Value* start = value.find("start");
    if (const Value* along = start ? start->find("direction") : nullptr) {
      return straight(connector, origin, direction(document_, *along));
    }
    const Value* hanging = start ? start->find("hanging_to") : nullptr;
    if (!hanging && !far) {
      const Vec3& g = world_.gravity;
      return straight(connector, origin, g.isZero() ? Vec3(-Vec3::UnitY()) : Vec3(g.normalized()));
    }
    const Vec3 end = hanging ? hanging->vec3() : *far;
    const double apart = (end - origin).norm();
    const double rounding = apart_by_rounding(connector.length, largest);
    if (apart > connector.length + rounding && connector.stretches() && !hanging) {
      return evenly_along({origin, end}, connector.particles());
    }
    if (apart > connector.length + rounding) {
      document_.fail(hanging ? *hanging : value,
                     fmt::format("the ends are {:.6g} m apart, expected at most the length, {} m",
                                 apart, connector.length));
    }
    if (connector.model == ConnectorModel::links && connector.links() == 1 && !connector.pulls &&
        apart < connector.length - rounding) {
      document_.fail(hanging ? *hanging : value,
                     fmt::format("the ends are {:.6g} m apart, expected the length of the only "
                                 "link, {} m",
                                 apart, connector.length));
    }
    try {
      return hanging_points(connector, origin, end, world_.gravity);
    } catch (const std::invalid_argument& error) {
      document_.fail(hanging ? *hanging : value,
                     fmt::format("{}, expected another start", error.what()));
    }
  }

  static std::vector<Vec3> straight(const Connector& connector, const Vec3& origin,
                                    const Vec3& unit) {
    return straight_connector("", connector.length, connector.mass, connector.particles(), origin,
                              unit)
        .position;
  }

  /// Brings together an end and the particle it holds: the body that hangs comes to the particle;
  /// any other end must be there.
  void meet(const Value& value, const Connector& connector, const End& end,
            const std::optional<Vec3>& known, const Vec3& particle) {
    if (!end.to) return;
    if (end.hanging) {
      // Both ends may be the same body: the first has placed it.
      if (unplaced_[end.to->body]) return hang(*end.to, *end.hanging, particle);
    }
    const Vec3 at = known ? *known : hold_motion(world_, *end.to, 0).position;
    const double apart = (at - particle).norm();
    if (apart > apart_by_rounding(connector.length, largest(end, end))) {
      document_.fail(*end.value,
                     fmt::format("holds a point that is {:.6g} m away from where {} ends at the "
                                 "start, expected its place",
                                 apart, value.path));
    }
  }

  void hang(const Attachment& to, const Value& hangs, const Vec3& particle) {
    Body& body = world_.bodies[to.body];
    const Vec3 lever = body.mass_properties.centre - to.point;
    if (lever.isZero()) {
      document_.fail(hangs, "the body is held at its centre of mass, expected a position instead");
    }
    const Vec3 down = direction(document_, hangs);
    body.rotation = rotation_between(lever, down);
    body.position = particle + lever.norm() * down;
    unplaced_[to.body] = nullptr;
    placed_.push_back(to.body);
  }

  const Document& document_;
  Motions& motions_;
  World& world_;
  Routes routes_;
  std::optional<JoinedEnds> joined_;
  std::vector<Line> lines_;
  std::vector<bool> laid_;              // [connector] it has its shape
  std::size_t particles_ = 0;           // of all connectors so far
  std::vector<const Value*> unplaced_;  // [body] its `hangs` while it has no place
  std::vector<std::vector<std::size_t>>
      waiting_;                      // [body] connectors that hold one without a place
  std::vector<std::size_t> placed_;  // bodies that the connector at hand has placed
};

}  // namespace

void read_connectors(const Document& document, Motions& motions, World& world) {
  Layout(document, motions, world).run();
}

namespace {

/// Where the straight piece from a to b, taken from the share `u` on, leaves the ball of radius
/// `r` about `centre`, as a share of the piece; above 1 when it stays inside.
double exit_share(const Vec3& a, const Vec3& b, const Vec3& centre, double r) {
  // |a + u (b - a) - centre|^2 = r^2; of the two zeros the larger is the way out.
  const Vec3 piece = b - a, from = a - centre;
  const double p = piece.dot(from), q = piece.squaredNorm();
  if (q == 0) return 2;
  return (-p + std::sqrt(std::max(0.0, p * p - q * (from.squaredNorm() - r * r)))) / q;
}

}  // namespace

std::vector<Vec3> evenly_along(const std::vector<Vec3>& corners, std::size_t particles) {
  std::vector<double> until{0};  // m, of the corners
  for (std::size_t i = 1; i < corners.size(); ++i) {
    until.push_back(until.back() + (corners[i] - corners[i - 1]).norm());
  }
  std::vector<Vec3> line;
  std::size_t piece = 0;
  for (std::size_t i = 0; i < particles; ++i) {
    const double along = until.back() * static_cast<double>(i) / static_cast<double>(particles - 1);
    while (piece + 2 < corners.size() && until[piece + 1] < along) ++piece;
    const double length = until[piece + 1] - until[piece];
    const double share = length > 0 ? std::min(1.0, (along - until[piece]) / length) : 0;
    line.push_back(corners[piece] + share * (corners[piece + 1] - corners[piece]));
  }
  return line;
}

std::vector<Vec3> along_line(const std::vector<Vec3>& corners, std::size_t particles, double link) {
  // The last link may miss its length by the rounding of the numbers in the file; one that ends at
  // a corner by the rounding of the sums, or it would end beyond it by the root of that.
  constexpr double rounding_in_file = 1e-6, rounding_of_sums = 1e-9;
  std::vector<Vec3> line{corners.front()};
  std::size_t piece = 0;
  while (line.size() < particles) {
    const Vec3 last = line.back();
    for (;; ++piece) {
      const double share = exit_share(corners[piece], corners[piece + 1], last, link);
      const bool ends = piece + 2 == corners.size();
      const double missing = (share - 1) * (corners[piece + 1] - corners[piece]).norm();
      const double rounding = ends ? rounding_in_file : rounding_of_sums;
      if (share <= 1 || (share < 2 && missing <= rounding * link)) {
        line.push_back(corners[piece] + share * (corners[piece + 1] - corners[piece]));
        break;
      }
      if (ends) return line;
    }
  }
  return line;
}

std::vector<Vec3> polygon(const Vec3& axis, const Vec3& centre, const Connector& connector,
                          const std::optional<Vec3>& first) {
  const double corners = static_cast<double>(connector.links());
  const double radius = connector.rest.front() / (2 * std::sin(std::numbers::pi / corners));
  const Vec3 towards = first ? Vec3(*first - centre) : axis.unitOrthogonal();
  const Vec3 x = (towards - axis.dot(towards) * axis).stableNormalized(), y = axis.cross(x);
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < connector.links(); ++i) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(i) / corners;
    places.push_back(centre + radius * (std::cos(turn) * x + std::sin(turn) * y));
  }
  places.push_back(places.front());
  return places;
}

namespace {

constexpr int kCorners = 720;         // of a turn, as a polygon around the circle
constexpr double kTurnsApart = 1.05;  // of the rope's thickness, from one turn to the next

}  // namespace

std::vector<Vec3> wound_line(const Obstacle& around, double radius, const Vec3& gravity,
                             const Winding& winding) {
  const Pose frame = around.frame(0).pose();
  const Vec3 axis = frame.rotation * Vec3::UnitY();
  Vec3 down = gravity - axis.dot(gravity) * axis;
  if (down.norm() < 1e-9 * gravity.norm() || gravity.isZero())
    down = frame.rotation * -Vec3::UnitX();
  down.normalize();
  // Right-handed about the axis; rope that comes up from below is on the side of axis x down.
  const Vec3 side = axis.cross(down);
  const double step = 2 * std::numbers::pi / kCorners;
  const double circle = (around.shape.radius + radius) / std::cos(step / 2);
  const double rise = winding.turns > 1 ? kTurnsApart * 2 * radius * winding.turns : 0;
  const int steps = std::max(1, static_cast<int>(std::lround(winding.turns * kCorners)));
  std::vector<Vec3> corners;
  for (int i = 0; i < steps; ++i) {
    const double angle = (i + 0.5) * step, share = static_cast<double>(i) / steps;
    corners.push_back(frame.position + (share - 0.5) * rise * axis +
                      circle * (std::cos(angle) * side - std::sin(angle) * down));
  }
  // Straight on, along the tangents.
  const double last = steps * step;
  corners.insert(corners.begin(), corners.front() + winding.before * down);
  corners.push_back(corners.back() -
                    winding.after * (std::sin(last) * side + std::cos(last) * down));
  return corners;
}

// Connectors that start outside of obstacles because their scene asks for it.

namespace {

constexpr int kSweeps = 10000;
constexpr double kBeyond = 1e-3;  // of a link: how far past the surface a bead is moved
constexpr double kMost = 0.25;    // of a link: how far at once, so that its neighbours can follow
constexpr double kNotStretched = 1e-9;  // of a link

/// The connector whose shape at the start this is, or one of its copies.
bool is_of(const Connector& connector, const Value& value) {
  return written_name(connector.name) == value.name;
}

bool keeps_lengths(const Connector& connector) {
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const double length = (connector.position[k + 1] - connector.position[k]).norm();
    const double longer = length / connector.rest[k] - 1;
    if (connector.pulls ? longer > kNotStretched : std::abs(longer) > kNotStretched) return false;
  }
  return true;
}

/// Moves beads that are inside of an obstacle out of it, along the unit vector `out`. Whether there
/// were any.
bool move_beads(const std::vector<Obstacle>& obstacles, const Vec3& out, Connector& connector) {
  const double link = connector.rest.front();
  bool found = false;
  for (const Obstacle& obstacle : obstacles) {
    if (!obstacle.touches(connector.category)) continue;
    const Pose frame = obstacle.frame(0).pose();
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (holds(connector, i)) continue;
      const double apart = gap(obstacle, frame, connector.position[i], connector.radius).distance;
      if (apart >= 0) continue;
      // No way out is shorter than that to the surface nearby.
      connector.position[i] += std::min(kBeyond * link - apart, kMost * link) * out;
      found = true;
    }
  }
  return found;
}

}  // namespace

void push_out_starts(const Document& document, World& world) {
  const Value* table = document.root.find("connectors");
  for (std::size_t c = 0; table && c < table->children.size(); ++c) {
    const Value& value = table->children[c];
    const Value* start = value.find("start");
    const Value* asked = start ? start->find("push_out") : nullptr;
    if (!asked) continue;
    const Vec3 out = direction(document, *asked);
    for (const char* key : {"from", "to"}) {
      const Value& end = *value.find(key);
      if (!end.find("free") && !end.find("point_mass") && !end.find("fixed") && !end.find("path") &&
          !end.find("bone")) {
        document.fail_at_key(*asked, "needs ends that are free, fixed, on a path or on a bone");
      }
    }
    LinkRestorer restorer;
    for (Connector& connector : world.connectors) {
      if (!is_of(connector, value)) continue;
      int sweeps = 0;
      while (move_beads(world.obstacles, out, connector)) {
        restorer.restore(connector, 0);
        if (++sweeps < kSweeps && keeps_lengths(connector)) continue;
        document.fail_at_key(*asked,
                             "found no place for it outside of the obstacles, expected another "
                             "start");
      }
    }
  }
}

namespace {

constexpr double kAirDensity = 1.225;  // kg/m^3, at sea level and 15 degrees

material::RoundRod rod_of(const Value& material) {
  material::RoundRod rod{.youngs_modulus = material.find("youngs_modulus")->number,
                         .diameter = material.find("diameter")->number,
                         .density = material.find("density")->number};
  rod.poissons_ratio = number_or(material, "poissons_ratio", rod.poissons_ratio);
  return rod;
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
  return material ? rod_of(*material).mass(length) : connector.find("mass")->number;
}

void read_cord(const Document& document, const Value& value, Connector& connector) {
  connector.restitution = number_or(value, "restitution", 0);
  connector.radius =
      number_or(value, "radius", number_or(value, "diameter", ConnectorLook().diameter) / 2);
  connector.links_touch = text_or(value, "contact", "beads") == "links";
  if (const Value* limit = value.find("breaks_at")) {
    const auto has_winch = [&](const char* end) {
      return value.find(end) && value.find(end)->find("winch");
    };
    if (value.find("over") || has_winch("from") || has_winch("to")) {
      document.fail_at_key(*limit, "needs a connector without winch and pulley: those are not cut");
    }
    connector.breaks_at = limit->number;
  }
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
  if (is_loop(value)) weigh_by_links(connector);
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
  const Value* material = value.find("material");
  if (material) section = rod_of(*material).section(section);
  std::vector<double> diameters;
  if (taper) {
    for (const Value& share : taper->children) diameters.push_back(share.number);
  }
  material::give_sections(connector, section, diameters);
  if (taper || material) material::weigh_by_links(connector, diameters);
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
