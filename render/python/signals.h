// Ctrl-C in long work that runs without Python's lock.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <stdexcept>

namespace taut::python {

/// Lets Python handle signals between two pieces of work; a handler that raises, as that of Ctrl-C
/// does, ends the work. A look within a fiftieth of a second of the last costs a clock's reading.
class Signals {
 public:
  /// Without Python's lock. Throws pybind11::error_already_set.
  void look() {
    const auto now = Clock::now();
    if (now - last_ < std::chrono::milliseconds(20)) return;
    const pybind11::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
    last_ = Clock::now();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

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
