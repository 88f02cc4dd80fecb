// One connector that stretches, bends or meets the air, between ends whose motion is known: its
// equations (ElasticSystem), one implicit step (RadauStep), and the control of steps (Elastic).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/material/forces.h"
#include "sim/methods/direct/controller.h"
#include "sim/motion/types.h"

namespace taut::direct {

// L D L^T of a symmetric band matrix, real or complex symmetric, without exchanges; and solves with
// a product of one vector with itself on top of it.

/// A complex number whose product is four multiplications and nothing else.
struct Complex {
  double re = 0, im = 0;

  friend Complex operator+(Complex a, Complex b) { return {a.re + b.re, a.im + b.im}; }
  friend Complex operator-(Complex a, Complex b) { return {a.re - b.re, a.im - b.im}; }
  friend Complex operator*(Complex a, Complex b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  }
  friend Complex operator*(double a, Complex b) { return {a * b.re, a * b.im}; }
};

inline double inverse(double x) {
  return 1 / x;
}
inline Complex inverse(Complex x) {
  const double scale = 1 / (x.re * x.re + x.im * x.im);
  return {scale * x.re, -scale * x.im};
}

/// Rows are coupled with `kHalf` before and behind. Stable without exchanges where the matrix is
/// definite once the multipliers, each behind the rows that it couples, are eliminated.
template <class Scalar, std::size_t kHalf>
class BandLdlt {
 public:
  static constexpr std::size_t kWidth = kHalf + 1;

  void resize(std::size_t rows) {
    rows_ = rows;
    band_.resize(rows * kWidth);
    inverse_.resize(rows);
  }
  void clear() { std::fill(band_.begin(), band_.end(), Scalar{}); }
  /// The entry of the matrix, before factor(); `column` at most `row`.
  Scalar& at(std::size_t row, std::size_t column) {
    return band_[row * kWidth + kHalf + column - row];
  }
  Scalar* row(std::size_t row) { return &band_[row * kWidth]; }

  void factor() {
    std::array<Scalar, kWidth> scaled;  // the row of L D
    for (std::size_t r = 0; r < rows_; ++r) {
      Scalar* own = row(r);
      const std::size_t first = r < kHalf ? kHalf - r : 0;  // where the row begins
      Scalar pivot = own[kHalf];
      for (std::size_t c = first; c < kHalf; ++c) {
        // The row of column c's unknown is shifted by kHalf - c against this one.
        const std::size_t shift = kHalf - c;
        const Scalar* other = row(r - shift);
        Scalar value = own[c];
        for (std::size_t k = first; k < c; ++k) value = value - scaled[k] * other[k + shift];
        scaled[c] = value;
        own[c] = value * inverse_[r - shift];
        pivot = pivot - value * own[c];
      }
      inverse_[r] = inverse(pivot);
    }
  }

  void solve(Scalar* x) const {
    for (std::size_t r = 0; r < rows_; ++r) {
      const Scalar* own = &band_[r * kWidth];
      const std::size_t first = r < kHalf ? kHalf - r : 0;
      Scalar value = x[r];
      for (std::size_t c = first; c < kHalf; ++c) value = value - own[c] * x[r + c - kHalf];
      x[r] = value;
    }
    for (std::size_t r = 0; r < rows_; ++r) x[r] = inverse_[r] * x[r];
    for (std::size_t r = rows_; r-- > 0;) {  // what is behind has been taken off x[r] already
      const Scalar* own = &band_[r * kWidth];
      const std::size_t first = r < kHalf ? kHalf - r : 0;
      const Scalar value = x[r];
      for (std::size_t c = first; c < kHalf; ++c) {
        x[r + c - kHalf] = x[r + c - kHalf] - own[c] * value;
      }
    }
  }

 private:
  std::size_t rows_ = 0;
  std::vector<Scalar> band_;  // per row: kHalf entries of L, then the diagonal
  std::vector<Scalar> inverse_;
};

/// (A + s g g^T) x = r by the factors of A: Sherman and Morrison, Annals of Mathematical Statistics
/// 21, 1950. Without a g it is A alone.
template <class Scalar, std::size_t kHalf>
class RankOne {
 public:
  using Matrix = BandLdlt<Scalar, kHalf>;

  /// `matrix` is factored; `slope` is g, or empty.
  void factor(const Matrix& matrix, const std::vector<double>& slope, Scalar s) {
    slope_ = slope;
    if (slope.empty()) return;
    solved_.resize(slope.size());
    for (std::size_t i = 0; i < slope.size(); ++i) solved_[i] = slope[i] * Scalar{1};
    matrix.solve(solved_.data());
    share_ = s * inverse(Scalar{1} + s * along(solved_.data()));
  }

  void solve(const Matrix& matrix, Scalar* right) const {
    matrix.solve(right);
    if (slope_.empty()) return;
    const Scalar less = share_ * along(right);
    for (std::size_t i = 0; i < slope_.size(); ++i) right[i] = right[i] - less * solved_[i];
  }

 private:
  Scalar along(const Scalar* values) const {
    Scalar sum{};
    for (std::size_t i = 0; i < slope_.size(); ++i) sum = sum + slope_[i] * values[i];
    return sum;
  }

  std::vector<double> slope_;
  std::vector<Scalar> solved_;  // A^-1 g
  Scalar share_{};
};

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

// One step of Radau IIA, of order 5.

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

/// Follows one connector by RadauStep: nothing couples it with the rest of its world.
class Elastic : public Stepping {
 public:
  explicit Elastic(const StepOptions& options) : options_(options), controller_(options) {}
  Elastic(const Elastic&) = delete;

  /// Call first, and whenever the world's topology is new.
  void rebuild(const World& world, std::size_t connector);
  /// From the world's time and the connector's state there to its state at `until`. Throws
  /// Diverged.
  void advance(World& world, double until, Counters& counters);

  double first_step() const override;
  double longest_step(double time) override;
  double order() const override;
  bool lands(double left, double wish) const override;
  Attempt attempt(double time, double h, double until) override;
  void accept(double time) override;
  [[noreturn]] void give_up(double time) override;

 private:
  double allowed(double h) const;
  double left_open(double h) const;

  StepOptions options_;
  Controller controller_;
  std::size_t connector_ = 0;        // of the world
  std::vector<std::size_t> bodies_;  // driven, of the world
  World own_;                        // the connector with these bodies
  RadauStep step_;
  bool known_ = false;  // the state of the steps is that of own_
  Counters* counters_ = nullptr;
};

}  // namespace taut::direct
