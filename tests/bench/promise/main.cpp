// taut_promise: the errors that a method delivers, over those it was asked for, on drawn scenes.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include "tests/bench/promise/schemes.h"
#include "tests/bench/promise/table.h"

namespace taut::promise {
namespace {

struct Options {
  unsigned scenes = 210, first = 0;
  std::string kind;
  std::vector<double> tolerances = {1e-1, 3e-2, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
  std::string cache = (std::filesystem::temp_directory_path() / "truth-cache").string();
  unsigned threads = 1;
  std::string method = "direct";
  std::vector<std::string> set;
  std::string csv, schemes;
  std::size_t worst = 0;
  double asked = 1;
  double cap = 60;  // s
  bool cached = false, references = false, estimate = false;
};

Setting parsed(const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end != text.c_str() && *end == '\0') return value;
  return text;
}

MethodChoice candidate(const Options& options) {
  MethodChoice result{options.method, {}};
  for (const std::string& pair : options.set) {
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos) throw std::invalid_argument(pair + ": not name=value");
    result.settings[pair.substr(0, equals)] = parsed(pair.substr(equals + 1));
  }
  Settings all = result.settings;
  all["tolerance"] = 1e-3;
  make_method(result.name, all);  // throws what is wrong with them
  return result;
}

std::vector<unsigned> seeds(const Options& options) {
  std::vector<unsigned> result;
  for (unsigned seed = options.first; result.size() < options.scenes; ++seed) {
    if (options.kind.empty() || kKinds[seed % kKinds.size()] == options.kind) {
      result.push_back(seed);
    }
  }
  return result;
}

struct Results {
  std::vector<Score> scores;
  unsigned brief = 0, over_cap = 0, failed = 0, missing = 0;
  double truth = 0;  // s of CPU time
};

/// Adds what came of one scene.
class Work {
 public:
  Work(const Options& options, MethodChoice candidate)
      : options_(options), candidate_(std::move(candidate)), cache_(options.cache) {}

  void go(unsigned seed) {
    const Drawn drawn = draw(seed);
    std::optional<Reference> reference = cache_.find(drawn);
    double spent = 0;
    if (!reference && !options_.cached) {
      reference = make_reference(drawn, options_.cap);
      spent = reference->cpu;
      cache_.keep(drawn, *reference);
    }
    std::vector<Score> scores;
    const bool usable = reference && reference->usable();
    for (const double tolerance : options_.tolerances) {
      if (!usable || options_.references) break;
      scores.push_back(
          score(drawn, *reference, candidate_, tolerance, options_.asked, options_.cap));
      if (options_.estimate) {
        add_estimate(scores.back(), drawn, *reference, candidate_, options_.asked);
      }
    }
    const std::lock_guard lock(mutex_);
    results_.truth += spent;
    results_.scores.insert(results_.scores.end(), scores.begin(), scores.end());
    if (!reference) {
      ++results_.missing;
    } else if (!usable) {
      ++(reference->end == Reference::End::over_cap ? results_.over_cap
         : reference->end == Reference::End::failed ? results_.failed
                                                    : results_.brief);
    }
  }

  Results& results() { return results_; }

 private:
  const Options& options_;
  MethodChoice candidate_;
  Cache cache_;
  std::mutex mutex_;
  Results results_;
};

void report(const Options& options, Results& results) {
  std::ranges::stable_sort(results.scores, {}, &Score::seed);
  if (!results.scores.empty()) {
    fmt::print("{}", table(results.scores));
    if (options.estimate) fmt::print("{}", estimates(results.scores));
  }
  fmt::print("{}", worst(results.scores, options.worst));
  fmt::print(
      "left out: {} unpredictable after {} frames, {} whose truth takes over {} s, {} without "
      "one, {} not in the cache; the truth took {:.0f} s now\n",
      results.brief, kLeast, results.over_cap, options.cap, results.failed, results.missing,
      results.truth);
  if (options.csv.empty()) return;
  std::ofstream out(options.csv);
  out << csv(results.scores);
  out.close();
  if (!out) throw std::runtime_error(options.csv + ": cannot be written");
}

void write_schemes_of(const Options& options) {
  std::ofstream out(options.schemes);
  out << kSchemeColumns << '\n';
  for (const unsigned seed : seeds(options)) write_schemes(draw(seed), options.tolerances, out);
  out.close();
  if (!out) throw std::runtime_error(options.schemes + ": cannot be written");
}

void go(const Options& options) {
  if (!options.schemes.empty()) return write_schemes_of(options);
  Work work(options, candidate(options));
  const std::vector<unsigned> all = seeds(options);
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;
  std::mutex mutex;
  const auto loop = [&] {
    try {
      for (std::size_t i = next++; i < all.size(); i = next++) work.go(all[i]);
    } catch (...) {
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
      next = all.size();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (unsigned t = 1; t < options.threads; ++t) threads.emplace_back(loop);
    loop();
  }
  if (failure) std::rethrow_exception(failure);
  report(options, work.results());
}

}  // namespace
}  // namespace taut::promise

int main(int argc, char** argv) {
  using namespace taut::promise;
  Options options;
  CLI::App app("The errors that a method delivers, over those it was asked for, on drawn scenes.");
  app.add_option("--scenes", options.scenes, "how many")->capture_default_str();
  app.add_option("--first", options.first, "first seed")->capture_default_str();
  app.add_option("--kind", options.kind, "scenes of this kind alone")
      ->check(CLI::IsMember(std::vector<std::string>(kKinds.begin(), kKinds.end())));
  app.add_option("--tolerances", options.tolerances, "shares of the length")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--asked", options.asked,
                 "what runs are asked for, in the tolerances that they are scored by")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--cache", options.cache, "folder of the references")->capture_default_str();
  app.add_option("--threads", options.threads, "how many work")->capture_default_str();
  app.add_option("--method", options.method, "one that has a tolerance")->capture_default_str();
  app.add_option("--set", options.set, "NAME=VALUE, another setting of the method");
  app.add_option("--csv", options.csv, "a file with a row for every scene and tolerance");
  app.add_option("--schemes", options.schemes,
                 "only a file with the scheme, step and waves of direct at every frame");
  app.add_option("--worst", options.worst, "also list so many of the largest errors");
  app.add_option("--cap", options.cap, "CPU seconds that a reference or a run may take")
      ->capture_default_str();
  app.add_flag("--cached", options.cached, "leave out what the cache does not have");
  app.add_flag("--estimate", options.estimate, "also what the runs estimate of their own error");
  app.add_flag("--references", options.references, "fill the cache and run nothing");
  CLI11_PARSE(app, argc, argv);
  try {
    go(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "taut_promise: {}\n", error.what());
    return 1;
  }
  return 0;
}
