// One step of Radau IIA, of order 5, for a connector that stretches, bends or meets the air.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/methods/direct/system/elastic_system.h"
#include "sim/motion/types.h"

namespace taut::direct {

/// The coefficients of Radau IIA with three stages, of order 5.
///
/// Hairer and Wanner, Solving ODEs II, IV.5 and IV.8: with the inverse of the Runge-Kutta matrix
/// brought to a real eigenvalue and a complex pair, a Newton iteration takes one real and one
/// complex system of the size of the state.
struct RadauTableau {
  static const RadauTableau& get();

  Vec3 node;      // of a stage, as a share of the step; the last is 1
  Mat3 inverse;   // of the Runge-Kutta matrix
  double real;    // the real eigenvalue of `inverse`
  double re, im;  // one of the pair
  /// inverse = to_stage diag(real, pair) from_stage: stages are to_stage times the transformed
  /// ones, of which the second less i times the third belongs to re + i im.
  Mat3 to_stage, from_stage;
  /// Weights of the stages' differences from the start in an estimate of the error of order 3.
  Vec3 error;
};

/// L-stable, so that what is stiffer than the step follows is damped, never left ringing; stiffly
/// accurate, so that rigid links have their length at the end of a step; collocation, so that a
/// step begins from the polynomial of the one before. Velocities are the derivative of that
/// polynomial: only positions and tensions are unknown (Hairer and Wanner, Solving ODEs II, IV.8
/// and VII.4, and Hairer, Lubich and Roche, LNM 1409, 1989, for rigid links, of index 3).
class RadauStep {
 public:
  /// `world` has one connector, and bodies that are driven; it must stay.
  void rebuild(const World& world);
  /// Reads the state of that world, from which no step has been taken.
  void load(double time);
  void store(World& world) const;

  struct Result {
    bool converged = false;
    double error =
        0;  // m, RMS over the particles that nothing holds; of order 3, so mostly too large
  };
  /// Steps from `time` by `h`; Newton's method goes on until it is off by at most `within` (m), and
  /// an error above `limit` (m) is looked at twice. The state is the next one after accept().
  Result attempt(double time, double h, double within, double limit);
  void accept();

  std::uint64_t iterations() const { return iterations_; }  // since rebuild()
  double cycles() const {
    return 3 * system_.cycles() + 900 * static_cast<double>(system_.particles());
  }
  const ElasticSystem& system() const { return system_; }

 private:
  using Array = std::vector<double>;
  static constexpr std::size_t kHalf = ElasticSystem::kHalf;

  void guess(double h);
  void find_stages(double h);
  double iterate(double time, double h);
  double estimate(double time, double h, double limit);
  double filter(double h, const Array& x, const Array& v);
  bool finish(double time, double h);
  double rms(const double* four) const;

  const World* world_ = nullptr;
  const RadauTableau& tableau_ = RadauTableau::get();
  ElasticSystem system_;
  Array x_, v_;                      // 3 numbers a particle
  Array next_x_, next_v_, tension_;  // tension_: 4 numbers a particle, as unknowns
  std::array<Array, 3> z_, before_;  // stages less the start, and tensions; 4 numbers a particle
  std::array<Array, 3> stage_x_, stage_v_, left_;
  Array acceleration_, real_right_, zero_;
  Array speed_, drift_, change_;  // of the estimate; 4 numbers a particle
  std::vector<Complex> complex_right_;
  BandLdlt<double, kHalf> real_;
  BandLdlt<Complex, kHalf> complex_;
  RankOne<double, kHalf> real_twist_;
  RankOne<Complex, kHalf> complex_twist_;
  double next_turn_ = 0;         // rad, see ElasticSystem::end_turn()
  double h_ = 0, before_h_ = 0;  // s; before_h_ zero: there is no step before
  std::size_t free_ = 0;         // particles
  std::uint64_t iterations_ = 0;
};

}  // namespace taut::direct
