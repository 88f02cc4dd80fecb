#include "render/program/output.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <new>
#include <string_view>

#include "render/base/interrupt.h"
#include "sim/motion/printable.h"

namespace taut::program {

void write_text(std::string_view text) {
  render::write_output(printable_lines(text));
}

bool to_standard_output(const std::string& name) {
  return name == "-" || render::is_standard_output(name);
}

Output::Output(const std::string& name) {
  if (!to_standard_output(name)) file_.emplace(name);
}

void Output::write(std::string_view bytes) {
  if (file_) {
    file_->write(bytes);
  } else {
    render::write_output(bytes);
  }
  written_ += bytes.size();
}

void Output::finish() {
  if (file_) file_->commit();
}

namespace {

/// The value of a variable; empty where there is none.
std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::size_t output_width() {
  const std::string_view columns = environment("COLUMNS");
  std::size_t width = 0;
  std::from_chars(columns.data(), columns.data() + columns.size(), width);
  if (width > 0) return width;
  winsize size{};
  if (isatty(STDOUT_FILENO) && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) {
    return size.ws_col;
  }
  return std::numeric_limits<std::size_t>::max();
}

}  // namespace

bool is_colored(int stream) {
  if (!environment("NO_COLOR").empty()) return false;
  const std::string_view force = environment("CLICOLOR_FORCE");
  if (!force.empty() && force != "0") return true;
  return isatty(stream) && environment("TERM") != "dumb";
}

std::string table_text(const chart::Table& table) {
  const std::string text = chart::to_text(table, output_width());
  if (!is_colored(STDOUT_FILENO)) return text;
  // The first line of the table, or of each of its paragraphs.
  std::string colored;
  bool first = true;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    colored += first && !line.empty() ? "\033[1m" + line + "\033[0m\n" : line + "\n";
    first = line.empty();
    begin = end + 1;
  }
  return colored;
}

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
