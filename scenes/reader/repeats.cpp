#include "scenes/reader/repeats.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/reader/common.h"

namespace taut::scenes {

std::vector<Repeat> repeats(const Value& connector) {
  std::vector<Repeat> all{{}};
  const Value* list = connector.find("repeat");
  if (!list) return all;
  for (const Value& row : list->children) {
    const auto count = static_cast<std::size_t>(row.find("count")->number);
    const Vec3 by = row.find("by")->vec3();
    const double delay = number_or(row, "delay", 0);
    const std::vector<Repeat> before = std::move(all);
    all.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const auto times = static_cast<double>(i);
      for (const Repeat& one : before) {
        all.push_back({one.by + times * by, one.delay + times * delay});
      }
    }
  }
  return all;
}

std::size_t repeat_count(const Value& connector) {
  double count = 1;
  if (const Value* list = connector.find("repeat")) {
    for (const Value& row : list->children) count *= row.find("count")->number;
  }
  return static_cast<std::size_t>(std::min(count, 1e9));  // far beyond what is allowed
}

Connector repeated(const Connector& first, std::size_t index, const Repeat& repeat) {
  Connector copy = first;
  copy.name = fmt::format("{}#{}", first.name, index + 1);
  for (Vec3& position : copy.position) position += repeat.by;
  for (Hold& hold : copy.holds) {
    if (hold.to.kind == Attachment::Kind::path) {
      hold.to.path = std::make_shared<const Path>(hold.to.path->moved(repeat.by, repeat.delay));
    } else {
      hold.to.point += repeat.by;
    }
    if (hold.turn) {
      hold.turn = std::make_shared<const Path>(hold.turn->moved(Vec3::Zero(), repeat.delay));
    }
  }
  return copy;
}

}  // namespace taut::scenes
