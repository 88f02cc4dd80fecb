#include "render/clip/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/measure/measure.h"
#include "sim/world/held.h"

namespace taut::clips {
namespace {

using Grade = film::Verdict::Grade;

constexpr double kBroken = 10;  // times film::kKept

std::string percent(double share) {
  const double value = 100 * share;
  if (value < 9.95) return fmt::format("{:.2g}%", value);
  return value < 1e5 ? fmt::format("{:.0f}%", value) : fmt::format("{:.0e}%", value);
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 < parts.size() ? ", " : " and ") + parts[i];
  return text;
}

bool is_held(const World& world) {
  return std::ranges::any_of(world.bodies, &Body::driven) ||
         std::ranges::any_of(world.connectors, [&](const Connector& connector) {
           return std::ranges::any_of(
               connector.holds, [&](const Hold& hold) { return is_prescribed(world, hold.to); });
         });
}

Grade grade_of(double times_kept) {
  return times_kept <= 1 ? Grade::kept : times_kept <= kBroken ? Grade::off : Grade::broken;
}

/// The verdict on a run that ended early.
film::Verdict stopped(const study::Run& run) {
  film::Verdict verdict{.grade = Grade::broken};
  if (run.frames.empty()) {
    verdict.text = "does not run";
  } else {
    verdict.text = fmt::format("stops after {:.2g} s", run.reached);
    verdict.worst = run.frames.size() - 1;
  }
  return verdict;
}

}  // namespace

Laws laws_of(const World& world, const Timeline& timeline) {
  Laws laws;
  if (is_closed(world) && timeline.empty()) laws.energy = std::max(energy_scale(world), 0.0);
  laws.loses = has_contact(world) || has_strings(world) ||
               std::ranges::any_of(world.connectors, [](const Connector& connector) {
                 return connector.model == ConnectorModel::span;
               });
  if (laws.energy > 0 && !has_contact(world) && !is_held(world))
    laws.momentum = std::sqrt(2 * laws.energy * moving_mass(world));
  laws.length = std::ranges::none_of(world.connectors, &Connector::stretches);
  return laws;
}

std::string words_of(const Laws& laws) {
  std::vector<std::string> kept;
  if (laws.energy > 0 && !laws.loses) kept.push_back("energy");
  if (laws.length) kept.push_back("length");
  if (laws.momentum > 0) kept.push_back("momentum");
  std::vector<std::string> words;
  if (laws.energy > 0 && laws.loses) words.push_back("gains no energy");
  if (!kept.empty()) words.push_back("keeps " + joined(kept));
  return joined(words);
}

film::Verdict by_laws(const study::Run& run, const Laws& laws) {
  if (run.end != study::Run::End::done) return stopped(run);
  film::Verdict verdict;
  double worst = -1, gain = 0, loss = 0, stretch = 0, momentum = 0;
  for (std::size_t k = 0; k < run.frames.size(); ++k) {
    const double energy = laws.energy > 0 ? run.energy[k] / laws.energy : 0;
    const double gained = std::max(energy, 0.0), lost = laws.loses ? 0 : std::max(-energy, 0.0);
    const double longer = laws.length ? run.stretch[k] : 0;
    const double pushed = laws.momentum > 0 ? run.momentum[k] / laws.momentum : 0;
    gain = std::max(gain, gained);
    loss = std::max(loss, lost);
    stretch = std::max(stretch, longer);
    momentum = std::max(momentum, pushed);
    if (const double off = std::max({gained, lost, longer, pushed}); off > worst) {
      worst = off;
      verdict.worst = k;
    }
  }
  const std::string kept = words_of(laws);
  if (kept.empty()) {
    verdict.text = "no law to judge it by";
    return verdict;
  }
  verdict.grade = grade_of(worst / film::kKept);
  std::vector<std::string> broken;
  if (gain > film::kKept && gain >= loss)
    broken.push_back(fmt::format("gains {} energy", percent(gain)));
  else if (loss > film::kKept)
    broken.push_back(fmt::format("loses {} energy", percent(loss)));
  if (stretch > film::kKept) broken.push_back(fmt::format("stretches by {}", percent(stretch)));
  if (momentum > film::kKept) broken.push_back(fmt::format("gains {} momentum", percent(momentum)));
  verdict.text = broken.empty() ? kept : joined(broken);
  return verdict;
}

film::Verdict by_truth(const study::Run& run, const std::vector<double>& distances, double length) {
  if (run.end != study::Run::End::done) return stopped(run);
  film::Verdict verdict;
  const auto worst = std::ranges::max_element(distances);
  const double most = worst == distances.end() ? 0 : *worst;
  verdict.worst = std::size_t(worst - distances.begin());
  verdict.grade = grade_of(most / (film::kKept * length));
  const double mm = 1e3 * most;
  std::string size = fmt::format("{:.0f} mm", mm);
  if (verdict.grade == Grade::kept) {  // "within" is rounded up, to one digit
    const double digit = std::pow(10, std::floor(std::log10(std::max(mm, 1e-4))));
    size = fmt::format("{:g} mm", std::max(std::ceil(mm / digit - 1e-9) * digit, 1e-3));
  } else if (mm < 9.95) {
    size = fmt::format("{:.2g} mm", mm);
  } else if (mm >= 1e3) {
    size = fmt::format("{:.3g} m", most);
  }
  verdict.text = verdict.grade == Grade::kept ? fmt::format("within {} of the truth", size)
                                              : fmt::format("{} from the truth", size);
  return verdict;
}

std::string duration_text(double seconds) {
  const auto two = [](double value) {
    return value < 9.95 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value);
  };
  if (seconds < 0.995e-5) return two(1e6 * seconds) + " µs";
  if (seconds < 0.9995) return two(1e3 * seconds) + " ms";
  return two(seconds) + " s";
}

std::vector<std::string> result_of(const film::Comparison& comparison) {
  std::vector<const film::ComparedMethod*> order;
  for (const film::ComparedMethod& method : comparison.methods) order.push_back(&method);
  const auto rank = [](const film::ComparedMethod* method) {
    const Grade grade = method->verdict.grade;
    return grade == Grade::kept ? 0 : grade == Grade::none ? 1 : grade == Grade::off ? 2 : 3;
  };
  std::ranges::stable_sort(order, [&](const auto* a, const auto* b) {
    return rank(a) != rank(b) ? rank(a) < rank(b) : rank(a) < 2 && a->cpu_us < b->cpu_us;
  });
  std::vector<std::string> clauses;
  for (const film::ComparedMethod* method : order) {
    const Grade grade = method->verdict.grade;
    const bool plain = comparison.by_truth && !method->verdict.text.starts_with("stops") &&
                       !method->verdict.text.starts_with("does");
    std::string clause = method->label +
                         (plain                  ? " is "
                          : grade == Grade::none ? ": "
                                                 : " ") +
                         method->verdict.text;
    if (std::isfinite(method->cpu_us))
      clause +=
          fmt::format(", for {} a second", duration_text(1e-6 * method->cpu_us * comparison.fps));
    clauses.push_back(std::move(clause));
  }
  return clauses;
}

}  // namespace taut::clips
