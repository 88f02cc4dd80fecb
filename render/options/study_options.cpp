#include "render/options/study_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "render/base/atomic_file.h"
#include "render/film/frame_folder.h"
#include "render/program/command.h"
#include "scenes/files/files.h"
#include "scenes/load/load_scene.h"
#include "sim/evaluation/run.h"
#include "sim/motion/hash.h"

namespace taut::options {
namespace {

constexpr Features kUnstudied =
    kContactFeatures | Features{Feature::strings, Feature::pin, Feature::cut};

struct Study {
  std::string_view command;
  Features features;
};
constexpr Study kStudies[] = {
    {"bench", Features::all() - Feature::cut},
    {"chart", Features::all() - Feature::cut},
    {"classify", Features::all()},
    {"compare", Features::all()},
    {"report", Features::all() - (kUnstudied - Feature::pin)},
    {"stability", Features::all() - Features{Feature::pin, Feature::cut}},
    {"work-precision", Features::all() - Features{Feature::pin, Feature::cut}},
};

/// The commands that follow a feature: "compare and classify".
std::string studies_with(Feature feature) {
  std::vector<std::string_view> names;
  for (const Study& study : kStudies) {
    if (study.features.has(feature)) names.push_back(study.command);
  }
  const std::string_view last = names.back();
  names.pop_back();
  return fmt::format("{} and {}", fmt::join(names, ", "), last);
}

std::vector<Contender> all_contenders() {
  std::vector<Contender> all;
  const auto list = all_methods();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].reference) continue;
    const std::string name(list[i].name);
    all.push_back({name, &list[i], {name, {}}, chart::method_style(i)});
    chart::Style style = chart::method_style(i);
    style.hollow = true;
    for (const MethodForm& form : list[i].forms) {
      ++style.dash;
      all.push_back({name + ":" + std::string(form.name), &list[i], {name, form.settings}, style});
    }
  }
  return all;
}

}  // namespace

Features study_features(std::string_view command) {
  const auto found = std::ranges::find(kStudies, command, &Study::command);
  return found == std::end(kStudies) ? Features::all() - kUnstudied : found->features;
}

void add_study_options(program::Command& command, StudyOptions& options, const Budgets& budgets) {
  add_scene_options(command, options.inputs);
  command.add_option("--out", options.out,
                     "Folder for the results; default: in out/, by the scene's path");
  command
      .add_option("--methods", options.methods,
                  "Methods to compare, METHOD or METHOD:FORM, separated by commas; default: all")
      .delimiter(',');
  command
      .add_option("--budget", options.asked_budget,
                  fmt::format("CPU time, s, approximately; default: {}, with --quick {}",
                              budgets.usual, budgets.quick))
      .positive();
  command.add_flag("--quick", options.quick, "Coarse results, by default within half a minute");
}

void choose_budget(StudyOptions& options, const Budgets& budgets) {
  options.budget = options.asked_budget.value_or(options.quick ? budgets.quick : budgets.usual);
}

std::vector<Contender> chosen_contenders(const StudyOptions& options) {
  const std::vector<Contender> all = all_contenders();
  if (options.methods.empty()) return all;
  for (const std::string& name : options.methods) {
    if (std::ranges::find(all, name, &Contender::label) != all.end()) continue;
    std::string known;
    for (const Contender& one : all) known += (known.empty() ? "" : ", ") + one.label;
    throw program::Misuse(
        fmt::format("--methods: there is no {}, expected some of: {}", name, known));
  }
  std::vector<Contender> chosen;
  for (const Contender& one : all) {
    if (std::ranges::find(options.methods, one.label) != options.methods.end()) {
      chosen.push_back(one);
    }
  }
  return chosen;
}

std::vector<Contender> contenders_on(const StudyOptions& options, const World& world) {
  std::vector<Contender> all = chosen_contenders(options);
  const auto unable = std::stable_partition(
      all.begin(), all.end(), [&](const Contender& one) { return follows(*one.method, world); });
  if (!options.methods.empty() && unable != all.end()) {
    const Contender& first = *unable;
    throw program::Misuse(fmt::format("--methods: {} {}, in {}", first.label,
                                      refusal(*first.method, world), options.scene));
  }
  all.erase(unable, all.end());
  if (all.empty())
    throw program::Misuse(fmt::format("{}: no method follows all of it", options.scene));
  return all;
}

std::size_t place_of(const std::vector<Contender>& contenders, PaperRole role,
                     std::string_view form) {
  const MethodInfo* method = find_method(role);
  std::string label(method ? method->name : "");
  if (!form.empty()) label.append(":").append(form);
  const auto found = std::ranges::find(contenders, label, &Contender::label);
  return static_cast<std::size_t>(found - contenders.begin());
}

std::string legend_name(const Contender& contender) {
  const std::string missing(contender.method->missing);
  return missing.empty() ? contender.label : contender.label + " (" + missing + ")";
}

std::vector<MethodChoice> candidates_of(const Contender& contender, bool quick) {
  std::vector<MethodChoice> all;
  if (!contender.method->missing.empty()) return all;
  for (MethodChoice candidate : study::sweep(*contender.method, quick)) {
    for (const auto& [name, value] : contender.candidate.settings) candidate.settings[name] = value;
    const auto same = [&](const MethodChoice& other) {
      return other.settings == candidate.settings;
    };
    if (std::ranges::none_of(all, same)) all.push_back(std::move(candidate));
  }
  return all;
}

std::filesystem::path study_folder(const StudyOptions& options) {
  return results_folder(options.scene, options.out, options.inputs.several());
}

int for_each_study(const StudyOptions& options, const program::Common& common,
                   const std::function<int(const StudyOptions& one)>& study) {
  return for_each_scene(options.inputs, common, [&](const std::string& scene) {
    StudyOptions one = options;
    one.scene = scene;
    return study(one);
  });
}

scenes::Scene study_scene(const StudyOptions& options,
                          const std::vector<scenes::SceneChange>& changes, bool with_stage) {
  std::vector<scenes::SceneChange> all = scene_changes(options.inputs.set);
  all.insert(all.end(), changes.begin(), changes.end());
  scenes::Scene scene = scenes::load_scene(options.scene, with_stage, all);
  if (scene.world.connectors.empty()) {
    throw program::Misuse(fmt::format("{}: has no connector to study", options.scene));
  }
  scenes::settle_breaks(scene);
  const auto refusal = find_refusal({options.features}, scene.world, &scene.timeline);
  if (!refusal) return scene;
  const Feature feature = refusal->one.feature;
  throw program::Misuse(fmt::format("{}: has {} ({}), which {} follow, and this command does not",
                                    options.scene, name(feature), where(scene.world, refusal->one),
                                    studies_with(feature)));
  return scene;
}

scenes::Scene study_scene(const StudyOptions& options, std::size_t particles) {
  const scenes::Scene scene = study_scene(options);
  return study_scene(options, {{connector_key(scene, "particles"), std::to_string(particles)}});
}

std::uint64_t stamp_of(const StudyOptions& options) {
  Hash hash;
  hash.text(scenes::read_scene_text(options.scene));
  for (const std::string& set : options.inputs.set) hash.text(set);
  for (const std::string& method : options.methods) hash.text(method);
  return hash.number(options.budget)
      .number(options.quick)
      .number(options.reference_step)
      .number(film::program_fingerprint())
      .value();
}

std::string connector_key(const scenes::Scene& scene, const std::string& key) {
  return "connectors." + scene.world.connectors.front().name + "." + key;
}

std::string machine() {
  std::ifstream info("/proc/cpuinfo");
  info.exceptions(std::ios::badbit);  // or running out of memory would end the file
  std::string processor = "unknown processor";
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    processor = line.substr(std::min(line.size(), line.find(':') + 2));
    break;
  }
#ifdef NDEBUG
  constexpr const char* build = "release build";
#else
  constexpr const char* build = "debug build";
#endif
  return fmt::format("{}, g++ {}, {}, one thread", processor, __VERSION__, build);
}

std::string rounded(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (size != 0 && (size < 1e-3 || size >= 1e6)) return fmt::format("{:.2e}", value);
  if (size < 1000) return fmt::format("{:.3g}", value);
  const double unit = std::pow(10, std::floor(std::log10(size)) - 2);
  return fmt::format("{:.0f}", std::round(value / unit) * unit);
}

std::string percent(double share) {
  const double value = 100 * share;
  return (std::abs(value) < 1 ? fmt::format("{:.3g}", value) : rounded(value)) + "%";
}

void write_csv(const chart::Table& table, const std::filesystem::path& base) {
  std::filesystem::path file = base;
  file += ".csv";
  render::AtomicFile out(file);
  out.write(chart::to_csv(table));
  out.commit();
}

}  // namespace taut::options
