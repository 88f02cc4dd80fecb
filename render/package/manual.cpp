#include <algorithm>
#include <sstream>

#include "render/package/described.h"

namespace taut::package {
namespace {

/// Text as roff has it: no control characters, hyphens that can be copied.
std::string roff(const std::string& text) {
  std::string out = replaced(replaced(text, "\\", "\\e"), "-", "\\-");
  if (out.starts_with('.') || out.starts_with('\'')) out.insert(0, "\\&");
  return out;
}

/// Lines as they stand.
std::string verbatim(const std::string& text) {
  std::istringstream lines(text);
  std::string out = ".nf\n";
  for (std::string line; std::getline(lines, line);) out += roff(line) + "\n";
  return out + ".fi\n";
}

std::string synopsis(const DescribedCommand& command) {
  std::string line = "\\fB" + roff(command.path) + "\\fR";
  for (const DescribedOption& option : command.options) {
    if (!option.is_positional()) continue;
    const std::string name = "\\fI" + roff(option.value) + "\\fR";
    line += option.required ? " " + name : " [" + name + "]";
  }
  if (!command.commands.empty()) line += " \\fICOMMAND\\fR";
  return line + " [\\fIOPTIONS\\fR]\n";
}

std::string tag(const DescribedOption& option) {
  if (option.is_positional()) return "\\fI" + roff(option.value) + "\\fR";
  std::string line;
  if (!option.shorts.empty()) line = "\\fB" + roff("-" + option.shorts) + "\\fR";
  if (!option.longs.empty()) {
    line += (line.empty() ? "\\fB" : ", \\fB") + roff("--" + option.longs) + "\\fR";
  }
  return option.value.empty() ? line : line + " \\fI" + roff(option.value) + "\\fR";
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

}  // namespace

std::string manual_page(const DescribedCommand& command,
                        const std::vector<DescribedCommand>& commands) {
  const std::string name = replaced(command.path, " ", "-");
  std::string page = ".TH " + roff(upper(name)) + " 1\n.SH NAME\n" + roff(name) + " \\- " +
                     roff(command.summary) + "\n.SH SYNOPSIS\n" + synopsis(command);
  if (!command.commands.empty()) page += ".SH COMMANDS\n";
  for (const std::string& below : command.commands) {
    const auto found =
        std::ranges::find(commands, command.path + " " + below, &DescribedCommand::path);
    page += ".TP\n\\fB" + roff(below) + "\\fR\n" + roff(found->summary) + "\n";
  }
  page += ".SH OPTIONS\n";
  for (const DescribedOption& option : command.options) {
    page += ".TP\n" + tag(option) + "\n" + roff(option.text);
    const bool listed = option.choices.empty() || option.text.ends_with(option.choices.back());
    page += listed ? "\n" : roff("; one of: " + joined(option.choices, ", ")) + "\n";
  }
  page += ".SH NOTES\n" + verbatim(command.footer);
  if (command.path != "taut") page += ".SH SEE ALSO\n\\fBtaut\\fR(1)\n";
  return page;
}

}  // namespace taut::package
