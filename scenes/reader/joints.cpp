#include "scenes/reader/joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "scenes/reader/common.h"
#include "scenes/reader/motions.h"
#include "sim/world/hanging.h"
#include "sim/world/winched.h"

namespace taut::scenes {
namespace {

/// Particles that are one, found together in nearly linear time.
class Groups {
 public:
  void unite(const Joint::Particle& a, const Joint::Particle& b) {
    const std::size_t first = find(node(a)), second = find(node(b));
    parent_[std::max(first, second)] = std::min(first, second);
  }

  /// In the order in which their first particles were named.
  std::vector<Joint> joints() {
    std::vector<Joint> all;
    std::vector<std::size_t> index(parent_.size());
    for (std::size_t n = 0; n < parent_.size(); ++n) {
      const std::size_t root = find(n);
      if (root == n) {
        index[n] = all.size();
        all.emplace_back();
      }
      all[index[root]].particles.push_back(particles_[n]);
    }
    return all;
  }

 private:
  std::size_t node(const Joint::Particle& at) {
    const auto [found, added] = number_.try_emplace({at.connector, at.particle}, particles_.size());
    if (added) {
      parent_.push_back(particles_.size());
      particles_.push_back(at);
    }
    return found->second;
  }
  std::size_t find(std::size_t node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }

  std::map<std::pair<std::size_t, std::size_t>, std::size_t> number_;
  std::vector<Joint::Particle> particles_;
  std::vector<std::size_t> parent_;
};

}  // namespace

JoinedEnds::JoinedEnds(const Document& document, const Value* connectors, const World& world)
    : document_(document), joined_to_(world.connectors.size()) {
  const Names names(connectors);
  for (std::size_t c = 0; connectors && c < connectors->children.size(); ++c) {
    const Value& connector = connectors->children[c];
    read(names, world, *connector.find("from"), {c, 0});
    read(names, world, *connector.find("to"), {c, world.connectors[c].particles() - 1});
  }
}

void JoinedEnds::read(const Names& names, const World& world, const Value& end,
                      Joint::Particle own) {
  const Value *name = end.find("connector"), *at = end.find("at");
  if (at && !name) document_.fail_at_key(*at, "needs connector");
  if (!name) return;
  if (!at) document_.fail_at_key(*name, "needs at, the place along the connector");
  const std::size_t other = names.index_of(document_, *name, "connector");
  for (const std::size_t c : {own.connector, other}) {
    if (world.connectors[c].model == ConnectorModel::span) {
      document_.fail_at_key(
          *name, fmt::format("{} is a massless span, expected model = \"links\" of what is joined",
                             world.connectors[c].name));
    }
  }
  const Connector& connector = world.connectors[other];
  if (at->number > connector.length) {
    document_.mismatch(
        *at, fmt::format("at most the length of {}, {} m", connector.name, connector.length));
  }
  const double link = connector.rest.front();
  const double nearest = link > 0 ? std::round(at->number / link) : 0;
  if (std::abs(at->number - nearest * link) > kRounding * connector.length) {
    document_.mismatch(*at, fmt::format("the place of a particle of {}, such as {:.6g} m",
                                        connector.name, nearest * link));
  }
  const Joint::Particle target{other, static_cast<std::size_t>(nearest)};
  const auto [low, high] = std::minmax(own.particle, target.particle);
  if (other == own.connector && high - low < 3) {
    document_.fail_at_key(*name, fmt::format("joins the connector to itself with {} links between, "
                                             "expected at least 3",
                                             high - low));
  }
  joined_to_[other].push_back(own.connector);
  index_.emplace(std::pair(own.connector, own.particle), ends_.size());
  ends_.push_back({&end, own, target});
}

std::optional<Joint::Particle> JoinedEnds::target(std::size_t connector,
                                                  std::size_t particle) const {
  const auto found = index_.find({connector, particle});
  if (found == index_.end()) return std::nullopt;
  return ends_[found->second].other;
}

bool JoinedEnds::is_loop(std::size_t connector, std::size_t last) const {
  const auto to = target(connector, last);
  return to && to->connector == connector && to->particle == 0;
}

void JoinedEnds::join(World& world) const {
  if (ends_.empty()) return;
  Groups groups;
  for (const End& end : ends_) {
    const Connector &own = world.connectors[end.own.connector],
                    &other = world.connectors[end.other.connector];
    const double apart =
        (own.position[end.own.particle] - other.position[end.other.particle]).norm();
    const double largest = other.position[end.other.particle].cwiseAbs().maxCoeff();
    if (apart > apart_by_rounding(std::max(own.length, other.length), largest)) {
      document_.fail(*end.value,
                     fmt::format("is {:.6g} m away from its place on {} at the start, expected it "
                                 "to begin there",
                                 apart, other.name));
    }
    groups.unite(end.other, end.own);
  }
  world.joints = groups.joints();
  const std::string flaw = joint_flaw(world);
  if (!flaw.empty()) document_.fail(*ends_.back().value, flaw + ", expected other places");
}

namespace {

constexpr std::size_t kMostPulleys = 1000;  // they are eliminated together, in cubic time
constexpr double kApart = 1e-9;             // of its length: what is nearer is one place
constexpr double kTaut = 1e-4;  // of its length: a rope that starts taut may be off by so much

const Value* in_start(const Value& rope, const char* key) {
  const Value* start = rope.find("start");
  return start ? start->find(key) : nullptr;
}

/// The key of a connector that does not go with pulleys; null: none.
const Value* unfit_for_pulleys(const Value& rope) {
  for (const char* key : {"points", "hanging_to", "over", "circle"}) {
    if (const Value* found = in_start(rope, key)) return found;
  }
  for (const char* key : {"taper", "repeat"}) {
    if (const Value* found = rope.find(key)) return found;
  }
  const Value* model = rope.find("model");
  if (model && model->text == "span") return model;
  for (const char* end : {"from", "to"}) {
    if (const Value* found = rope.find(end)->find("connector")) return found;
  }
  const Value* look = rope.find("look");
  return look && look->text == "chain" ? look : nullptr;
}

/// Gives a span its length, and its mass in halves of its links.
void give_length(Connector& span, double length, double density) {
  span.length = length;
  span.mass = density * length;
  const double link = length / static_cast<double>(span.links());
  span.rest.assign(span.links(), link);
  for (std::size_t k = 0; k < span.links(); ++k) {
    span.particle_mass[k] += density * link / 2;
    span.particle_mass[k + 1] += density * link / 2;
  }
}

/// The negated path: the span before a pulley takes in the length that the pulley passes on.
std::shared_ptr<const Path> backwards(const std::shared_ptr<const Path>& path) {
  if (!path) return nullptr;
  std::vector<PathKey> keys = path->keys();
  for (PathKey& key : keys) {
    key.position = -key.position;
    key.velocity = -key.velocity;
  }
  return std::make_shared<const Path>(std::move(keys));
}

std::vector<Vec3> straight(const Connector& span, const Vec3& from, const Vec3& towards) {
  return straight_connector("", span.length, 0, span.particles(), from, towards).position;
}

}  // namespace

std::size_t span_count(const Value& connector) {
  const Value* over = connector.find("over");
  return over ? over->children.size() + 1 : 1;
}

Routes::Routes(const Document& document, Motions& motions, const World& world)
    : document_(document), names_(document.root.find("pulleys")) {
  const Value* table = document.root.find("pulleys");
  if (!table) return;
  if (table->children.size() > kMostPulleys) {
    document.fail(*table, fmt::format("has {} pulleys, expected at most {}", table->children.size(),
                                      kMostPulleys));
  }
  for (const Value& value : table->children) {
    eyes_.push_back({&value, read_attachment(document, value, "fixed", motions)});
    const Attachment& to = eyes_.back().to;
    const Value* passed = value.find("passed");
    if (passed) eyes_.back().driven = read_length_keys(document, *passed, "passed");
    const Value* body = value.find("body");
    if (!body || is_prescribed(world, to)) continue;
    if (passed) document.fail_at_key(*passed, "needs a place that is fixed or driven");
    if (!document.root.find("bodies")->children[to.body].find("position")) {
      document.fail_at_key(*body, "is of a body that hangs, expected one with a position");
    }
  }
}

void Routes::divide(const Value& value, const World& world, std::size_t index, Connector& first,
                    Connector last) {
  const Value* over = value.find("over");
  if (const Value* found = unfit_for_pulleys(value)) {
    document_.fail_at_key(*found, fmt::format("does not go with {}, which divides the rope at "
                                              "pulleys",
                                              over->path));
  }
  Rope rope;
  rope.value = &value;
  for (const Value& name : over->children) {
    const std::size_t eye = names_.index_of(document_, name, "pulley");
    if (const Value* before = std::exchange(eyes_[eye].passed, &name)) {
      document_.fail(name, fmt::format("names the pulley {}, which {} passes already", name.text,
                                       before->path));
    }
    rope.eyes.push_back(eye);
  }
  rope.winches = read_winches(document_, value, world, first, last);
  rope.density = first.mass / first.length;
  const bool free_end = first.holds.empty() && first.particle_mass.front() == 0;
  const bool free_last = last.holds.empty() && last.particle_mass.back() == 0;
  if (first.mass == 0 && (first.particles() > 2 || free_end || free_last)) {
    document_.mismatch(*value.find("mass"),
                       "a number above 0 (kg), unless a span has 2 particles and both of the "
                       "rope's ends are held or have a point_mass");
  }
  Connector middle = first;
  middle.holds.clear();
  std::ranges::fill(middle.particle_mass, 0);
  const std::size_t end = first.links();
  first.holds.push_back({end, eyes_[rope.eyes.front()].to});
  last.holds.insert(last.holds.begin(), {0, eyes_[rope.eyes.back()].to});
  for (std::size_t i = 1; i < rope.eyes.size(); ++i) {
    Connector span = middle;
    span.holds = {{0, eyes_[rope.eyes[i - 1]].to}, {end, eyes_[rope.eyes[i]].to}};
    rope.behind.push_back(std::move(span));
  }
  rope.behind.push_back(std::move(last));
  for (std::size_t i = 0; i < rope.behind.size(); ++i) {
    rope.behind[i].name = fmt::format("{}#{}", first.name, i + 2);
  }
  ropes_.emplace(index, std::move(rope));
}

std::vector<Vec3> Routes::between(const Rope& rope, const Connector& span, const Vec3& from,
                                  const Vec3& to, const World& world) const {
  const double apart = (to - from).norm();
  if (apart >= span.length * (1 - kApart)) return straight(span, from, to - from);
  if (span.links() == 1) {
    document_.fail(*rope.value,
                   fmt::format("a span of one link is {:.6g} m long between places that are {:.6g} "
                               "m apart, expected as long",
                               span.length, apart));
  }
  try {
    return hanging_points(span, from, to, world.gravity);
  } catch (const std::invalid_argument& error) {
    document_.fail(*rope.value, fmt::format("{}, expected another start", error.what()));
  }
}

void Routes::lay(const World& world, std::size_t index, Connector& first, std::optional<Vec3> from,
                 std::optional<Vec3> to) {
  Rope& rope = ropes_.at(index);
  std::vector<Vec3> places;
  for (const std::size_t eye : rope.eyes) {
    places.push_back(hold_motion(world, eyes_[eye].to, 0).position);
  }
  const double whole = rope.value->find("length")->number;
  double left = whole;
  for (std::size_t i = 1; i < places.size(); ++i) {
    const double length = (places[i] - places[i - 1]).norm();
    if (length < kApart * whole) {
      document_.fail(*eyes_[rope.eyes[i]].passed, "is where the pulley before it is");
    }
    give_length(rope.behind[i - 1], length, rope.density);
    rope.behind[i - 1].position =
        straight(rope.behind[i - 1], places[i - 1], places[i] - places[i - 1]);
    left -= length;
  }
  const Value* before = in_start(*rope.value, "before");
  if (!before && !from) {
    document_.fail(*rope.value,
                   "needs start.before, the length up to the first pulley, as its first end has no "
                   "place yet");
  }
  const double nearest = from ? (*from - places.front()).norm() : 0;
  const double length = before ? before->number : nearest;
  if (length < nearest * (1 - kApart) || length == 0) {
    document_.fail(before ? *before : *rope.value,
                   fmt::format("leaves {:.6g} m up to the first pulley, which is {:.6g} m away",
                               length, nearest));
  }
  left -= length;
  const double last = to ? (*to - places.back()).norm() : 0;
  if (to && std::abs(left - last) < kTaut * whole) left = last;
  if (left <= kApart * whole || left < last) {
    document_.mismatch(*rope.value->find("length"),
                       fmt::format("at least {:.9g} m, up to the last end", whole - left + last));
  }
  const Vec3 down = world.gravity.isZero() ? Vec3(-Vec3::UnitY()) : world.gravity.normalized();
  give_length(first, length, rope.density);
  if (from) {
    first.position = between(rope, first, *from, places.front(), world);
  } else {
    first.position = straight(first, places.front(), down);
    std::ranges::reverse(first.position);
  }
  Connector& end = rope.behind.back();
  give_length(end, left, rope.density);
  if (to) {
    end.position = between(rope, end, places.back(), *to, world);
  } else {
    const Value* along = in_start(*rope.value, "direction");
    end.position = straight(end, places.back(), along ? direction(document_, *along) : down);
  }
}

/// Whether a span has links that change: that at a free body keeps its length.
void Routes::check(const World& world, const Rope& rope, const Connector& span) const {
  std::size_t keep = 0;
  for (const Hold& hold : span.holds) keep += is_prescribed(world, hold.to) ? 0 : 1;
  if (rope.density == 0 || span.links() > keep) return;
  document_.mismatch(
      *rope.value->find("particles"),
      fmt::format("at least {}, as the link at a free body keeps its length", keep + 2));
}

void Routes::add(std::size_t index, World& world) {
  const auto found = ropes_.find(index);
  if (found == ropes_.end()) return;
  Rope& rope = found->second;
  std::vector<std::size_t> spans{index};
  for (Connector& span : rope.behind) {
    spans.push_back(world.connectors.size());
    world.connectors.push_back(std::move(span));
  }
  const auto eye = [&](std::size_t i) -> const Eye& { return eyes_[rope.eyes[i]]; };
  for (std::size_t i = 0; i < spans.size(); ++i) {
    Connector& span = world.connectors[spans[i]];
    check(world, rope, span);
    const bool first = i == 0, last = i + 1 == spans.size();
    const auto before = first ? rope.winches[0] : eye(i - 1).driven;
    const auto behind = last ? rope.winches[1] : backwards(eye(i).driven);
    add_winches(world, span, before, behind, rope.density);
    const bool known = (first || before) && (last || behind);
    if (known && (before || behind)) {
      check_least(document_, *rope.value->find("over"), *span.winch);
    }
  }
  for (std::size_t i = 0; i < rope.eyes.size(); ++i) {
    if (eye(i).driven) continue;
    const Value& value = *eye(i).value;
    add_pulley(world, value.name, spans[i], spans[i + 1], number_or(value, "inertia", 0));
    Pulley& pulley = world.pulleys.back();
    pulley.friction = number_or(value, "friction", 0);
    pulley.bearing = number_or(value, "bearing", 0);
    if (pulley.has_friction() && rope.density > 0 && !is_prescribed(world, eye(i).to)) {
      document_.fail_at_key(*value.find(pulley.friction > 0 ? "friction" : "bearing"),
                            "needs a rope without mass on a free body");
    }
  }
}

void Routes::check_passed() const {
  for (const Eye& eye : eyes_) {
    if (!eye.passed) document_.fail(*eye.value, "no rope passes it, expected one over it");
  }
}

namespace {

/// A connector's first end, or its last.
struct LineEnd {
  std::size_t connector = 0;
  bool last = false;
  auto operator<=>(const LineEnd&) const = default;
};

/// The ends of connectors that meet one other end there, and nothing else.
class Meetings {
 public:
  Meetings(const Value& connectors, const World& world, const JoinedEnds& joined)
      : other_(connectors.children.size()) {
    std::vector<std::pair<LineEnd, LineEnd>> pairs;
    std::multiset<LineEnd> met;
    for (std::size_t c = 0; c < connectors.children.size(); ++c) {
      for (const bool last : {false, true}) {
        const auto target = joined.target(c, last ? world.connectors[c].links() : 0);
        if (!target) continue;
        const std::size_t end = world.connectors[target->connector].links();
        if (target->particle != 0 && target->particle != end) continue;
        const LineEnd own{c, last}, other{target->connector, target->particle == end};
        met.insert(own);
        met.insert(other);
        pairs.emplace_back(own, other);
      }
    }
    const auto hangs = [&](const LineEnd& end) {
      const Value& value = connectors.children[end.connector];
      const Connector& connector = world.connectors[end.connector];
      return !value.find("start") && !value.find("over") && !value.find("repeat") &&
             !connector.winch && connector.length > 0 && met.count(end) == 1;
    };
    const auto is_held = [&](const LineEnd& end) {
      const Connector& connector = world.connectors[end.connector];
      const std::size_t particle = end.last ? connector.links() : 0;
      return std::ranges::find(connector.holds, particle, &Hold::particle) != connector.holds.end();
    };
    for (const auto& [a, b] : pairs) {
      if (a.connector == b.connector || !hangs(a) || !hangs(b) || is_held(b)) continue;
      at(a) = b;
      at(b) = a;
    }
  }

  const std::optional<LineEnd>& other(const LineEnd& end) const {
    return other_[end.connector][end.last];
  }

 private:
  std::optional<LineEnd>& at(const LineEnd& end) { return other_[end.connector][end.last]; }

  std::vector<std::array<std::optional<LineEnd>, 2>> other_;
};

}  // namespace

std::vector<Line> lines_of(const Value& connectors, const World& world, const JoinedEnds& joined) {
  const Meetings meetings(connectors, world, joined);
  std::vector<Line> lines;
  std::vector<bool> taken(connectors.children.size());
  for (std::size_t c = 0; c < taken.size(); ++c) {
    for (const bool last : {false, true}) {
      LineEnd in{c, last};  // by which the line comes into a connector
      if (taken[c] || meetings.other(in) || !meetings.other({c, !last})) continue;
      Line line;
      for (;;) {
        taken[in.connector] = true;
        line.push_back({in.connector, in.last});
        const auto& next = meetings.other({in.connector, !in.last});
        if (!next) break;
        in = *next;
      }
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

double length_of(const Line& line, const World& world) {
  double length = 0;
  for (const InLine& one : line) length += world.connectors[one.connector].length;
  return length;
}

void hang_line(World& world, const Line& line, const Vec3& from, const Vec3& to) {
  std::vector<double> rest, mass{0.0};
  double whole = 0;
  for (const InLine& one : line) {
    const Connector& connector = world.connectors[one.connector];
    std::vector<double> own = connector.rest, masses = connector.particle_mass;
    if (one.against) {
      std::ranges::reverse(own);
      std::ranges::reverse(masses);
    }
    rest.insert(rest.end(), own.begin(), own.end());
    mass.back() += masses.front();  // that of the joint is of both
    mass.insert(mass.end(), masses.begin() + 1, masses.end());
  }
  for (const double some : mass) whole += some;
  std::vector<Vec3> points(mass.size());
  HangingChain().place({rest, mass, length_of(line, world), whole}, from, to, world.gravity,
                       points);
  std::size_t at = 0;
  for (const InLine& one : line) {
    Connector& connector = world.connectors[one.connector];
    const auto begin = points.begin() + static_cast<std::ptrdiff_t>(at);
    connector.position.assign(begin, begin + static_cast<std::ptrdiff_t>(connector.particles()));
    if (one.against) std::ranges::reverse(connector.position);
    at += connector.links();
  }
}

namespace {

constexpr double kShortest = 1e-2;  // of what a link is at the start: with less it turns too fast

const Value* winch_of(const Value& connector) {
  for (const char* end : {"from", "to"}) {
    if (const Value* winch = connector.find(end)->find("winch")) return winch;
  }
  return nullptr;
}

/// The lengths that keys of speeds (the x of `speeds`) make, known until `end` (s) at least: zero
/// at the start. Between keys the speed is the cubic without acceleration at either.
std::shared_ptr<const Path> integral(const Path& speeds, double end) {
  std::vector<PathKey> keys = speeds.keys();
  if (keys.back().time < end && keys.back().position.x() != 0) {
    keys.push_back(keys.back());
    keys.back().time = end;
  }
  double length = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i].velocity = keys[i].position;
    keys[i].ease = true;
    if (i > 0) {
      length +=
          (keys[i].time - keys[i - 1].time) * (keys[i - 1].velocity.x() + keys[i].velocity.x()) / 2;
    }
    keys[i].position.x() = length;
  }
  const Vec3 start = Path(keys).at(0).position;
  for (PathKey& key : keys) key.position -= start;
  return std::make_shared<const Path>(std::move(keys));
}

/// What a connector has that leaves a winch without meaning; null: nothing.
const char* misfit(const Value& connector) {
  if (text_or(connector, "look", "rope") == "chain") {
    return "the look of a chain, whose links have one size";
  }
  return connector.find("repeat") ? "copies" : nullptr;
}

}  // namespace

std::shared_ptr<const Path> read_length_keys(const Document& document, const Value& list,
                                             std::string_view key) {
  const bool by_speed = list.children.front().find("speed") != nullptr;
  for (const Value& entry : list.children) {
    const Value& found = *(entry.find("speed") ? entry.find("speed") : entry.find(key));
    if ((found.name == "speed") == by_speed) continue;
    document.fail_at_key(found, fmt::format("stands beside keys of {}, expected all of one kind",
                                            by_speed ? "speed" : key));
  }
  auto path = read_number_keys(document, list, by_speed ? "speed" : key);
  if (by_speed) path = integral(*path, document.root.find("duration")->number);
  const FrameMotion start = path->at(0);
  const auto refuse = [&](double found, const char* unit, std::string_view of) {
    if (std::abs(found) <= 1e-9) return;
    document.fail_at_key(
        list, fmt::format("has {:.6g} {} of {} at the start, expected 0", found, unit, of));
  };
  refuse(start.velocity.x(), "m/s", "speed");
  refuse(start.position.x(), "m", key);
  return path;
}

void check_least(const Document& document, const Value& key, const Winch& winch) {
  const double least = winch.least();
  for (std::size_t k = 0; k < winch.rest.size(); ++k) {
    if (winch.rest[k] + winch.share(k) * least >= kShortest * winch.rest[k]) continue;
    document.fail_at_key(key, fmt::format("takes in {:.6g} m, of {:.6g} m that it can", -least,
                                          (1 - kShortest) * winch.rest[k] / winch.share(k)));
  }
}

std::array<std::shared_ptr<const Path>, 2> read_winches(const Document& document,
                                                        const Value& value, const World& world,
                                                        const Connector& first,
                                                        const Connector& last) {
  std::array<std::shared_ptr<const Path>, 2> paths;
  for (const std::size_t end : {0u, 1u}) {
    const Value* winch = value.find(end == 0 ? "from" : "to")->find("winch");
    if (!winch) continue;
    const Connector& connector = end == 0 ? first : last;
    const std::size_t particle = end == 0 ? 0 : connector.links();
    const auto held = std::ranges::find(connector.holds, particle, &Hold::particle);
    if (held == connector.holds.end() || !is_prescribed(world, held->to)) {
      document.fail_at_key(*winch, "needs an end that is fixed or driven, not a free body's");
    }
    paths[end] = read_length_keys(document, *winch, "paid_out");
  }
  return paths;
}

void read_winches(const Document& document, const Value& value, const World& world,
                  Connector& connector) {
  const Value* named = winch_of(value);
  if (!named) return;
  if (const char* other = misfit(value)) {
    document.fail_at_key(
        *named,
        fmt::format("stands beside {}, expected one connector of links that have no size", other));
  }
  const auto [first, last] = read_winches(document, value, world, connector, connector);
  const auto carried = [&](const Hold& hold) { return !is_prescribed(world, hold.to); };
  const bool any_carried = std::ranges::any_of(connector.holds, carried);
  if (any_carried && connector.links() < 2) {
    document.mismatch(*value.find("particles"),
                      "at least 3, as the link at a free body keeps its length");
  }
  if (connector.mass == 0) document.mismatch(*value.find("mass"), "a number above 0 (kg)");
  add_winches(world, connector, first, last);
  check_least(document, *named, *connector.winch);
}

}  // namespace taut::scenes
