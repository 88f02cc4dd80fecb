#include "render/package/described.h"

#include <algorithm>

#include "render/program/help.h"
#include "sim/run/method.h"

namespace taut::package {
namespace {

/// The words of "TEXT:{auto,egl,osmesa}"; of --method the methods, and of --set beside it their
/// settings.
std::vector<std::string> choices_of(const CLI::App& app, const CLI::Option& option) {
  const std::string type = option.get_type_name();
  std::vector<std::string> words;
  const std::size_t open = type.find('{'), close = type.find('}', open);
  if (open != std::string::npos && close != std::string::npos) {
    std::string list = type.substr(open + 1, close - open - 1);
    for (std::string& word : CLI::detail::split(list, ',')) words.push_back(word);
  } else if (option.check_lname("method")) {
    for (const MethodInfo& method : all_methods()) words.emplace_back(method.name);
  } else if (option.check_lname("set") && app.get_option_no_throw("--method")) {
    for (const MethodInfo& method : all_methods()) {
      for (const SettingInfo& setting : method.settings) {
        const std::string word = std::string(setting.name) + "=";
        if (std::ranges::find(words, word) == words.end()) words.push_back(word);
      }
    }
  }
  return words;
}

DescribedOption described(const CLI::App& app, const CLI::Option& option) {
  DescribedOption result;
  if (!option.get_snames().empty()) result.shorts = option.get_snames().front();
  if (!option.get_lnames().empty()) result.longs = option.get_lnames().front();
  result.value = program::value_of(option);
  result.choices = choices_of(app, option);
  result.text = option.get_description();
  result.required = option.get_required();
  return result;
}

void add(const CLI::App& app, const std::string& above, std::vector<DescribedCommand>& list) {
  DescribedCommand command{above + app.get_name(), app.get_description(), app.get_footer(), {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_group().empty()) command.options.push_back(described(app, *option));
  }
  const auto below = app.get_subcommands([](const CLI::App*) { return true; });
  for (const CLI::App* child : below) command.commands.push_back(child->get_name());
  const std::string path = command.path + " ";
  list.push_back(std::move(command));
  for (const CLI::App* child : below) add(*child, path, list);
}

}  // namespace

std::vector<DescribedCommand> described(const CLI::App& app) {
  std::vector<DescribedCommand> list;
  add(app, "", list);
  return list;
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : between) + word;
  return line;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

}  // namespace taut::package
