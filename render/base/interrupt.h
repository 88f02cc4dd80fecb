// Stopping on Ctrl-C and SIGTERM: the handlers leave a note, which long work looks at between two
// pieces, so that destructors run. Where the work does not look in time, the process ends without
// them, and leaves nothing half-written either.
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

/// Notes SIGINT and SIGTERM from now on. The process ends 0.7 s after the first of them, or at a
/// second one that comes a tenth of a second or more after it, with the code 128 + its number and
/// without what remove_leftovers() removes. SIGPIPE and SIGXFSZ are ignored, so that writing
/// reports EPIPE and EFBIG instead.
void catch_interrupts();

/// The signal that came, or 0.
int pending_interrupt();

/// Throws Interrupted if a signal came. Cheap: one atomic read.
void stop_if_interrupted();

}  // namespace taut::render
