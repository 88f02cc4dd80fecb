// Scenes of any two features that are followed go on, end and stay finite, at fixed steps, too; of
// others the message names the place.
#include "tests/drawn/pairs.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <regex>
#include <sstream>
#include <thread>

#include "render/base/child.h"
#include "scenes/files/error.h"
#include "scenes/format/document.h"
#include "scenes/reader/reader.h"
#include "scenes/scene/scene.h"
#include "sim/evaluation/run.h"
#include "sim/features/features.h"
#include "sim/run/simulation.h"

namespace taut::drawn::pairs_test {
namespace {

#ifdef TAUT_SANITIZED
constexpr double kSlower = 10;
#else
constexpr double kSlower = 1;
#endif
constexpr double kHang = 20 * kSlower;        // s of CPU time, of a frame
constexpr double kShare = 0.05 * kSlower;     // of a run: it goes no farther
constexpr std::size_t kMemory = 1024u << 20;  // bytes

constexpr const char* kDone = "done";
constexpr const char* kStopped = "stopped ";

bool is_finite(const World& world) {
  for (const Connector& connector : world.connectors) {
    for (const auto* list : {&connector.position, &connector.velocity}) {
      for (const Vec3& v : *list) {
        if (!v.allFinite()) return false;
      }
    }
  }
  return std::ranges::all_of(world.bodies, [](const Body& body) {
    return body.position.allFinite() && body.rotation.coeffs().allFinite() &&
           body.velocity.allFinite() && body.spin.allFinite();
  });
}

/// What comes of a run: kDone, kStopped with why, or what is wrong.
std::string run(const scenes::Scene& scene, const std::string& method, const Settings& settings) {
  try {
    Simulation simulation(scene.world, make_method(method, settings), scene.timeline);
    const double start = thread_seconds();
    for (int frame = 1; frame <= scene.frames(); ++frame) {
      simulation.advance_to(frame / static_cast<double>(scene.fps));
      if (!is_finite(simulation.world())) return fmt::format("not finite in frame {}", frame);
      if (thread_seconds() - start > kShare) break;
    }
    return kDone;
  } catch (const Diverged& stop) {
    const bool says = !stop.reason.empty() && std::isfinite(stop.time);
    return says ? kStopped + stop.reason : "stops without a word";
  } catch (const BadIntervention& stop) {
    return kStopped + std::string(stop.what());
  } catch (const std::exception& error) {
    return fmt::format("an error that is not meant: {}", error.what());
  }
}

/// Runs it by its method, then by each other that follows it; a line for each.
void run_all(const scenes::Scene& scene, const render::Say& say) {
  const auto line = [&](const std::string& method, const Settings& settings) {
    say(method + ": ");
    say(run(scene, method, settings) + '\n');
  };
  line(scene.method.name, scene.method.settings);
  for (const MethodInfo& method : all_methods()) {
    const bool takes = method.missing.empty() && method.name != "sdfast" &&
                       !find_refusal(method.abilities, scene.world, &scene.timeline);
    if (takes && method.name != scene.method.name) line(std::string(method.name), {});
  }
}

struct Tally {
  unsigned refused = 0, done = 0, stopped = 0, fixed = 0;
  std::array<std::array<bool, kFeatureCount>, kFeatureCount> followed{};
};

bool has_place(const std::string& message) {
  static const std::regex place("^pair\\.toml:[0-9]+:[0-9]+: .");
  return std::regex_search(message, place);
}

/// Adds what comes of a seed to the tally; what is wrong with it, or nothing.
std::string check(unsigned seed, Tally& tally, std::mutex& mutex) {
  std::optional<scenes::Scene> scene;
  try {
    scene = scenes::read_scene(scenes::parse_document("pair.toml", pair_text(seed)), false);
  } catch (const scenes::BadScene& error) {
    const std::lock_guard lock(mutex);
    ++tally.refused;
    return has_place(error.what()) ? "" : fmt::format("no place in \"{}\"", error.what());
  } catch (const std::exception& error) {
    return fmt::format("its reader fails: {}", error.what());
  }
  const double share = kShare * static_cast<double>(all_methods().size());
  const render::Bounded result = render::run_bounded(
      {kHang + share, kMemory}, [&](const render::Say& say) { run_all(*scene, say); });
  using End = render::Bounded::End;
  if (result.end == End::no_time) return result.said + "a frame that never ends";
  if (result.end == End::no_memory) return result.said + "takes 1 GB";
  if (result.end == End::failed) return result.said + "ends by a fault";
  const Features used = features(scene->world, scene->timeline);
  std::istringstream lines(result.said);
  unsigned runs = 0, stops = 0;
  for (std::string one; std::getline(lines, one); ++runs) {
    const std::string outcome = one.substr(one.find(": ") + 2);
    if (outcome.starts_with(kStopped)) {
      ++stops;
    } else if (outcome != kDone) {
      return one;
    }
  }
  const std::lock_guard lock(mutex);
  tally.done += runs - stops;
  tally.stopped += stops;
  if (scene->method.settings.contains("step")) ++tally.fixed;
  for (std::size_t a = 0; a < kFeatureCount; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      const bool both = used.has(static_cast<Feature>(a)) && used.has(static_cast<Feature>(b));
      tally.followed[a][b] |= both;
    }
  }
  return "";
}

Tally check_pairs(unsigned first, unsigned count) {
  Tally tally;
  std::atomic<unsigned> next = first;
  std::mutex mutex;
  const auto work = [&] {
    for (unsigned seed = 0; (seed = next++) < first + count;) {
      const std::string wrong = check(seed, tally, mutex);
      const std::lock_guard lock(mutex);
      if (!wrong.empty()) {
        ADD_FAILURE() << "seed " << seed << ": " << wrong << '\n' << pair_text(seed);
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (unsigned i = std::thread::hardware_concurrency(); i > 0; --i) threads.emplace_back(work);
  }
  std::cout << fmt::format(
      "{} scenes of pairs: {} refused with their place; {} runs done, {} stopped with a message; "
      "{} "
      "scenes at fixed steps\n",
      count, tally.refused, tally.done, tally.stopped, tally.fixed);
  return tally;
}

/// Pairs that no scene had that was taken: a method that follows both is rare for these. Features
/// that no method follows or no scene has do not count.
unsigned missed(const Tally& tally) {
  unsigned count = 0;
  const auto is_followed = [](std::size_t feature) {
    if (static_cast<Feature>(feature) == Feature::applied_force) return false;
    return std::ranges::any_of(all_methods(), [&](const MethodInfo& method) {
      return method.abilities.follows.has(static_cast<Feature>(feature));
    });
  };
  for (std::size_t a = 0; a < kFeatureCount; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      if (tally.followed[a][b] || !is_followed(a) || !is_followed(b)) continue;
      ++count;
      std::cout << name(static_cast<Feature>(a)) << ", " << name(static_cast<Feature>(b)) << "\n";
    }
  }
  return count;
}

TEST(DrawnPairs, GoOnAndStayFinite) {
  const Tally tally = check_pairs(0, pair_count());
  EXPECT_LT(tally.refused, pair_count() * 2 / 3);
  EXPECT_GT(tally.fixed, pair_count() / 20);
}

// TAUT_SEED and TAUT_SCENES in the environment choose others.
TEST(LongDrawnPairs, TenThousandGoOnAndStayFinite) {
  const char* first = std::getenv("TAUT_SEED");
  const char* count = std::getenv("TAUT_SCENES");
  const Tally tally = check_pairs(first ? static_cast<unsigned>(std::atoi(first)) : 0,
                                  count ? static_cast<unsigned>(std::atoi(count)) : 10'000);
  EXPECT_LE(missed(tally), pair_count() / 10);
}

}  // namespace
}  // namespace taut::drawn::pairs_test
