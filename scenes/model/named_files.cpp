#include "scenes/model/named_files.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/files/files.h"
#include "scenes/model/model.h"

namespace taut::scenes {

namespace fs = std::filesystem;

namespace {

std::optional<int> hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return {};
}

/// A percent sign without two digits stands for itself.
std::string decoded(const std::string& uri) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const bool enough = uri[i] == '%' && i + 2 < uri.size();
    const auto high = enough ? hex_digit(uri[i + 1]) : std::nullopt;
    const auto low = enough ? hex_digit(uri[i + 2]) : std::nullopt;
    name += high && low ? static_cast<char>(16 * *high + *low) : uri[i];
    if (high && low) i += 2;
  }
  return name;
}

/// Whether it starts like "http:" or "C:".
bool has_scheme(const std::string& uri) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto end = std::ranges::find_if_not(uri, [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
  });
  return end != uri.end() && *end == ':' && end != uri.begin() && is_letter(uri[0]);
}

}  // namespace

std::optional<std::string> name_of_uri(const std::string& uri) {
  if (has_scheme(uri)) return {};
  std::string name = decoded(uri);
  std::ranges::replace(name, '\\', '/');
  if (name.empty() || name[0] == '/' || name.find('\0') != name.npos) return {};
  return name;
}

std::string in_quotes(std::string_view name) {
  constexpr std::size_t kShown = 200;
  return fmt::format("\"{}{}\"", name.substr(0, kShown), name.size() > kShown ? "..." : "");
}

bool NamedFiles::is_missing(const std::string& name) const {
  const auto known = bytes_.find(name);
  return known != bytes_.end() && !known->second;
}

const std::string* NamedFiles::find(const NamedFile& file) {
  const auto known = bytes_.find(file.name);
  if (known != bytes_.end()) return known->second ? &*known->second : nullptr;
  if (std::ranges::find(wanted_, file.name, &NamedFile::name) == wanted_.end()) {
    wanted_.push_back(file);
  }
  return nullptr;
}

void NamedFiles::read(const fs::path& model, const fs::path& project,
                      const std::vector<NamedFile>& files) {
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(model, error).parent_path();
  throw_if_out_of_memory(error);
  for (const NamedFile& file : files) {
    if (bytes_.contains(file.name)) continue;
    const std::string shown = fmt::format("{}: {}", model.string(), file.where);
    if (bytes_.size() == model_limits::files) {
      throw bad_asset(shown, fmt::format("is beyond {} files", model_limits::files));
    }
    auto bytes = read_beneath(project, folder.lexically_relative(project) / file.name,
                              model_limits::bytes, file.expected, shown);
    if (bytes) size_ += bytes->size();
    if (size_ > model_limits::all_bytes) {
      throw bad_asset(shown,
                      fmt::format("with it, the files that the model names are larger than {} MiB",
                                  model_limits::all_bytes >> 20));
    }
    bytes_.emplace(file.name, std::move(bytes));
  }
  wanted_.clear();
}

}  // namespace taut::scenes
