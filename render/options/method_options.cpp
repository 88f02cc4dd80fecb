#include "render/options/method_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <cstdint>

#include "render/options/scene_options.h"
#include "render/program/command.h"
#include "render/program/help.h"
#include "scenes/format/document.h"
#include "scenes/format/format.h"
#include "scenes/load/load_scene.h"
#include "sim/run/method.h"

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

namespace {

/// `text` as the type that the setting, which the method must have, has.
Setting parsed(const MethodInfo& method, const std::string& name, const std::string& text) {
  const Setting& fallback = find_setting(method, name)->fallback;
  if (std::holds_alternative<std::string>(fallback)) return text;
  if (std::holds_alternative<bool>(fallback)) {
    if (text == "true") return true;
    if (text == "false") return false;
    throw program::Misuse(fmt::format("--set {}={}: expected true or false", name, text));
  }
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || last != end) {
    throw program::Misuse(fmt::format("--set {}={}: expected a number", name, text));
  }
  return number;
}

/// Throws Misuse if the method has no setting of that name: says which is meant, or whose it is.
void refuse_unknown(const MethodInfo& method, const std::string& name) {
  if (find_setting(method, name)) return;
  std::vector<std::string_view> known;
  for (const SettingInfo& setting : method.settings) known.push_back(setting.name);
  std::string others;
  for (const MethodInfo& other : all_methods())
    if (find_setting(other, name)) others += (others.empty() ? "" : ", ") + std::string(other.name);
  const std::string has = fmt::format("{}", fmt::join(known, ", "));
  if (!others.empty())
    throw program::Misuse(
        fmt::format("--set {}: is a setting of {}; {} has: {}", name, others, method.name, has));
  const std::string near = scenes::suggestion(name, known);
  throw program::Misuse(fmt::format("--set {}: {} has no such setting{}", name, method.name,
                                    near.empty() ? ", it has: " + has : near));
}

/// Keys with dots are never a method's.
bool is_of_scene(const std::string& key) {
  return key.find_first_of(".[") != std::string::npos || scenes::is_scene_key(key);
}

}  // namespace

void add_method_options(program::Command& command, MethodOptions& options) {
  const program::Option method = command.add_option(
      "--method", options.method, "Method to use instead of the scene's, at its default settings");
  program::Option step =
      command.add_option("--step", options.step, "Longest step of the method, s");
  const program::Option tolerance = command.add_option(
      "--tolerance", options.tolerance, "Largest error, m, for methods with error control");
  step.excludes(tolerance);
  const program::Option set =
      command
          .add_option("--set", options.set,
                      "Override a setting of the method (listed below), as in stiffness=5000, or a "
                      "key of the scene, as in connectors.rope.length=0.5; may be repeated")
          .one_value_each()
          .type_name("KEY=VALUE");
  command
      .add_flag("--planned", options.planned,
                "Use the model and method of the scene's plan, written by taut plan --write")
      .excludes(method)
      .excludes(step)
      .excludes(tolerance)
      .excludes(set);
  command.add_help(settings_help());
}

scenes::Scene load_chosen(const std::filesystem::path& file, bool with_stage,
                          const MethodOptions& options) {
  if (options.planned) return scenes::load_planned(file, with_stage);
  return scenes::load_scene(file, with_stage, chosen_changes(options));
}

std::vector<scenes::SceneChange> chosen_changes(const MethodOptions& options) {
  std::vector<scenes::SceneChange> changes;
  for (const std::string& text : options.set) {
    const auto [key, value] = set_pair(text);
    if (is_of_scene(key)) changes.push_back({key, value});
  }
  return changes;
}

std::vector<std::string> sets_of_scene(const std::vector<std::string>& set) {
  std::vector<std::string> own;
  for (const std::string& text : set) {
    if (is_of_scene(set_pair(text).key)) own.push_back(text);
  }
  return own;
}

Settings settings_of(const MethodInfo& method, const std::vector<std::string>& set) {
  Settings settings;
  for (const std::string& text : set) {
    const auto [key, value] = set_pair(text);
    if (!is_of_scene(key) && find_setting(method, key)) settings[key] = parsed(method, key, value);
  }
  return settings;
}

MethodChoice chosen_method(const MethodOptions& options, const scenes::Scene& scene) {
  MethodChoice choice = scene.method;
  if (!options.method.empty()) choice.name = options.method;
  if (const std::string wrong = method_complaint(choice.name); !wrong.empty()) {
    throw program::Misuse("--method: " + wrong);
  }
  const MethodInfo* method = find_method(choice.name);
  if (const std::string wrong = refusal(*method, scene.world); !wrong.empty()) {
    throw program::Misuse(fmt::format("--method: {} {}", choice.name, wrong));
  }
  if (choice.name != scene.method.name) choice.settings.clear();
  if (options.step) {
    choice.settings.erase("tolerance");
    choice.settings["step"] = *options.step;
    const bool endless = !step_complaint(choice.settings, scene.duration).empty();
    if (*options.step > 0 && !endless) {  // else what is wrong with it is said below
      const auto exact = scenes::dividing_step(*options.step, scene.fps);
      if (!exact) {
        throw program::Misuse(fmt::format("--step {}: expected {}", *options.step,
                                          scenes::dividing_text(*options.step, scene.fps)));
      }
      choice.settings["step"] = *exact;
    }
  }
  if (options.tolerance) {
    choice.settings.erase("step");
    choice.settings["tolerance"] = *options.tolerance;
  }
  for (const std::string& text : options.set) {
    const auto [name, value] = set_pair(text);
    if (is_of_scene(name)) continue;
    refuse_unknown(*method, name);
    choice.settings[name] = parsed(*method, name, value);
  }
  const std::string wrong = complaint(*method, choice.settings);
  if (!wrong.empty()) throw program::Misuse(wrong);
  const std::string endless = step_complaint(choice.settings, scene.duration);
  if (!endless.empty()) throw program::Misuse("--step: " + endless);
  return choice;
}

nlohmann::ordered_json settings_json(const Settings& settings) {
  auto object = nlohmann::ordered_json::object();
  for (const auto& [name, value] : settings) {
    // Whole numbers are written as such: a count has no .0.
    const double* number = std::get_if<double>(&value);
    if (number && std::abs(*number) < 1e15 && *number == std::floor(*number)) {
      object[name] = static_cast<std::int64_t>(*number);
    } else {
      std::visit([&, &key = name](const auto& v) { object[key] = v; }, value);
    }
  }
  return object;
}

std::string settings_text(const Settings& settings) {
  std::string line;
  for (const auto& [name, value] : settings) {
    line += fmt::format("{}{} = {}", line.empty() ? "" : ", ", name, setting_text(value));
  }
  return line;
}

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
