// The program taut.
#include <malloc.h>

#include "render/cli/commands.h"

int main(int argc, char** argv) {
#ifdef M_ARENA_MAX
  mallopt(M_ARENA_MAX, 1);  // what one thread frees the others can have: threads allocate little
#endif
  return taut::program::run_program(argc, argv, taut::cli::kCommands);
}
