#include "render/program/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <new>

#include "render/base/interrupt.h"
#include "render/program/note.h"

namespace taut::program {

namespace {

constexpr std::chrono::milliseconds kLive{100};
constexpr std::chrono::seconds kPlain{10};

std::string& left_off_text() {
  static std::string text;
  return text;
}

}  // namespace

Progress::Progress(std::string what, std::string unit, std::uint64_t total, bool quiet)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      total_(total),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      last_(start_) {}

Progress::~Progress() {
  std::string& text = left_off_text();
  if (render::pending_interrupt() && text.empty() && std::uncaught_exceptions() > exceptions_) try {
      text = unit_ == "%" ? fmt::format("{}: {}%", what_, done_)
                          : fmt::format("{}: {} of {} {}", what_, done_, total_, unit_);
    } catch (const std::bad_alloc&) {
      text.clear();  // that it was interrupted is told in any case
    }
  if (terminal_ && shown_) note("\r\033[K");
}

const std::string& left_off() {
  return left_off_text();
}

void Progress::update(std::uint64_t done) {
  done_ = done;
  if (quiet_) return;
  const auto now = Clock::now();
  if (now - last_ < (terminal_ ? Clock::duration(kLive) : Clock::duration(kPlain))) return;
  last_ = now;
  shown_ = true;
  const double spent = std::chrono::duration<double>(now - start_).count();
  const double left =
      done > 0 ? spent * static_cast<double>(total_ - done) / static_cast<double>(done) : NAN;
  const std::string line =
      fmt::format("{} {}/{} {}, {:.0f}%{}", what_, done, total_, unit_,
                  100.0 * static_cast<double>(done) / static_cast<double>(total_),
                  done > 0 ? ", " + clock_text(left) + " left" : "");
  if (terminal_) {
    note("\r{}\033[K", line);
  } else {
    note("{}\n", line);
  }
  std::fflush(stderr);
}

std::string clock_text(double seconds) {
  const long whole = std::lround(seconds);
  return whole < 3600 ? fmt::format("{}:{:02}", whole / 60, whole % 60)
                      : fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace taut::program
