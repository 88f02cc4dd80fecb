
#include "render/package/described.h"

namespace taut::package {
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

}  // namespace taut::package
