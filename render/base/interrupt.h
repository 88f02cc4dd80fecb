// Stopping on Ctrl-C and SIGTERM: the handlers only leave a note, which long work looks at between
// two pieces, so that destructors run and nothing half-written stays behind.
#pragma once

#include <exception>

namespace taut::render {

/// Thrown by stop_if_interrupted; what() names the signal.
class Interrupted : public std::exception {
 public:
  explicit Interrupted(int number) : signal(number) {}
  const char* what() const noexcept override;
  int signal;  // SIGINT or SIGTERM
};

/// Notes SIGINT and SIGTERM from now on; a second one of the same kind ends the process at once.
/// SIGPIPE and SIGXFSZ are ignored, so that writing reports EPIPE and EFBIG instead.
void catch_interrupts();

/// The signal that came, or 0.
int pending_interrupt();

/// Throws Interrupted if a signal came. Cheap: one atomic read.
void stop_if_interrupted();

}  // namespace taut::render
