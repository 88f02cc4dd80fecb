// taut claims: which claims of the paper reproduce, each measured.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "render/base/atomic_file.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/study/bench_results.h"

namespace taut::cli {
namespace claims_command {
namespace {

using enum PaperRole;

struct Options {
  options::StudyOptions study;
  bool markdown = false;
};

enum class Outcome { reproduced, conditional, not_reproduced };

struct Claim {
  std::string words, where;
  Outcome outcome;
  std::string numbers;
};

const char* name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::reproduced:
      return "reproduced";
    case Outcome::conditional:
      return "under conditions";
    case Outcome::not_reproduced:
      return "not reproduced";
  }
  return "";
}

Outcome yes_or_no(bool yes) {
  return yes ? Outcome::reproduced : Outcome::not_reproduced;
}

std::string micro(double seconds) {
  return options::rounded(1e6 * seconds) + " µs";
}

// Experiment 1: cost.
void add_costs(const studies::Evidence& e, std::vector<Claim>& claims) {
  const double frame = e.real_time();
  const double few = e.cost(dynamic_constraints, 0, "dense"),
               many = e.cost(dynamic_constraints, 1, "dense");
  claims.push_back(
      {"Dynamic constraints cannot run in real time", "V, Figure 5",
       few > frame ? Outcome::reproduced
                   : (many > frame ? Outcome::conditional : Outcome::not_reproduced),
       fmt::format(
           "dense solve: {} a frame at {} particles, {} at {}, of {}; the tridiagonal solve "
           "of the same system: {} and {}",
           micro(few), studies::kFew, micro(many), studies::kMany, micro(frame),
           micro(e.cost(dynamic_constraints)), micro(e.cost(dynamic_constraints, 1)))});
  const PaperRole role = e.has(package) ? package : package_of_today;
  claims.push_back(
      {"SD/FAST is slower still", "V, Figure 5",
       role == package ? yes_or_no(e.cost(role) > few) : Outcome::conditional,
       fmt::format("{}{} {} against the dense solve's {}",
                   role == package ? "" : "SD/FAST is not in this build; its successor Simbody, ",
                   find_method(role)->name, micro(e.cost(role)), micro(few))});
  claims.push_back(
      {"Of the existing methods only the particle system runs in real time", "V, Figure 5",
       yes_or_no(few > frame && e.cost(package_of_today) > frame),
       fmt::format("at {} particles dense dynamic constraints {}, multibody {}, springs "
                   "{} a frame, of {}",
                   studies::kFew, micro(few), micro(e.cost(package_of_today)),
                   micro(e.cost(particle_system)), micro(frame))});
  claims.push_back({"The particle system takes the same time in every frame", "V, Figure 5",
                    yes_or_no(e.unevenness(particle_system) < 0.1),
                    fmt::format("quartiles of its frames lie {} of the median apart (impulse: {}, "
                                "multibody: {})",
                                options::percent(e.unevenness(particle_system)),
                                options::percent(e.unevenness(proposed)),
                                options::percent(e.unevenness(package_of_today)))});
  const study::PaperSetting& setting = e.bench.blocks[0].paper.settings.front();
  claims.push_back(
      {fmt::format("The method is {} times as fast as the particle system", study::kPaperRatio),
       "V", Outcome::conditional,
       fmt::format("at default settings {}; {} where impulse takes {} step a frame and springs {} "
                   "of {} N/m, whose error is then {} of the length (impulse: {})",
                   options::rounded(e.cost(particle_system) / e.cost(proposed)),
                   options::rounded(setting.ratio), options::rounded(setting.impulse_steps),
                   options::rounded(setting.substeps), options::rounded(setting.stiffness),
                   options::percent(setting.error), options::percent(setting.impulse_error))});
  std::optional<study::EqualError> coarse, fine;
  for (const study::EqualError& one : e.bench.blocks[0].paper.equal) {
    if (one.method != find_method(particle_system)->name || !(one.cost > 0)) continue;
    if (!coarse || one.error > coarse->error) coarse = one;
    if (!fine || one.error < fine->error) fine = one;
  }
  if (coarse && fine) {
    claims.push_back(
        {"The same, at equal error (not asked in the paper)", "-",
         yes_or_no(coarse->cost > coarse->impulse_cost),
         fmt::format(
             "springs cost {} times as much at an error of {} of the length, {} times at {}, "
             "below which impulse does not come",
             options::rounded(coarse->cost / coarse->impulse_cost), options::percent(coarse->error),
             options::rounded(fine->cost / fine->impulse_cost), options::percent(fine->error))});
  }
  claims.push_back({"Correcting lengths only where they are violated saves time", "IV.B",
                    yes_or_no(e.always > 1.02),
                    fmt::format("correcting all links (h = 0) costs {} times as much as with the "
                                "default h",
                                options::rounded(e.always))});
  claims.push_back({"The method runs in real time", "V, Figure 5",
                    yes_or_no(e.cost(proposed, 1) < frame),
                    fmt::format("{} a frame at {} particles, {} at {}", micro(e.cost(proposed)),
                                studies::kFew, micro(e.cost(proposed, 1)), studies::kMany)});
}

// Experiment 2: accuracy.
void add_accuracy(const studies::Evidence& e, std::vector<Claim>& claims) {
  const auto error = [&](PaperRole one) { return e.errors[e.at(one)]; };
  const auto difference = [&](PaperRole one) {
    return options::percent(e.differences[e.at(one)] / e.length);
  };
  const PaperRole role = e.has(package) ? package : package_of_today;
  const study::PaperSetting& soft = e.bench.blocks[0].paper.settings.front();
  claims.push_back(
      {"Dynamic constraints can serve as the reference", "V, Figure 6",
       yes_or_no(error(dynamic_constraints) < 0.01),
       fmt::format("{} of the length from the converged truth in {} s",
                   options::percent(error(dynamic_constraints)), options::rounded(e.horizon))});
  claims.push_back(
      {"The particle system is the least accurate", "V, Figure 6",
       error(particle_system) > error(proposed) && error(particle_system) > error(role)
           ? Outcome::reproduced
           : (soft.error > soft.impulse_error ? Outcome::conditional : Outcome::not_reproduced),
       fmt::format(
           "springs of the default stiffness {}, impulse {}; springs as soft as the paper's "
           "ratio needs {}",
           options::percent(error(particle_system)), options::percent(error(proposed)),
           options::percent(soft.error))});
  claims.push_back({"The method is more accurate than SD/FAST", "V, Figure 6",
                    yes_or_no(error(proposed) < error(role)),
                    fmt::format("mean difference of segments from dynamic constraints, of the "
                                "length: impulse {}, {} {}, springs {}",
                                difference(proposed), find_method(role)->name, difference(role),
                                difference(particle_system))});
}

/// Section IV.C.
void add_interventions(const studies::Evidence& e, std::vector<Claim>& claims) {
  const auto error = [&](PaperRole role) { return e.pinned[e.at(role)]; };
  claims.push_back({"The method handles a pin by dividing the connector", "IV.C",
                    yes_or_no(error(proposed) < 0.2),
                    fmt::format("with its middle held, {} of the length from truth",
                                options::percent(error(proposed)))});
  claims.push_back({"Other methods cannot be divided, and lose their correctness", "IV.C",
                    yes_or_no(!(error(dynamic_constraints) < error(proposed))),
                    fmt::format("the same pin: dynamic constraints {}, multibody {}, springs {}",
                                options::percent(error(dynamic_constraints)),
                                options::percent(error(package_of_today)),
                                options::percent(error(particle_system)))});
}

std::vector<Claim> claims_of(const studies::Evidence& evidence) {
  std::vector<Claim> claims;
  add_costs(evidence, claims);
  add_accuracy(evidence, claims);
  add_interventions(evidence, claims);
  return claims;
}

chart::Table table_of(const std::vector<Claim>& claims) {
  chart::Table table{{"the paper says", "in", "here", "measured"}, {}};
  for (const Claim& claim : claims) {
    table.add({claim.words, claim.where, name_of(claim.outcome), claim.numbers});
  }
  return table;
}

int run(const Options& options, const program::Common& common) {
  const scenes::Scene scene = options::study_scene(options.study);
  const chart::Table table =
      table_of(claims_of(studies::gather_evidence(options.study, common.quiet)));
  if (common.json) {
    nlohmann::ordered_json json = {{"scene", options.study.scene}, {"machine", options::machine()}};
    for (const auto& row : table.rows) {
      json["claims"].push_back(
          {{"claim", row[0]}, {"where", row[1]}, {"outcome", row[2]}, {"measured", row[3]}});
    }
    render::write_output(program::json_text(json) + "\n");
  } else {
    render::write_output(options.markdown ? chart::to_markdown(table) : program::table_text(table));
  }
  return program::kDone;
}

}  // namespace
}  // namespace claims_command

void add_claims(CLI::App& app, program::Program& program) {
  using namespace claims_command;
  program::Command command =
      program::add_command(app, program, "claims", "Measure which claims of the paper reproduce",
                           R"(  taut claims scenes/rope_swing.toml
  taut claims scenes/rope_swing.toml --markdown)");
  const auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->study.inputs);
  command.add_flag("--markdown", options->markdown, "Print the table as Markdown");
  options->study.budget = 60;
  for (const MethodInfo& method : all_methods()) {
    if (method.paper_role != none) options->study.methods.emplace_back(method.name);
    if (method.paper_role == dynamic_constraints) {
      options->study.methods.push_back(std::string(method.name) + ":dense");
    }
  }
  command.callback([options, &program] {
    program.run = [options, &program] {
      return options::for_each_study(options->study, program.common,
                                     [&](const options::StudyOptions& one) {
                                       Options of_one = *options;
                                       of_one.study = one;
                                       return run(of_one, program.common);
                                     });
    };
  });
}

}  // namespace taut::cli
