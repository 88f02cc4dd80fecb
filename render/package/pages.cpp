#include "render/package/pages.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "render/cli/commands.h"
#include "render/program/command.h"
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

namespace {

std::string named(const std::string& dashes, const std::string& name) {
  return name.empty() ? "" : dashes + name;
}

/// The option's spellings: -q --quiet.
std::vector<std::string> spellings(const DescribedOption& option) {
  std::vector<std::string> words;
  if (!option.shorts.empty()) words.push_back("-" + option.shorts);
  if (!option.longs.empty()) words.push_back("--" + option.longs);
  return words;
}

std::string identifier(const std::string& path) {
  return "_" + replaced(replaced(path, " ", "_"), "-", "_");
}

/// In single quotes of a shell.
std::string quoted(const std::string& text) {
  return "'" + replaced(text, "'", "'\\''") + "'";
}

/// A description within an argument of zsh's _arguments.
std::string zsh_text(const std::string& text) {
  std::string out = replaced(text, "\\", "\\\\");
  for (const char* sign : {"[", "]", ":"}) out = replaced(out, sign, std::string("\\") + sign);
  return out;
}

std::string zsh_value(const DescribedOption& option) {
  if (option.value.empty()) return "";
  const std::string what =
      option.choices.empty() ? "_files" : "(" + joined(option.choices, " ") + ")";
  return ":" + zsh_text(option.value) + ":" + what;
}

}  // namespace

std::string bash_completion(const std::vector<DescribedCommand>& commands) {
  std::string paths, values, words;
  for (const DescribedCommand& command : commands) {
    if (command.path != "taut") {
      paths += (paths.empty() ? "" : " | ") + std::string("\"") + command.path + "\"";
    }
    std::vector<std::string> all = command.commands;
    for (const DescribedOption& option : command.options) {
      for (const std::string& spelling : spellings(option)) {
        all.push_back(spelling);
        if (option.value.empty()) continue;
        values += "    \"" + command.path + " " + spelling + "\") words=\"" +
                  joined(option.choices, " ") + "\" ;;\n";
      }
    }
    words += "        \"" + command.path + "\") words=\"" + joined(all, " ") + "\" ;;\n";
  }
  return R"(# Completion of taut for bash, written from its own list of commands and options.
_taut() {
  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
  local path=taut word words=
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    case "$path $word" in
      )" +
         paths + R"() path="$path $word" ;;
    esac
  done
  case "$path $before" in
)" + values +
         R"(    *)
      case "$path" in
)" + words +
         R"(      esac ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  if [[ ${COMPREPLY[0]} == *= ]]; then compopt -o nospace 2> /dev/null; fi
}
complete -o default -F _taut taut
)";
}

std::string zsh_completion(const std::vector<DescribedCommand>& commands) {
  std::string text =
      "#compdef taut\n# Completion of taut for zsh, written from its own list of commands and "
      "options.\n";
  for (const DescribedCommand& command : commands) {
    text += "\n" + identifier(command.path) + "() {\n  _arguments -C \\\n";
    for (const DescribedOption& option : command.options) {
      for (const std::string& spelling : spellings(option)) {
        text += "    " + quoted(spelling + "[" + zsh_text(option.text) + "]" + zsh_value(option)) +
                " \\\n";
      }
    }
    if (command.commands.empty()) {
      text += "    '*:file:_files'\n}\n";
      continue;
    }
    text += "    '1:command:(" + joined(command.commands, " ") + ")' '*::argument:->below'\n";
    text += "  case \"$state $line[1]\" in\n";
    for (const std::string& below : command.commands) {
      text += "    \"below " + below + "\") " + identifier(command.path + " " + below) + " ;;\n";
    }
    text += "  esac\n}\n";
  }
  return text + "\n_taut \"$@\"\n";
}

std::string fish_completion(const std::vector<DescribedCommand>& commands) {
  std::string text =
      "# Completion of taut for fish, written from its own list of commands and options.\n";
  const auto line = [&](const std::string& condition, const std::string& rest,
                        const std::string& what) {
    text += "complete -c taut -n " + quoted(condition) + rest + " -d " + quoted(what) + "\n";
  };
  for (const DescribedCommand& command : commands) {
    std::string condition = "__fish_use_subcommand";
    if (command.path != "taut") {  // "taut golden check": both words were seen
      condition = "__fish_seen_subcommand_from " +
                  replaced(command.path.substr(5), " ", "; and __fish_seen_subcommand_from ");
    }
    for (const std::string& below : command.commands) {
      std::string summary;
      for (const DescribedCommand& other : commands) {
        if (other.path == command.path + " " + below) summary = other.summary;
      }
      line(condition, " -a " + below, summary);
    }
    for (const DescribedOption& option : command.options) {
      if (option.is_positional()) continue;
      std::string rest = named(" -s ", option.shorts) + named(" -l ", option.longs);
      if (!option.value.empty()) rest += " -r";
      if (!option.choices.empty()) rest += " -f -a " + quoted(joined(option.choices, " "));
      line(condition, rest, option.text);
    }
  }
  return text;
}

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

int main(int argc, char** argv) {
  using namespace taut;
  if (argc != 2) {
    std::fputs("usage: taut_pages FOLDER\n", stderr);
    return 2;
  }
  CLI::App app;
  program::Program program;
  program::describe_program(app, program, cli::kCommands);
  const auto commands = package::described(app);
  const std::filesystem::path folder = argv[1];
  bool good = true;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::filesystem::create_directories((folder / name).parent_path());
    std::ofstream out(folder / name);
    out << text;
    out.close();
    good = good && out;
  };
  for (const auto& command : commands) {
    write("man1/" + package::replaced(command.path, " ", "-") + ".1",
          package::manual_page(command, commands));
  }
  write("bash/taut", package::bash_completion(commands));
  write("zsh/_taut", package::zsh_completion(commands));
  write("fish/taut.fish", package::fish_completion(commands));
  if (!good) std::fprintf(stderr, "%s: cannot be written\n", argv[1]);
  return good ? 0 : 6;
}
