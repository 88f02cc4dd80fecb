#include "scenes/reader/paths.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "scenes/files/regular_file.h"
#include "scenes/format/scene_format.h"
#include "scenes/reader/common.h"
#include "sim/motion/rotation.h"

namespace taut::scenes {

namespace {

/// The rotation that takes the frame `before` to one whose y axis is `axis` the shortest way, so
/// that a path of directions does not spin about them.
Quat turned_to(const Quat& before, const Vec3& axis) {
  return (rotation_between(before * Vec3::UnitY(), axis) * before).normalized();
}

/// Puts a choreography's keys where they belong; the path rests before and after.
void insert(const Document& document, const Value& list, const std::vector<PathKey>& found,
            std::vector<PathKey>& keys) {
  const double from = found.front().time, until = found.back().time;
  const auto later = std::ranges::lower_bound(keys, from, {}, &PathKey::time);
  if (later == keys.begin() || (later != keys.end() && later->time <= until)) {
    document.fail_at_key(list, fmt::format("the choreography's file has the keys from {} to {} s: "
                                           "expected one key before and none there",
                                           from, until));
  }
  std::prev(later)->ease = true;
  const auto first = keys.insert(later, found.begin(), found.end());
  (first + static_cast<std::ptrdiff_t>(found.size()) - 1)->ease = true;
}

/// With the keys that a choreography has found.
Path read_keys(const Document& document, const Value& list, const std::vector<PathKey>& found) {
  std::vector<PathKey> keys;
  for (const Value& entry : list.children) {
    const Value& time = *entry.find("t");
    PathKey key{time.number, entry.find("position")->vec3(),
                keys.empty() ? Quat::Identity() : keys.back().rotation,
                flag_or(entry, "ease", false)};
    if (!keys.empty() && !(key.time > keys.back().time)) {
      document.mismatch(
          time, fmt::format("a time after {} s, where the key before it ends", keys.back().time));
    }
    if (const Value* value = entry.find("rotation")) key.rotation = rotation(document, *value);
    if (const Value* value = entry.find("axis")) {
      key.rotation = turned_to(key.rotation, direction(document, *value));
    }
    const double hold = number_or(entry, "hold", 0);
    if (hold > 0) key.ease = true;
    keys.push_back(key);
    if (hold > 0) {
      key.time += hold;
      keys.push_back(key);
    }
  }
  if (!found.empty()) insert(document, list, found, keys);
  return Path(std::move(keys));
}

Path read_circle(const Document& document, const Value& value) {
  const Circle circle{value.find("centre")->vec3(), value.find("start")->vec3(),
                      direction(document, *value.find("axis")), value.find("frequency")->number,
                      value.find("ramp")->number};
  constexpr double kOblique = 1e-9;  // of numbers that people type, as a share of the radius
  const Vec3 radius = circle.start - circle.centre;
  if (!(radius.norm() > 0) || std::abs(radius.dot(circle.axis)) > kOblique * radius.norm()) {
    document.mismatch(*value.find("start"),
                      "a point beside the centre, at right angles to the axis");
  }
  return Path::round(circle);
}

Path read_axle(const Document& document, const Value& value) {
  return Path::about({value.find("position")->vec3(), direction(document, *value.find("axis")),
                      read_number_keys(document, *value.find("keys"), "angle"),
                      number_or(value, "pitch", 0)});
}

/// A row of numbers between commas; false when a field is none.
bool split(std::string_view line, std::vector<double>& row) {
  row.clear();
  for (;;) {
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
    if (error != std::errc() || !std::isfinite(number)) return false;
    row.push_back(number);
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    if (line.empty()) return true;
    if (line.front() != ',') return false;
    line.remove_prefix(1);
  }
}

constexpr std::size_t kMaxPathBytes = 64 << 20;
constexpr std::size_t kMaxLine = 4096;  // bytes

}  // namespace

Path read_path_csv(const std::filesystem::path& file) {
  return path_from_csv(read_regular_file(file, kMaxPathBytes, "rows of t,x,y,z"), file);
}

Path path_from_csv(const std::string& text, const std::filesystem::path& file) {
  const auto fail = [&](std::size_t line, const std::string& message) {
    throw BadAsset(fmt::format("{}:{}: {}", file.string(), line, message));
  };
  std::vector<PathKey> keys;
  std::vector<double> row;
  std::size_t columns = 0, number = 1;
  for (std::size_t start = 0; start < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    std::string_view line = std::string_view(text).substr(start, end - start);
    start = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.size() > kMaxLine) {
      fail(number, fmt::format("a line of {} bytes, expected at most {}", line.size(), kMaxLine));
    }
    if (number == 1) {
      columns = line == "t,x,y,z" ? 4 : line == "t,x,y,z,qw,qx,qy,qz" ? 8 : 0;
      if (columns == 0) fail(1, "expected the columns t,x,y,z or t,x,y,z,qw,qx,qy,qz");
      continue;
    }
    if (line.empty()) continue;
    if (!split(line, row) || row.size() != columns) {
      fail(number, fmt::format("expected {} finite numbers between commas", columns));
    }
    PathKey key{row[0], {row[1], row[2], row[3]}, Quat::Identity(), false};
    if (!(std::abs(key.time) <= format_keys::kLongest)) {
      fail(number, fmt::format("found the time {}, expected one from {} to {} s", key.time,
                               -format_keys::kLongest, format_keys::kLongest));
    }
    if (columns == 8) {
      key.rotation = Quat(row[4], row[5], row[6], row[7]);
      if (!(key.rotation.norm() > 0)) fail(number, "found a quaternion of length 0");
      key.rotation.normalize();
    }
    if (!keys.empty() && !(key.time > keys.back().time)) {
      fail(number,
           fmt::format("found the time {}, expected one after {}", key.time, keys.back().time));
    }
    keys.push_back(key);
  }
  if (keys.empty()) fail(1, "has no rows, expected at least one key");
  return Path(std::move(keys));
}

namespace {

/// The keys of the file that the scene's choreography names, where it leads the path of that name;
/// else none.
std::vector<PathKey> choreographed_keys(const Document& document, std::string_view path) {
  const Value* table = document.root.find("choreography");
  if (!table || table->find("path")->text != path) return {};
  const Value& file = *table->find("file");
  const auto found = find_file(document, file);
  return with_place(document, file, [&] { return read_path_csv(found).keys(); });
}

Path read_file(const Document& document, const Value& value) {
  const auto file = find_file(document, value);
  return with_place(document, value, [&] { return read_path_csv(file); });
}

}  // namespace

std::vector<std::shared_ptr<const Path>> read_paths(const Document& document) {
  std::vector<std::shared_ptr<const Path>> paths;
  if (const Value* table = document.root.find("paths")) {
    for (const Value& entry : table->children) {
      const Value& motion = entry.children.front();
      paths.push_back(std::make_shared<const Path>(
          motion.name == "keys"
              ? read_keys(document, motion, choreographed_keys(document, entry.name))
          : motion.name == "circle" ? read_circle(document, motion)
          : motion.name == "axle"   ? read_axle(document, motion)
                                    : read_file(document, motion)));
    }
  }
  return paths;
}

std::shared_ptr<const Path> read_number_keys(const Document& document, const Value& list,
                                             std::string_view value) {
  std::vector<PathKey> keys;
  for (const Value& entry : list.children) {
    const Value& time = *entry.find("t");
    if (!keys.empty() && !(time.number > keys.back().time)) {
      document.mismatch(
          time, fmt::format("a time after {} s, that of the key before it", keys.back().time));
    }
    const Vec3 number(entry.find(value)->number, 0, 0);
    keys.push_back({time.number, number, Quat::Identity(), flag_or(entry, "ease", false)});
  }
  return std::make_shared<const Path>(std::move(keys));
}

}  // namespace taut::scenes
