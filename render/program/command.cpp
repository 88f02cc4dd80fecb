#include "render/program/command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "render/program/help.h"
#include "scenes/files/files.h"

namespace taut::program {
namespace {

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0) return {};
  return value;
}

}  // namespace

std::vector<int> frame_list(const std::optional<std::string>& text, int total) {
  std::set<int> frames;
  if (!text)
    for (int i = 0; i < total; ++i) frames.insert(i);
  std::string_view rest;
  if (text) rest = *text;
  while (!rest.empty()) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const std::string_view part = rest.substr(0, comma);
    const std::size_t dash = part.find('-');
    const auto first = whole_number(part.substr(0, dash));
    const auto last = dash == part.npos ? first : whole_number(part.substr(dash + 1));
    if (!first || !last || *last < *first)
      throw Misuse(fmt::format("--frames: '{}' is no frame or range (expected A-B,C)", part));
    if (*last >= total)
      throw Misuse(
          fmt::format("--frames: frame {} is beyond the clip's last, {}", *last, total - 1));
    for (int i = *first; i <= *last; ++i) frames.insert(i);
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  if (frames.empty()) throw Misuse("--frames: names no frame (expected A-B,C)");
  return {frames.begin(), frames.end()};
}

std::pair<int, int> picture_size(const std::string& text) {
  const std::string_view whole = text;
  const std::size_t cross = std::min(whole.find('x'), whole.size() - 1);
  const int width = whole_number(whole.substr(0, cross)).value_or(0);
  const int height = whole_number(whole.substr(cross + 1)).value_or(0);
  if (width == 0 || height == 0)
    throw Misuse(fmt::format("--size: '{}' is no size (expected WxH, such as 1280x720)", text));
  return {width, height};
}

Option& Option::range(double least, double most) {
  option_->check(CLI::Range(least, most));
  return *this;
}

Option& Option::positive() {
  option_->check(CLI::PositiveNumber);
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& values) {
  option_->check(CLI::IsMember(values));
  return *this;
}

Option& Option::existing_folder() {
  option_->check(CLI::ExistingDirectory);
  return *this;
}

Option& Option::required(bool is) {
  option_->required(is);
  return *this;
}

Option& Option::delimiter(char between) {
  option_->delimiter(between);
  return *this;
}

Option& Option::one_value_each() {
  option_->allow_extra_args(false);
  return *this;
}

Option& Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

Option& Option::type_name(const std::string& of_value) {
  option_->type_name(of_value);
  return *this;
}

namespace {

/// A word that begins with two dashes is another option, and this one lacks its value.
std::string refuse_option(const std::string& value) {
  return value.starts_with("--") ? fmt::format("found {}, expected a value", value) : "";
}

}  // namespace

template <class Value>
Option Command::add_option(const std::string& names, Value& value, const std::string& help) {
  CLI::Option* option = app_->add_option(names, value, help);
  if constexpr (std::is_same_v<Value, std::string>) option->check(refuse_option, "");
  return Option(*option);
}

template Option Command::add_option(const std::string&, std::string&, const std::string&);
template Option Command::add_option(const std::string&, int&, const std::string&);
template Option Command::add_option(const std::string&, double&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<std::string>&,
                                    const std::string&);
template Option Command::add_option(const std::string&, std::optional<double>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<std::string>&,
                                    const std::string&);
template Option Command::add_option(const std::string&, std::vector<double>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<std::size_t>&,
                                    const std::string&);

Option Command::add_flag(const std::string& names, bool& value, const std::string& help) {
  return Option(*app_->add_flag(names, value, help));
}

Option Command::add_size(const std::string& names, double& bytes, const std::string& help) {
  const auto take = [&bytes](const std::uint64_t& number) { bytes = double(number); };
  CLI::Option* option = app_->add_option_function<std::uint64_t>(names, take, help);
  option->transform(CLI::AsSizeValue(true))->type_name("SIZE");
  return Option(*option);
}

Option Command::add_text(const std::string& names, std::function<void(const std::string&)> take,
                         const std::string& help) {
  return Option(*app_->add_option_function<std::string>(
      names,
      [names, take = std::move(take)](const std::string& text) {
        try {
          take(text);
        } catch (const Misuse& misuse) {
          throw CLI::ValidationError(names, misuse.what());
        }
      },
      help));
}

void Command::add_help(const std::string& section) {
  app_->footer(app_->get_footer() + "\n\n" + section);
}

void Command::callback(std::function<void()> chosen) {
  app_->callback(std::move(chosen));
}

Command add_command(CLI::App& app, Program& program, const std::string& name,
                    const std::string& summary, const std::string& examples) {
  CLI::App& added = *app.add_subcommand(name, summary);
  added.formatter(help_format());
  added.footer("\nExamples:\n" + examples);
  Command command(added);
  command.add_flag("--quiet,-q", program.common.quiet,
                   "Print no progress and no notes, only errors");
  command.add_flag("--json", program.common.json, "Print the result as JSON on standard output");
  command
      .add_option("--threads", program.common.threads,
                  "Most threads for drawing (simulation uses one); default: 0, all")
      .range(0, 1024);
  command
      .add_text(
          "--assets", [](const std::string& folder) { scenes::set_asset_folder(folder); },
          "Folder to search first for files that a scene names")
      .existing_folder();
  return command;
}

}  // namespace taut::program
