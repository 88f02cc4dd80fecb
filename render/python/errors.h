// The exceptions of the module and the errors of taut that become them; Ctrl-C in long work.
#pragma once

#include <pybind11/pybind11.h>
#include <unistd.h>

#include <ctime>
#include <stdexcept>
#include <string>

#include "scenes/files/error.h"
#include "sim/motion/printable.h"

namespace taut::python {

/// A pin, move, release or cut that changed nothing; becomes taut.InterventionError.
class Refused : public std::runtime_error {
 public:
  Refused(const std::string& message, double at)
      : std::runtime_error(printable(message)), time(at) {}
  double time;  // s
};

/// Adds taut.Error and those derived from it.
void add_errors(pybind11::module_& module);

/// An instance of taut.SceneError.
pybind11::object scene_error(const scenes::BadScene& error);

// Ctrl-C in long work that runs without Python's lock.

/// Lets Python handle signals; a handler that raises, as that of Ctrl-C does, ends the work. Only
/// in the process's first thread, which gets Python's signals, and not within `apart` (s) of the
/// last time: then it costs a clock's reading. With or without Python's lock. Throws
/// pybind11::error_already_set.
inline void handle_signals(double apart) {
  thread_local const bool is_first = getpid() == gettid();
  if (!is_first) return;
  timespec read{};
  clock_gettime(CLOCK_MONOTONIC_COARSE, &read);
  const double now = double(read.tv_sec) + 1e-9 * double(read.tv_nsec);
  static double last = now;
  if (now - last < apart) return;
  const pybind11::gil_scoped_acquire lock;
  last = now;
  if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
}

/// Between two pieces of work, after which everything is whole.
inline void look_for_signals() {
  handle_signals(0.02);
}

/// Within a piece that takes long: what it leaves cannot continue.
inline void look_for_signals_within() {
  handle_signals(0.5);
}

/// Throws std::runtime_error where a Turn has it.
inline void refuse_if_taken(bool taken) {
  if (taken) throw std::runtime_error("another thread is using this object");
}

/// Work that one thread does at a time: a second one is refused while the first is without Python's
/// lock.
class Turn {
 public:
  /// With Python's lock. Throws std::runtime_error.
  explicit Turn(bool& taken) : taken_(taken) {
    refuse_if_taken(taken);
    taken = true;
  }
  ~Turn() { taken_ = false; }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  bool& taken_;
};

}  // namespace taut::python
