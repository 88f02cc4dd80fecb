#include "scenes/reader/common.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <span>

#include "scenes/files/files.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {
namespace fs = std::filesystem;

namespace {

bool is_inside(const fs::path& file, const fs::path& folder) {
  const auto [in_folder, in_file] = std::ranges::mismatch(folder, file);
  return in_folder == folder.end();
}

}  // namespace

FoundFile find_asset(const Document& document, const Value& value) {
  const fs::path asked(value.text);
  std::error_code error;
  const fs::path scene = fs::weakly_canonical(document.file, error).parent_path();
  throw_if_out_of_memory(error);
  const std::vector<AssetFolder> folders = asset_folders(scene);
  if (asked.is_absolute()) {
    document.mismatch(value, fmt::format("a path relative to one of: {}", places(folders)));
  }
  for (const AssetFolder& place : folders) {
    const fs::path file = fs::weakly_canonical(place.folder / asked, error);
    throw_if_out_of_memory(error);
    if (error || !fs::exists(file, error)) continue;
    if (!is_inside(file, place.within)) {
      document.mismatch(value, fmt::format("a file inside of {}", place.within.string()));
    }
    if (fs::is_directory(file, error)) document.mismatch(value, "a file, not a directory");
    const fs::path near = fs::proximate(file, error);
    throw_if_out_of_memory(error);
    return {error ? file : near, place.within};
  }
  document.fail(value,
                fmt::format("there is no file {}; looked: {}", shown(value), places(folders)));
}

fs::path find_file(const Document& document, const Value& value) {
  return find_asset(document, value).file;
}

double apart_by_rounding(double length, double largest) {
  constexpr double kRoundings = 8;  // of a few sums and products
  return kRounding * length + kRoundings * std::numeric_limits<double>::epsilon() * largest;
}

double number_or(const Value& table, std::string_view key, double fallback) {
  const Value* value = table.find(key);
  return value ? value->number : fallback;
}

Vec3 vec3_or(const Value& table, std::string_view key, const Vec3& fallback) {
  const Value* value = table.find(key);
  return value ? value->vec3() : fallback;
}

bool flag_or(const Value& table, std::string_view key, bool fallback) {
  const Value* value = table.find(key);
  return value ? value->flag : fallback;
}

std::string_view text_or(const Value& table, std::string_view key, std::string_view fallback) {
  const Value* value = table.find(key);
  return value ? std::string_view(value->text) : fallback;
}

const Value& connector_value(const Document& document, const Connector& connector) {
  const std::string_view name = written_name(connector.name);
  const Value* table = document.root.find("connectors");
  const Value* found = table ? table->find(name) : nullptr;
  return found ? *found : *document.root.find("nets")->find(name);
}

Vec3 direction(const Document& document, const Value& value) {
  const Vec3 unit = value.vec3().stableNormalized();
  if (unit.isZero()) document.fail(value, "found a vector of length 0, expected a direction");
  return unit;
}

Quat rotation(const Document& document, const Value& value) {
  Eigen::Vector4d wxyz;
  for (int i = 0; i < 4; ++i) wxyz[i] = value.children[static_cast<std::size_t>(i)].number;
  wxyz.stableNormalize();
  if (wxyz.isZero()) {
    document.fail(value, "found a quaternion of length 0, expected a rotation [w, x, y, z]");
  }
  return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
}

Names::Names(std::vector<std::string_view> names) : names_(std::move(names)) {
  for (std::size_t i = 0; i < names_.size(); ++i) indices_.emplace(names_[i], i);
}

Names::Names(const Value* table)
    : Names([&] {
        std::vector<std::string_view> names;
        if (table) {
          for (const Value& member : table->children) names.push_back(member.name);
        }
        return names;
      }()) {}

std::size_t Names::index_of(const Document& document, const Value& value,
                            std::string_view what) const {
  const auto found = indices_.find(value.text);
  if (found != indices_.end()) return found->second;
  constexpr std::size_t kShown = 20;
  const auto some = std::span(names_).first(std::min(names_.size(), kShown));
  const std::string near = suggestion(value.text, names_);
  const std::string known = names_.empty() ? ", the scene has none"
                            : near.empty() ? fmt::format(" of: {}{}", fmt::join(some, ", "),
                                                         names_.size() > kShown ? ", ..." : "")
                                           : near;
  document.mismatch(value, fmt::format("the name of a {}{}", what, known));
}

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
