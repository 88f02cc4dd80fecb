#include "render/study/answer_engines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <limits>
#include <sstream>
#include <system_error>

#include "render/base/child.h"
#include "render/program/command.h"
#include "sim/motion/printable.h"

namespace taut::studies {

const std::string_view kEngineHelp =
    "An engine is a program that taut runs as COMMAND SCENE STEP: the file scene.toml, and a time "
    "step\n"
    "in seconds. It reads rows of time,quantity from its standard input, and prints the same rows "
    "with\n"
    "the values: time,quantity,value. A line cpu_s,SECONDS tells the CPU time of stepping; without "
    "it,\n"
    "that of the process counts. A line \"cannot express: REASON\" in place of the rows: the case "
    "is not\n"
    "run. The step is halved until the engine passes, gets no better, or reaches --cap.";

namespace {

constexpr std::string_view kEngineAsked = "time,quantity", kEngineColumns = "time,quantity,value",
                           kEngineRefusal = "cannot express: ", kEngineCpu = "cpu_s,";
constexpr std::size_t kMostOutput = 16 << 20;  // bytes

std::string rows_asked_for(const AnswerCase& of) {
  std::string rows(kEngineAsked);
  rows += '\n';
  for (const Answer& answer : of.answers) {
    rows += fmt::format("{:.17g},{}\n", answer.time, answer.quantity);
  }
  return rows;
}

Verdict broken(const std::string& why) {
  Verdict verdict;
  verdict.kind = Verdict::Kind::broken;
  verdict.reason = printable(why);
  return verdict;
}

/// The last line of a text that says anything.
std::string last_line(const std::string& text) {
  std::istringstream lines(text);
  std::string last;
  for (std::string line; std::getline(lines, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  constexpr std::size_t kMost = 200;
  return last.substr(0, kMost);
}

/// What an engine printed, beside the answers.
Verdict read_values(const AnswerCase& of, const std::string& output, double cpu) {
  Verdict verdict;
  verdict.cpu = cpu;
  std::istringstream lines(output);
  std::size_t number = 0;
  bool has_header = false;
  for (std::string text; std::getline(lines, text);) {
    ++number;
    std::string_view line = text;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty() || line.starts_with('#')) continue;
    const auto wrong = [&](const std::string& expected) {
      return broken(fmt::format("output, line {}: \"{}\", expected {}", number, line.substr(0, 80),
                                expected));
    };
    if (line.starts_with(kEngineRefusal)) {
      Verdict refused;
      refused.kind = Verdict::Kind::not_followed;
      refused.reason = printable(line.substr(0, 200));
      return refused;
    }
    if (line.starts_with(kEngineCpu)) {
      const auto seconds = finite_number(line.substr(kEngineCpu.size()));
      if (!seconds || *seconds < 0) return wrong("cpu_s and a number of seconds");
      verdict.cpu = *seconds;
      continue;
    }
    if (!has_header) {
      if (line != kEngineColumns) return wrong(fmt::format("the columns {}", kEngineColumns));
      has_header = true;
      continue;
    }
    if (verdict.values.size() == of.answers.size()) return wrong("no more rows");
    const Answer& answer = of.answers[verdict.values.size()];
    const std::vector<std::string_view> cells = row_cells(line);
    const auto time = finite_number(cells[0]);
    constexpr double kRounding = 1e-9;
    if (cells.size() != 3 || !time ||
        !(std::abs(*time - answer.time) <= kRounding * (1 + answer.time)) ||
        cells[1] != answer.quantity) {
      return wrong(fmt::format("{:.17g},{},VALUE", answer.time, answer.quantity));
    }
    const std::string_view value = cells[2];
    const bool is_none = value == "nan" || value == "inf" || value == "-inf";
    if (!is_none && !finite_number(value)) return wrong("a number");
    judge(verdict, of, is_none ? std::numeric_limits<double>::quiet_NaN() : *finite_number(value));
  }
  if (verdict.values.size() < of.answers.size()) {
    return broken(
        fmt::format("output: {} rows, expected {}", verdict.values.size(), of.answers.size()));
  }
  return verdict;
}

}  // namespace

Engine engine_of(const std::string& text) {
  const std::size_t equals = text.find('=');
  Engine engine{text.substr(0, equals), {}};
  if (equals != std::string::npos) {
    std::istringstream words(text.substr(equals + 1));
    for (std::string word; words >> word;) engine.command.push_back(word);
  }
  const bool is_name = std::ranges::all_of(engine.name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '.';
  });
  if (engine.name.empty() || !is_name || engine.command.empty()) {
    throw program::Misuse(fmt::format(
        "--engine {}: expected NAME=COMMAND, the name of letters, digits and -_.", text));
  }
  return engine;
}

Verdict verify(const AnswerCase& of, const Engine& engine, double step, double cpu_cap) {
  std::vector<std::string> words = engine.command;
  words.push_back(std::filesystem::absolute(of.folder / "scene.toml").string());
  words.push_back(fmt::format("{:.17g}", step));
  render::ChildLimits limits;
  limits.cpu_time = static_cast<std::size_t>(std::ceil(std::min(cpu_cap, 1e6)));
  limits.output = kMostOutput;
  render::ChildResult result;
  try {
    result = render::run_child(words, rows_asked_for(of), limits);
  } catch (const std::system_error& error) {
    throw program::Misuse(fmt::format("--engine {}: {}", engine.name, error.what()));
  }
  Verdict verdict;
  const bool by_time = result.status == 128 + SIGXCPU;
  if (by_time || (result.status == 128 + SIGKILL && result.cpu_time >= double(limits.cpu_time))) {
    verdict.kind = Verdict::Kind::over_cap;
    verdict.reason = "more CPU time than --cap";
    verdict.cpu = result.cpu_time;
  } else if (result.status == 128 + SIGXFSZ) {
    verdict = broken(fmt::format("output: more than {} MiB", kMostOutput >> 20));
  } else if (result.status != 0) {
    const std::string told = last_line(result.errors);
    verdict =
        broken(fmt::format("exit code {}{}{}", result.status, told.empty() ? "" : ": ", told));
  } else {
    verdict = read_values(of, result.output, result.cpu_time);
  }
  return verdict;
}

}  // namespace taut::studies
