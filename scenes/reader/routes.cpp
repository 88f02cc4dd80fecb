#include "scenes/reader/routes.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "scenes/reader/winches.h"
#include "sim/world/winched.h"

namespace taut::scenes {
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

}  // namespace taut::scenes
