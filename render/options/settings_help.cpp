#include "render/options/settings_help.h"

#include <fmt/format.h>

#include "render/program/help.h"
#include "sim/run/method_choice.h"

namespace taut::options {
namespace {

/// "tolerance = 1e-4 m".
std::string default_of(const SettingInfo& setting) {
  const bool unit = !setting.unit.empty() && setting.unit != "1";
  return fmt::format("{} = {}{}{}", setting.name, setting_text(setting.fallback), unit ? " " : "",
                     unit ? setting.unit : "");
}

/// The values that the setting accepts: "0.5 to 1", "more than 0", "rk4, verlet".
std::string range_of(const SettingInfo& setting) {
  std::string words;
  for (const std::string_view choice : setting.choices) {
    words += (words.empty() ? "" : ", ") + std::string(choice);
  }
  if (std::holds_alternative<bool>(setting.fallback)) words = "true, false";
  if (!std::holds_alternative<double>(setting.fallback)) return words;
  const std::string least = setting_text(setting.minimum);
  words = setting.above ? "more than " + least : least;
  if (setting.maximum < 1e300) {
    words += (setting.above ? ", at most " : " to ") + setting_text(setting.maximum);
  } else if (!setting.above) {
    words += " or more";
  }
  return words + (setting.whole ? ", whole" : "");
}

}  // namespace

std::string settings_help() {
  std::string text =
      "Settings of the methods, for --set NAME=VALUE and a scene's [method], with their "
      "defaults:\n";
  for (const MethodInfo& method : all_methods()) {
    text += fmt::format("\n{}: {}\n", method.name, method.summary);
    for (const SettingInfo& setting : method.settings) {
      text += program::help_entry(default_of(setting),
                                  fmt::format("{} [{}]", setting.meaning, range_of(setting)));
    }
  }
  return text;
}

}  // namespace taut::options
