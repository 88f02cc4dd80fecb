// Writes taut's manual pages and its completion for shells from its own list of commands and
// options.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "render/cli/commands.h"
#include "render/package/described.h"

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
