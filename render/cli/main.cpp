// The program taut.
#include "render/cli/commands.h"

int main(int argc, char** argv) {
  return taut::program::run_program(argc, argv, taut::cli::kCommands);
}
