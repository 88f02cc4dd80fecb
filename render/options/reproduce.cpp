#include "render/options/reproduce.h"

#include <fmt/format.h>

#include "render/options/method_options.h"

namespace taut::options {
namespace {

std::string words_of(const ShownScene& scene) {
  std::string words = quoted(scene.file);
  for (const std::string& set : scene.set) words += " --set " + quoted(set);
  return words;
}

/// Every setting, named or not: where the scene is of the same method, its own would hold else.
std::string words_of(const MethodChoice& candidate) {
  std::string words;
  for (const auto& [name, value] : with_defaults(candidate)) {
    words += " --set " + quoted(name + "=" + setting_text(value));
  }
  return words;
}

}  // namespace

std::string quoted(const std::string& word) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=:,+-@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

std::string score_command(const ShownScene& scene, const MethodChoice& candidate, double share) {
  return fmt::format("taut simulate {} --method {}{} --score {} --json -q", words_of(scene),
                     candidate.name, words_of(candidate), share);
}

std::string classify_command(const ShownScene& scene,
                             const std::vector<scenes::SceneChange>& changes,
                             const std::string& label, const MethodChoice& candidate,
                             double duration, double cap, bool scored) {
  std::string words = words_of(scene);
  for (const scenes::SceneChange& change : changes) {
    words += " --set " + quoted(change.key + "=" + change.value);
  }
  for (const auto& [name, value] : candidate.settings) {
    words += " --set " + quoted(name + "=" + setting_text(value));
  }
  return fmt::format("taut classify {} --set duration={} --methods {} --cap {}{}", words, duration,
                     label, cap, scored ? "" : " --no-truth");
}

}  // namespace taut::options
