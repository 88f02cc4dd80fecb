#include "render/program/help.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string>

namespace taut::program {
namespace {

constexpr std::size_t kWidth = 100, kColumn = 30;  // letters; where descriptions begin

}  // namespace

std::string help_entry(const std::string& name, const std::string& description) {
  std::string text = "  " + name, line;
  if (text.size() + 2 > kColumn) {
    text += '\n';
  } else {
    line = text + std::string(kColumn - text.size(), ' ');
    text.clear();
  }
  if (line.empty()) line = std::string(kColumn, ' ');
  std::istringstream words(description);
  bool first = true;
  for (std::string word; words >> word; first = false) {
    if (!first && line.size() + 1 + word.size() > kWidth) {
      text += line + '\n';
      line = std::string(kColumn, ' ');
      first = true;
    }
    line += (first ? "" : " ") + word;
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return text + line + '\n';
}

std::string value_of(const CLI::Option& option) {
  std::string type = option.get_type_name();
  type = type.substr(0, type.find_first_of(": "));
  if (option.get_items_expected_max() == 0) return "";
  if (type == "INT" || type == "UINT" || type == "FLOAT") return "N";
  if (type != "TEXT" && !type.empty()) return type;
  std::string name = option.get_name(false, false);
  name.erase(0, name.find_first_not_of('-'));
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::toupper(c); });
  return name;
}

namespace {

class Format : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    const std::string value = value_of(*option);
    std::string name = is_positional ? value : option->get_name(false, true);
    if (is_positional && option->get_expected_max() > 1) name += "...";
    if (!is_positional && !value.empty()) name += " " + value;
    return help_entry(name, option->get_description());
  }

  std::string make_subcommand(const CLI::App* command) const override {
    return help_entry(command->get_name(), command->get_description());
  }

  std::string make_usage(const CLI::App* app, std::string name) const override {
    std::string usage = "\nUsage: " + name + " [OPTIONS]";
    for (const CLI::Option* option :
         app->get_options([](const CLI::Option* o) { return o->get_positional(); })) {
      usage += option->get_required() ? " " + value_of(*option) : " [" + value_of(*option) + "]";
      if (option->get_expected_max() > 1) usage += "...";
    }
    const bool has_commands =
        !app->get_subcommands([](const CLI::App* a) { return !a->get_name().empty(); }).empty();
    return usage + (has_commands ? " COMMAND" : "") + "\n\n";
  }
};

}  // namespace

std::shared_ptr<CLI::Formatter> help_format() {
  return std::make_shared<Format>();
}

}  // namespace taut::program
