#include "render/options/scene_options.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <set>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/program/output.h"
#include "render/program/program.h"
#include "scenes/files/error.h"
#include "scenes/load/default_stage.h"
#include "scenes/load/load_scene.h"

namespace taut::options {
namespace {

namespace fs = std::filesystem;

constexpr const char* kInput = "stdin";  // the name of results of standard input

/// The scene's path below the working folder, or else from the root; without its ending.
fs::path path_of_results(const std::string& scene) {
  if (scene == "-") return kInput;
  std::error_code error;
  const fs::path here = fs::current_path(error);
  const fs::path full = fs::absolute(scene, error).lexically_normal();
  fs::path path = full.lexically_relative(here);
  if (path.empty() || *path.begin() == "..") path = full.relative_path();
  fs::path name = path;
  name.replace_extension();
  if (*path.begin() == "scenes") return name.lexically_relative("scenes");
  // Beside a folder of scenes, a scene of the same name.
  if (fs::exists("scenes" / path, error)) return path;
  return name;
}

}  // namespace

program::Option add_scene_options(program::Command& command, SceneOptions& options, bool with_set) {
  program::Option scenes =
      command.add_option("scenes", options.scenes, "Scene files; - is standard input")
          .required()
          .type_name("SCENE");
  if (!with_set) return scenes;
  command
      .add_option("--set", options.set,
                  "Override a key of the scene, as in connectors.rope.length=0.5; may be repeated")
      .one_value_each()
      .type_name("KEY=VALUE");
  return scenes;
}

SetPair set_pair(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw program::Misuse(fmt::format("--set {}: expected KEY=VALUE", text));
  }
  return {text.substr(0, equals), text.substr(equals + 1)};
}

std::vector<scenes::SceneChange> scene_changes(const std::vector<std::string>& set) {
  std::vector<scenes::SceneChange> changes;
  for (const std::string& text : set) {
    const auto [key, value] = set_pair(text);
    changes.push_back({key, value});
  }
  return changes;
}

void tell_old_keys(const SceneOptions& options, const program::Common& common) {
  if (common.quiet) return;
  for (const std::string& scene : options.scenes) {
    try {
      for (const std::string& told : scenes::old_keys(scene)) program::note("{}\n", told);
    } catch (const scenes::BadScene&) {  // whoever reads it for its work says so
    }
  }
}

void tell_left_out(const scenes::Scene& scene, const program::Common& common) {
  static std::set<std::string> told;
  if (common.quiet || !scene.stage) return;
  for (const std::string& line : scenes::left_out(*scene.stage)) {
    if (told.insert(line).second) program::note("warning: {}\n", line);
  }
}

void complete_stage(scenes::Scene& scene, const std::vector<scenes::SceneChange>& changes,
                    const program::Common& common) {
  const std::string left_out = scenes::complete_stage(scene, changes, render::stop_if_interrupted);
  if (!left_out.empty() && !common.quiet) program::note("{}\n", left_out);
}

std::vector<std::string> sweep_values(const std::string& sweep) {
  if (sweep.empty()) return {""};
  const auto misuse = [&] {
    return program::Misuse(fmt::format(
        "--sweep {}: expected KEY=FROM:UNTIL:COUNT, as in connectors.rope.length=0.5:1:6", sweep));
  };
  constexpr std::size_t kMost = 10'000;
  const std::size_t equals = sweep.find('=');
  if (equals == std::string::npos || equals == 0) throw misuse();
  std::array<double, 3> numbers{};
  const char* at = sweep.data() + equals + 1;
  const char* const end = sweep.data() + sweep.size();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    const bool last = i + 1 == numbers.size();
    if (error != std::errc() || !std::isfinite(numbers[i])) throw misuse();
    if (last ? next != end : next == end || *next != ':') throw misuse();
    at = next + 1;
  }
  const auto [from, until, count] = numbers;
  if (!(count >= 1 && count <= kMost && count == std::floor(count))) throw misuse();
  std::vector<std::string> pairs;
  for (int i = 0; i < count; ++i) {
    const double share = count > 1 ? i / (count - 1) : 0;
    // Rounded as people write numbers: 0.1 to 0.3 in three steps has 0.2.
    const double value = std::stod(fmt::format("{:.15g}", (1 - share) * from + share * until));
    pairs.push_back(fmt::format("{}={}", sweep.substr(0, equals), value));
  }
  return pairs;
}

int for_each_scene(const SceneOptions& options, const program::Common& common,
                   const std::function<int(const std::string& scene)>& work) {
  return for_each_run(options, {""}, common,
                      [&](const std::string& scene, const std::string&) { return work(scene); });
}

int for_each_run(
    const SceneOptions& options, const std::vector<std::string>& pairs,
    const program::Common& common,
    const std::function<int(const std::string& scene, const std::string& pair)>& work) {
  tell_old_keys(options, common);
  if (!options.several() && pairs.size() == 1) {
    return work(options.scenes.front(), pairs.front());
  }
  int code = program::kDone;
  const char* between = "[\n";
  for (std::size_t i = 0; i < options.scenes.size() * pairs.size(); ++i) {
    if (common.json) render::write_output(between);
    between = ",\n";
    const int own = program::guarded(
        common, [&] { return work(options.scenes[i / pairs.size()], pairs[i % pairs.size()]); });
    if (code == program::kDone) code = own;
    if (own == program::kInterrupted || own == program::kTerminated) break;
  }
  if (common.json) render::write_output("]\n");
  return code;
}

fs::path results_folder(const std::string& scene, const std::string& out, bool several,
                        const fs::path& base) {
  if (!out.empty() && !several) return out;
  return (out.empty() ? base : fs::path(out)) / path_of_results(scene);
}

std::string scene_name(const std::string& scene) {
  return scene == "-" ? kInput : fs::path(scene).stem().string();
}

}  // namespace taut::options
