// Whether this machine can forbid calls of the system.
#pragma once

#include <sys/socket.h>

#include "scenes/model/sandbox.h"

namespace taut {

/// Whether the kernel takes filters; a container may forbid them.
inline bool has_filters() {
  const scenes::SandboxLimits limits{1u << 30, 1u << 20, 10, 10};
  const auto connect = [] {
    return std::string(1, socket(AF_INET, SOCK_STREAM, 0) < 0 ? 'n' : 'y');
  };
  return scenes::run_in_sandbox(limits, connect).end == scenes::SandboxResult::End::forbidden;
}

}  // namespace taut
