// taut verify: scenes whose answers are known, each method's errors beside the tolerances.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/options/method_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/study/answer_costs.h"
#include "render/study/answer_engines.h"
#include "render/study/known_answers.h"

namespace taut::cli {
namespace verify_command {
namespace {

using studies::AnswerCase;
using studies::Verdict;
using studies::Verified;

struct Options {
  std::vector<std::string> cases;
  options::StudyOptions study;  // of its fields only the methods and --set
  std::vector<std::string> engines;
  double cap = 60;  // s of CPU time
  std::string csv, page, chart;
  bool converge = false;
  bool failures = false;
};

/// The methods of --methods, in their order; the truth is a method here.
std::vector<options::Contender> contenders_of(const options::StudyOptions& study) {
  std::vector<options::Contender> all;
  for (const std::string& name : study.methods) {
    if (name == "truth") {
      all.push_back({name, find_method(name), {name, {}}, chart::truth_style()});
      continue;
    }
    options::StudyOptions one;
    one.methods = {name};
    all.push_back(options::chosen_contenders(one).front());
  }
  return all;
}

/// The engines of --engine, whose names differ from each other's and from the methods'.
std::vector<studies::Engine> engines_of(const Options& options,
                                        const std::vector<options::Contender>& contenders) {
  std::vector<studies::Engine> all;
  for (const std::string& text : options.engines) {
    studies::Engine engine = studies::engine_of(text);
    const auto is_taken = [&](const auto& label) { return label == engine.name; };
    if (std::ranges::any_of(contenders, is_taken, &options::Contender::label) ||
        std::ranges::any_of(all, is_taken, &studies::Engine::name)) {
      throw program::Misuse(fmt::format("--engine {}: the name is taken", text));
    }
    all.push_back(std::move(engine));
  }
  return all;
}

void refuse_unknown(const std::vector<std::string>& set,
                    const std::vector<options::Contender>& contenders) {
  for (const std::string& text : set) {
    const bool known = std::ranges::any_of(contenders, [&](const options::Contender& one) {
      return !options::settings_of(*one.method, {text}).empty();
    });
    if (!known)
      throw program::Misuse(fmt::format("--set {}: is no setting of these methods", text));
  }
}

/// A row for each method of each case: the answer whose error is the largest share of its
/// tolerance.
chart::Table worst_answers(const std::vector<Verified>& all, bool only_failures) {
  chart::Table table{
      {"case", "method", "verdict", "worst answer", "t (s)", "error", "tolerance", "CPU (ms)"}, {}};
  for (const Verified& one : all) {
    for (const auto& [method, verdict] : one.verdicts) {
      if (only_failures && !verdict.is_failure()) continue;
      std::vector<std::string> row{one.of.name, method, studies::text_of(verdict.kind)};
      if (verdict.values.empty()) {
        row.insert(row.end(), {verdict.reason, "-", "-", "-", "-"});
      } else {
        const studies::Answer& worst = one.of.answers[verdict.worst];
        row.insert(row.end(),
                   {worst.quantity, options::rounded(worst.time),
                    options::rounded(verdict.share * worst.tolerance),
                    options::rounded(worst.tolerance), options::rounded(1e3 * verdict.cpu)});
      }
      table.add(std::move(row));
    }
  }
  return table;
}

/// A row for each answer of each method.
chart::Table every_answer(const std::vector<Verified>& all) {
  chart::Table table{
      {"case", "method", "t", "quantity", "answer", "tolerance", "value", "error", "cpu_s"}, {}};
  const auto exact = [](double value) { return fmt::format("{:.17g}", value); };
  for (const Verified& one : all) {
    for (const auto& [method, verdict] : one.verdicts) {
      for (std::size_t i = 0; i < verdict.values.size(); ++i) {
        const studies::Answer& answer = one.of.answers[i];
        table.add({one.of.name, method, exact(answer.time), answer.quantity, exact(answer.value),
                   exact(answer.tolerance), exact(verdict.values[i]),
                   exact(verdict.values[i] - answer.value), exact(verdict.cpu)});
      }
    }
  }
  return table;
}

program::Json json_of(const Verified& one) {
  program::Json json = {{"case", one.of.name},
                        {"scene", one.of.scene.file.string()},
                        {"title", one.of.scene.title},
                        {"answers", one.of.answers.size()}};
  for (const auto& [method, verdict] : one.verdicts) {
    program::Json entry = {{"method", method},
                           {"verdict", studies::text_of(verdict.kind)},
                           {"reason", verdict.reason.empty() ? program::Json(nullptr)
                                                             : program::Json(verdict.reason)}};
    if (!verdict.values.empty()) {
      const studies::Answer& worst = one.of.answers[verdict.worst];
      entry["worst"] = {{"quantity", worst.quantity},
                        {"t", worst.time},
                        {"answer", worst.value},
                        {"value", program::number_or_null(verdict.values[verdict.worst])},
                        {"tolerance", worst.tolerance},
                        {"share_of_tolerance", program::number_or_null(verdict.share)}};
    } else {
      entry["worst"] = nullptr;
    }
    entry["cpu_s"] = verdict.cpu;
    if (!verdict.runs.empty()) studies::add_costs(entry, one.of, verdict);
    json["methods"].push_back(std::move(entry));
  }
  return json;
}

void write(const std::string& file, const std::string& text) {
  render::AtomicFile out(file);
  out.write(text);
  out.commit();
}

int run(const Options& options, const program::Common& common) {
  if (!options.chart.empty() && !options.converge)
    throw program::Misuse("--chart needs --converge, whose costs it shows");
  options::StudyOptions study = options.study;
  if (study.methods.empty() && options.engines.empty()) study.methods = {"direct"};
  const std::vector<options::Contender> contenders = contenders_of(study);
  const std::vector<studies::Engine> engines = engines_of(options, contenders);
  if (!options.chart.empty()) chart::require_gnuplot();
  refuse_unknown(options.study.inputs.set, contenders);
  std::vector<std::filesystem::path> paths(options.cases.begin(), options.cases.end());
  if (paths.empty()) paths.emplace_back("tests/answers");
  const std::vector<std::filesystem::path> folders = studies::answer_folders(paths);
  std::vector<Verified> all;
  std::size_t failures = 0, passes = 0, not_run = 0;
  {
    program::Progress progress("verifying", "cases", folders.size(), common.quiet);
    for (const std::filesystem::path& folder : folders) {
      render::stop_if_interrupted();
      Verified one{studies::read_answer_case(folder), {}};
      const auto add = [&](const std::string& name, Verdict verdict) {
        failures += verdict.is_failure();
        passes += verdict.kind == Verdict::Kind::passes;
        not_run += verdict.kind == Verdict::Kind::not_followed;
        one.verdicts.emplace_back(name, std::move(verdict));
      };
      for (const options::Contender& contender : contenders) {
        const std::vector<std::string>& set = options.study.inputs.set;
        add(contender.label, options.converge
                                 ? studies::refined(one.of, contender, set, options.cap)
                                 : studies::verify(one.of, contender, set, options.cap));
      }
      for (const studies::Engine& engine : engines)
        add(engine.name, studies::refined(one.of, engine, options.cap));
      all.push_back(std::move(one));
      progress.update(all.size());
    }
  }
  if (!options.csv.empty()) write(options.csv, chart::to_csv(every_answer(all)));
  if (!options.page.empty()) write(options.page, studies::answers_page(all));
  if (!options.chart.empty()) {
    std::vector<chart::Style> styles;
    for (const options::Contender& contender : contenders) styles.push_back(contender.style);
    for (std::size_t i = 0; i < engines.size(); ++i)
      styles.push_back(chart::method_style(contenders.size() + i));
    chart::write_chart(studies::costs_chart(all, styles), options.chart);
  }
  if (common.json) {
    program::Json json = {{"passes", passes},
                          {"failures", failures},
                          {"not_run", not_run},
                          {"cases", program::Json::array()}};
    for (const Verified& one : all) json["cases"].push_back(json_of(one));
    render::write_output(program::json_text(json) + "\n");
  } else {
    const chart::Table table =
        options.converge ? studies::costs_table(all) : worst_answers(all, options.failures);
    if (!table.rows.empty()) render::write_output(program::table_text(table));
    render::write_output(fmt::format("{} pass, {} fail, {} not run\n", passes, failures, not_run));
  }
  return failures == 0 ? program::kDone : program::kDiffers;
}

}  // namespace
}  // namespace verify_command

void add_verify(CLI::App& app, program::Program& program) {
  using namespace verify_command;
  program::Command command = program::add_command(app, program, "verify",
                                                  "Compare scenes with their known answers",
                                                  R"(  taut verify
  taut verify tests/answers/pendulum tests/answers/capstan
  taut verify --methods direct,truth,xpbd
  taut verify --methods direct --set tolerance=1e-6 --page verify.html --csv verify.csv
  taut verify --methods direct,springs --converge --cap 1 --chart costs
  taut verify --methods direct --engine 'ode=tests/answers/engines/rigid_adapter.py ode' --cap 2

A case is a folder with scene.toml and answer.csv: rows of time,quantity,value,tolerance, from
theory. A method passes if every error is within its tolerance. Exit code 1: a method fails.
CASE is such a folder, or a folder of cases; default: tests/answers. Methods that do not support a
feature of the scene are not run.

--converge runs each method at finer and finer steps, and at finer and finer tolerances if it has
one: until it passes, gets no better, or reaches --cap. It tells the order in the step, and the CPU
time for errors of places of a tenth, a hundredth and a thousandth of the length.

)" + std::string(studies::kEngineHelp) + "\n\n" + std::string(studies::kQuantitiesHelp));
  const auto options = std::make_shared<Options>();
  command.add_option("CASE", options->cases, "Folders of cases");
  command
      .add_option("--methods", options->study.methods,
                  "Methods to verify, METHOD or METHOD:FORM, separated by commas; default: direct, "
                  "or none with --engine")
      .delimiter(',');
  command
      .add_option("--engine", options->engines,
                  "Another program to verify, see above; may be repeated")
      .one_value_each()
      .type_name("NAME=COMMAND");
  command.add_flag("--converge", options->converge,
                   "Refine the steps of each method: its order, and what errors cost");
  command
      .add_option("--set", options->study.inputs.set,
                  "Override a setting of the methods, as in tolerance=1e-6; may be repeated")
      .one_value_each()
      .type_name("KEY=VALUE");
  command
      .add_option(
          "--cap", options->cap,
          "CPU time limit of a run, s; with --converge and --engine of all runs of a method "
          "on a case; default: 60")
      .positive();
  command.add_flag("--failures", options->failures, "Print only failures in the table");
  command.add_option("--csv", options->csv, "CSV file for all answers and values");
  command.add_option("--page", options->page,
                     "Self-contained HTML file for all answers, with drawings");
  command.add_option("--chart", options->chart,
                     "With --converge: chart of CPU time against error, as FILE.svg and FILE.png");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
