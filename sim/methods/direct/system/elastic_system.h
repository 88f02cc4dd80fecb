// A connector that stretches, bends or meets the air, as the implicit scheme sees it.
#pragma once

#include <vector>

#include "sim/material/forces.h"
#include "sim/methods/direct/system/band_ldlt.h"

namespace taut::direct {

/// Particles in their own coordinates, and the tension of each link as an unknown beside them:
///   m x'' = m g + bends, air + what the links beside pull
///   compliance T = (length - rest) + relaxation d(length)/dt
/// so that a rigid link is one of compliance zero, and a hard one costs no digits. The unknowns of
/// particle i are the numbers 4 i to 4 i + 2, the tension of the link before it 4 i + 3; links bend
/// with their neighbours, so the matrices have ten numbers on either side of their diagonal.
class ElasticSystem {
 public:
  static constexpr std::size_t kHalf = 10;
  using Array = std::vector<double>;  // 4 numbers a particle

  /// `world` has one connector, and bodies that are driven; it must stay.
  void rebuild(const World& world);

  std::size_t particles() const { return mass_.size(); }
  std::size_t size() const { return 4 * particles(); }
  const std::vector<double>& mass() const { return mass_; }
  bool is_held(std::size_t particle) const { return held_[particle]; }
  double length() const { return length_; }
  bool is_rigid(std::size_t link) const { return compliance_[link] == 0; }

  /// Puts held particles where they are at `time`, and turns the clamps.
  void place(double time, double* x, double* v);
  /// The tensions that stretched links have.
  void find_tensions(const double* x, const double* v, double* tensions) const;

  /// The residual of the equations, the accelerations taken for known: for particles the force less
  /// m `acceleration`, for links the negative violation. `x` and `v` are positions and velocities
  /// of the particles, `acceleration` in both 3 numbers a particle, `unknowns` has the tensions.
  void residual(const double* x, const double* v, const double* acceleration,
                const double* unknowns, double* left);

  /// Evaluates the matrices of stiffness and damping at a state.
  void differentiate(const double* x, const double* v, const double* unknowns);
  /// The matrix of the equations for motions that go as exp(rate t): M rate^2 + D rate + K, with
  /// the links' rows.
  template <class Scalar>
  void assemble(Scalar rate, BandLdlt<Scalar, kHalf>& matrix) const;
  /// Divides the links' rows of a right side as assemble() does.
  template <class Scalar>
  void scale_links(Scalar rate, Scalar* right) const;

  /// Adds what damping gives at the rates `by` (m/s; 4 numbers a particle), to links before
  /// scale_links().
  void add_damping(const double* by, double* to) const;

  /// Twist couples all particles with each other, by a matrix of rank one: s g g^T beside that of
  /// assemble(). Its g, the derivative of the twist by places (rad/m; 4 numbers a particle), at the
  /// state that was differentiated; empty: nothing twists.
  const Array& twist_slope() const { return twist_slope_; }
  template <class Scalar>
  Scalar twist_share(Scalar rate) const {
    if (carries_.empty()) return {};
    const material::TwistElement& rod = material_.twists().front();
    return rod.stiffness * Scalar{1} + rod.damping * rate;
  }
  /// How far the ends are turned at a state (EndTurn::since), near the last that was followed; with
  /// the clamps placed.
  double end_turn(const double* x) const;
  double followed_turn() const;
  void follow_turn(double since) { material_.follow_turn(since); }
  void load_twist(const World& world) { material_.load_twists(world); }
  void store_twist(World& world) const { material_.store_twists(world); }

  /// Moves as little as gives rigid links their length, and hard ones the length that they have
  /// under their tension, all masses counted: those whose waves steps of `h` (s) do not follow.
  /// False where it does not converge.
  bool restore_lengths(double h, const double* tensions, double* x);
  /// The impulses that stop what would stretch rigid links.
  void stop_stretch(const double* x, double* v);

  double cycles() const { return 400 * static_cast<double>(particles()); }

 private:
  using Band = std::vector<double>;  // rows of kHalf + 1 as in BandLdlt
  void add_edge(std::uint32_t a, std::uint32_t b, const Mat3& block, Band& band);
  void add_block(std::size_t row, std::size_t column, const Mat3& block, Band& band);
  void add_bend(const material::BendElement& bend, const Mat3& h00, const Mat3& h01,
                const Mat3& h11, Band& band);
  void rebuild_twist();
  void differentiate_twist(const double* x, const double* v);
  void add_twist_damping(const double* by, double* to) const;
  void fill_directions(const double* x);
  void solve_links(double* right);

  const World* world_ = nullptr;
  material::MaterialForces material_;
  Vec3 gravity_ = Vec3::Zero();
  double length_ = 0;
  std::vector<double> mass_;                            // kg, per particle
  std::vector<char> held_;                              // per particle
  std::vector<double> rest_, compliance_, relaxation_;  // per link: m, m/N, s
  std::vector<char> dead_;                              // per link: both ends are held
  std::vector<char> led_;                               // per link: has a length, or a rate, to get
  std::vector<Vec3> force_;
  Band stiffness_, damping_;  // of the particles' rows; the links' in stiffness_
  bool damped_ = false;
  std::vector<Vec3> direction_;
  std::vector<double> diagonal_, sub_diagonal_, impulse_, factor_;
  bool has_rigid_ = false;
  std::vector<material::BendElement> carries_;  // where twist is carried on; empty: nothing twists
  Array twist_slope_;
};

}  // namespace taut::direct
