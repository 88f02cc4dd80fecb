// Writes sim/options.h: for every method of the list a struct with its settings.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "sim/run/method.h"

namespace {

using namespace taut;

/// A name of the list as C++ has names: dynamic_constraints.
std::string identifier(std::string_view name) {
  std::string word(name);
  for (char& c : word) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return word;
}

/// The type of a setting's choices: Integrator.
std::string type_of_choices(const SettingInfo& setting) {
  std::string word = identifier(setting.name);
  word[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(word[0])));
  return word;
}

std::string number(double value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  return {digits, end};
}

/// The meaning of the setting, its unit and the numbers that it takes.
std::string meaning(const SettingInfo& setting) {
  std::string line(setting.meaning);
  line[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(line[0])));
  if (line.back() != '.') line += '.';
  if (!std::holds_alternative<double>(setting.fallback)) return line;
  line += " Unit: " + std::string(setting.unit) + "; ";
  line += (setting.above ? "more than " : "at least ") + number(setting.minimum);
  if (setting.maximum < 1e300) line += ", at most " + number(setting.maximum);
  return line + (setting.whole ? ", whole." : ".");
}

/// `text` as lines of a comment.
std::string comment(const std::string& text) {
  std::istringstream words(text);
  std::string lines, line = "  ///";
  for (std::string word; words >> word;) {
    if (line.size() + 1 + word.size() > 100) {
      lines += line + "\n";
      line = "  ///";
    }
    line += " " + word;
  }
  return lines + line + "\n";
}

void write_member(std::ostream& out, const SettingInfo& setting) {
  const std::string name = identifier(setting.name);
  if (!setting.choices.empty()) {
    const std::string type = type_of_choices(setting);
    out << "  enum class " << type << " {";
    for (const std::string_view choice : setting.choices) {
      out << (choice == setting.choices.front() ? " " : ", ") << identifier(choice);
    }
    out << " };\n" << comment(meaning(setting)) << "  " << type << " " << name << " = " << type;
    out << "::" << identifier(std::get<std::string>(setting.fallback)) << ";\n";
    return;
  }
  out << comment(meaning(setting));
  if (const bool* flag = std::get_if<bool>(&setting.fallback)) {
    out << "  bool " << name << " = " << (*flag ? "true" : "false") << ";\n";
  } else {
    out << "  double " << name << " = " << number(std::get<double>(setting.fallback)) << ";\n";
  }
}

/// The member as a value of Settings.
std::string as_setting(const SettingInfo& setting) {
  const std::string member = "options." + identifier(setting.name);
  if (setting.choices.empty()) return member;
  std::string texts;
  for (const std::string_view choice : setting.choices) {
    texts += (texts.empty() ? "\"" : ", \"") + std::string(choice) + "\"";
  }
  return "std::string(std::array{" + texts + "}[static_cast<std::size_t>(" + member + ")])";
}

void write_method(std::ostream& out, const MethodInfo& method) {
  out << "\nnamespace " << identifier(method.name) << " {\n\n/// Of the method " << method.name
      << ": " << method.summary << ".\nstruct Options {\n"
      << "  static constexpr std::string_view method = \"" << method.name << "\";\n";
  for (const SettingInfo& setting : method.settings) write_member(out, setting);
  out << "};\n\ninline Settings settings(const Options& options) {\n  return {\n";
  for (const SettingInfo& setting : method.settings) {
    out << "      {\"" << setting.name << "\", " << as_setting(setting) << "},\n";
  }
  out << "  };\n}\n\n}  // namespace " << identifier(method.name) << "\n";
}

constexpr const char* kHead =
    R"(// Settings of methods with types: make_method(direct::Options{.tolerance = 1e-4}). Written by a
// program from what the methods say of their settings.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "sim/run/method.h"

namespace taut {

/// Makes the method whose settings these are. Throws std::invalid_argument where one is wrong.
template <class Options>
std::unique_ptr<Method> make_method(const Options& options) {
  return make_method(Options::method, settings(options));
}
)";

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: taut_options HEADER\n", stderr);
    return 2;
  }
  std::filesystem::create_directories(std::filesystem::path(argv[1]).parent_path());
  std::ofstream out(argv[1]);
  out << kHead;
  for (const MethodInfo& method : all_methods()) {
    if (!method.settings.empty()) write_method(out, method);
  }
  out << "\n}  // namespace taut\n";
  out.close();
  if (!out) std::fprintf(stderr, "%s: cannot be written\n", argv[1]);
  return out ? 0 : 6;
}
