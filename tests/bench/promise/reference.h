// The true motion of a drawn scene, as far as that can be foretold.
#pragma once

#include <optional>
#include <string>

#include "sim/evaluation/run.h"
#include "sim/run/trajectory.h"
#include "tests/bench/promise/draw.h"

namespace taut::promise {

constexpr double kDuration = 1;    // s
constexpr int kFps = 60;           // frames a second
constexpr double kNudge = 1e-8;    // of the length: by how far twins start elsewhere
constexpr double kGrowth = 100;    // nudges that twins may be off where one can foretell
constexpr std::size_t kLeast = 3;  // frames after the first, or a scene shows nothing

struct Reference {
  enum class End : int {
    whole,     // until the end or until a twin parts
    over_cap,  // it took too long
    failed,    // no solution was found beyond the last frame
  };
  End end = End::whole;
  std::vector<Snapshot> frames;  // particles alone, from the start to the horizon
  double growth = 0;             // nudges by which the farther twin is off at the horizon
  double cpu = 0;                // s, of all three

  bool usable() const { return end != End::over_cap && frames.size() > kLeast; }
  double horizon() const { return frames.empty() ? 0 : frames.back().time; }
};

/// The first solver of the truth and two twins, frame by frame, until one parts or they have taken
/// `cap` (s of CPU time). One twin starts nudged more and more along each connector, the other by
/// turns to one side and the other: upright chains amplify that far more. Free bodies
/// are turned in the one and moved in the other.
Reference make_reference(const Drawn& drawn, double cap);
/// Of any problem whose largest connector has that length (m). Twins are nudged again after each
/// pin and cut.
Reference make_reference(const study::Problem& problem, double length, double cap);

/// References kept in a folder, one file each.
class Cache {
 public:
  explicit Cache(std::string folder);

  std::optional<Reference> find(const Drawn& drawn) const;
  /// Throws std::runtime_error where it cannot be written.
  void keep(const Drawn& drawn, const Reference& reference) const;

 private:
  std::string path(const Drawn& drawn) const;
  std::string folder_;
};

}  // namespace taut::promise
