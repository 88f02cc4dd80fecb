// Reading that all parts of a scene file share: names, files, members that may be missing,
// repeated connectors.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "scenes/files/error.h"
#include "scenes/format/document.h"
#include "scenes/scene/scene.h"
#include "sim/world/connector.h"

namespace taut::scenes {

/// A file that a scene names, and the folder (canonical) inside of which it is.
struct FoundFile {
  std::filesystem::path file, within;
};

/// The file that `value` names, in the first of the asset_folders() that has it. Throws BadScene
/// when the name is absolute, or the file missing or outside of the folder.
FoundFile find_asset(const Document& document, const Value& value);
std::filesystem::path find_file(const Document& document, const Value& value);

/// Does what needs the asset that `value` names. A BadAsset becomes a BadScene that names the
/// scene's place too.
auto with_place(const Document& document, const Value& value, auto&& use) {
  try {
    return use();
  } catch (const BadAsset& error) {
    document.fail(value, error.what());
  }
}

/// How far places that should be one may be apart, as a share of a connector's length: the rounding
/// of numbers that people type.
inline constexpr double kRounding = 1e-6;

/// How far (m) such places may be apart where a coordinate is as large as `largest` (m).
double apart_by_rounding(double length, double largest);

// Members that may be left out.
double number_or(const Value& table, std::string_view key, double fallback);
Vec3 vec3_or(const Value& table, std::string_view key, const Vec3& fallback);
bool flag_or(const Value& table, std::string_view key, bool fallback);
std::string_view text_or(const Value& table, std::string_view key, std::string_view fallback);

/// The table that a connector is of: its own, that of which it is a copy, or its net's.
const Value& connector_value(const Document& document, const Connector& connector);

/// A direction of any length but zero, as a unit vector.
Vec3 direction(const Document& document, const Value& value);
/// A quaternion [w, x, y, z] of any length but zero, as a rotation.
Quat rotation(const Document& document, const Value& value);

/// Names that values may say, found without a look at each.
class Names {
 public:
  explicit Names(std::vector<std::string_view> names);
  /// Of the members of a table of tables, in the order of the file; none for null.
  explicit Names(const Value* table);

  /// The index of the name that `value` says; `what` as in "body". Throws BadScene.
  std::size_t index_of(const Document& document, const Value& value, std::string_view what) const;
  std::size_t size() const { return names_.size(); }

 private:
  std::vector<std::string_view> names_;
  std::unordered_map<std::string_view, std::size_t> indices_;
};

// Connectors that a scene describes once and has many times.

/// A copy's place and time against those of the first.
struct Repeat {
  Vec3 by = Vec3::Zero();  // m
  double delay = 0;        // s
};

/// A connector's copies, the first included.
std::vector<Repeat> repeats(const Value& connector);
/// How many that are.
std::size_t repeat_count(const Value& connector);

/// Copy number `index` of `first`, its fixed points and paths with it; called NAME#2 and so on.
Connector repeated(const Connector& first, std::size_t index, const Repeat& repeat);

}  // namespace taut::scenes
