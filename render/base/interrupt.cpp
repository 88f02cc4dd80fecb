#include "render/base/interrupt.h"

#include <csignal>

namespace taut::render {

namespace {

volatile std::sig_atomic_t pending = 0;

void note(int number) {
  pending = number;
}

}  // namespace

const char* Interrupted::what() const noexcept {
  return signal == SIGINT ? "interrupted" : "terminated";
}

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = note;
  // The default action returns after the first signal, so that a second one always ends the run.
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

int pending_interrupt() {
  return pending;
}

void stop_if_interrupted() {
  if (pending) throw Interrupted(pending);
}

}  // namespace taut::render
