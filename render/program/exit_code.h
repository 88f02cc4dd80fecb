// How the program ends. Scripts rely on these numbers.
#pragma once

namespace taut::program {

enum ExitCode : int {
  kDone = 0,
  kGoldenDiffers = 1,
  kUsage = 2,        // also every code of the option parser
  kBadScene = 3,     // or a bad asset
  kNoContext = 4,    // no rendering context
  kEncoder = 5,      // FFmpeg missing or failed
  kCannotWrite = 6,  // an output could not be written
  kDiverged = 7,     // the simulation diverged
  kNoMemory = 8,
  kInternal = 70,  // a defect of taut itself
  kInterrupted = 130,
  kTerminated = 143,
};

}  // namespace taut::program
