#include "scenes/reader/winches.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/reader/common.h"
#include "scenes/reader/paths.h"
#include "sim/world/winched.h"

namespace taut::scenes {

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
