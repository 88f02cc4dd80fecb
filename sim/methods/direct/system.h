// A component of a world as a constrained multibody system: what the direct method's schemes step.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "sim/methods/direct/components.h"
#include "sim/methods/direct/plane.h"
#include "sim/methods/direct/vector.h"
#include "sim/world.h"

namespace taut::direct {

/// q'' = a(t, q, q') under the constraint that every link keeps its length. Coordinates q: the
/// places of all points (m), axis by axis, then of each rigid body its centre of mass (m) and its
/// unit quaternion (w x y z). Points that something holds stand in q, too; they are placed by it.
///
/// For link i of length l between the points i and i+1, with the unit direction u and a tension T_i
/// that is positive where the link pulls:
///
///   a_i = g + w_i (T_i u_i - T_{i-1} u_{i-1})   and   u_i . (a_{i+1} - a_i) = -l |u'_i|^2
///
/// w is the inverse mass, zero for held points; that of a body's point r from its centre is the
/// matrix 1/M - [r] I^-1 [r]. Every tension meets only those of the neighbouring links and of the
/// links at its bodies: one symmetric tridiagonal system for all spans, and a small dense one for
/// bodies that several links hold. (Baraff, Linear-time dynamics using Lagrange multipliers, 1996.)
///
/// In a plane points have two coordinates, and bodies that hang by one point are links (see Stick).
class System {
 public:
  System() = default;
  System(const System&) = delete;
  System& operator=(const System&) = delete;

  /// Room for so many points and ends of spans, in a world of so many bodies.
  void reserve(std::size_t points, std::size_t ends, std::size_t bodies);
  /// In `plane`, which must suit the world's present state (see find_plane()), or in space.
  void rebuild(const World& world, const Component& component, const std::optional<Plane>& plane);

  /// Holds are read from `world` from now on.
  void attach(const World& world) { world_ = &world; }
  /// Reads the world's state. Arrays of states have size() numbers.
  void load(const World& world, double* q, double* v);
  /// Writes everything that nothing prescribes to the world.
  void store(World& world, double* q, double* v);

  std::size_t size() const { return bodies_at() + 7 * bodies_.size() + kLanes; }
  /// Places what is held, and writes the acceleration that the tensions leave (m/s^2).
  void acceleration(double time, double* q, double* v, double* a);
  /// Moves points and bodies by M^-1 J^T, as little as it takes with all masses counted, until
  /// lengths hold to rounding, and stops what velocities change them.
  void project(double time, double* q, double* v);

  /// The RMS displacement (m) of points and bodies for a small change of q, or speed for one of v.
  double norm(const double* change) const;
  /// An upper bound of the frequencies (rad/s) of the transverse waves under the last tensions
  /// (Gershgorin's; for a row of equal links it is exact).
  double frequency() const { return frequency_; }
  /// N, of the first link of the component's k-th span, as of the last acceleration().
  double tension(std::size_t span) const;
  /// The acceleration by which a hold has left the plane since load(), if one has.
  const std::optional<Vec3>& left_plane() const { return left_plane_; }

  double length() const { return length_; }                  // m, of all links
  double shortest() const { return shortest_; }              // m, of a link
  double gravity() const { return world_->gravity.norm(); }  // m/s^2
  double time_scale() const;                                 // s, of a pendulum of that length
  std::size_t points() const { return points_; }
  /// The largest difference of `x` (m/s, m/s^2) between the ends of a link, over its length.
  double turning(const double* x) const;
  bool has_bodies() const { return !bodies_.empty(); }
  /// The cycles (see Counters::work) of an acceleration and of what a scheme makes of it.
  double work() const { return work_; }

  // For schemes in the places of points, where there are no bodies (position Verlet).

  /// Moves what is held to its place at `time`.
  void place(double time, double* q, double* v);
  /// Adds to `next`, where points would go from q until `time` without forces, `factor` (s^2) times
  /// the accelerations by gravity and by those tensions along the links of q that keep the lengths
  /// there; by one linear system, from the last tensions. Returns the most (of its length) that a
  /// link was off by those.
  double shake(double time, double factor, double* q, double* next, double* v);
  /// Makes zero what an array has for held points.
  void clear_held(double* array) const;

  /// One round of project(), in which velocities change by `per_time` (1/s) times what places do.
  /// Returns the most (of its length) that a link was off before.
  double keep(double time, double per_time, double* q, double* v);

  /// The RMS displacement (m) that lasting errors `a` of the accelerations (m/s^2) amount to in the
  /// time `span` (s): a wave of frequency w under the last tensions is driven at its resonance by
  /// a w span / 2 of its static displacement a / w^2, but at most by `saturation` / w^2 of that,
  /// its own amplitude. Spoils `a`.
  double accumulated(double span, double saturation, double* a);

  // For implicit schemes: the transverse waves that the last tensions carry, M^-1 K, with K the
  // tridiagonal stiffness of links that pull.

  /// Factors sigma_squared + M^-1 K.
  void factor_waves(double sigma_squared);
  /// Solves for one right side in place.
  void solve_waves(double* x) const;

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  struct End {  // a span's end that something holds
    std::size_t point = 0, link = 0;
    double pull = 0;  // +1 where the tension pulls along u (a span's first end), else -1
    Attachment to;
    std::size_t body = kNone;       // index into bodies_; none: prescribed
    Vec3 local_arm = Vec3::Zero();  // m, from the body's centre of mass, in its axes
    // At the present stage:
    Vec3 arm = Vec3::Zero();   // m, in the world's axes
    Vec3 lead = Vec3::Zero();  // m/s^2, the acceleration that no tension causes, less gravity
  };
  struct Bar {                         // a body that is a link
    std::size_t body = 0;              // index into World::bodies
    std::size_t tip = 0, far = 0;      // points
    double arm = 0;                    // m, of the centre of mass from the tip
    Vec3 direction = Vec3::UnitX();    // from the tip, when loaded
    Quat rotation = Quat::Identity();  // when loaded
  };
  struct Span {
    SpanRange range;
    std::size_t first_particle = 0;  // of point_of_
    std::size_t first_link = 0;
  };
  struct RigidBody {
    std::size_t body = 0;  // index into World::bodies
    double mass = 0;
    Mat3 inertia = Mat3::Identity(), inverse_inertia = Mat3::Identity();  // in its axes
    std::size_t first_end = 0, ends = 0;                                  // of body_ends_
    // At the present stage:
    Mat3 rotation = Mat3::Identity(), world_inverse_inertia = Mat3::Identity();
    Vec3 spin = Vec3::Zero(), spin_rate = Vec3::Zero();  // the rate that no tension causes
  };
  struct Coupling {                   // two different ends on one body
    std::size_t a = 0, b = 0;         // ends_
    std::size_t row = 0, column = 0;  // of the dense system
  };

  // Building (system_build.cpp).
  void add_span(const World& world, const SpanRange& range);
  void add_point(double mass);
  void add_end(const World& world, const Attachment& to, std::size_t point, std::size_t link,
               double pull);
  void lay_out();
  void couple();

  // The tensions' system (system.cpp).
  void turn_bodies(const double* q, const double* v);
  void lead_bodies();
  void read_holds(double time, double* q, double* v);
  void place_carried(double* q, double* v);
  void add_ends(bool with_leads);
  void solve();
  void add_couplings();
  void move_bodies(const double* q, double* out);
  void shift_bodies(double place, double speed, double* q, double* v);
  void assemble(const double* q);
  void note_tensions();
  void unit_quaternions(double* q, double* v) const;
  void stop_lengthening(double* q, double* v);

  // The state (system_state.cpp).
  struct Rotary {
    Vec3 momentum = Vec3::Zero();  // kg m^2/s
    Mat3 inertia = Mat3::Zero();   // kg m^2
    Vec3 centre = Vec3::Zero();    // m, of mass
  };
  Rotary rotary(const double* q, const double* v) const;
  double link_length(const Bar& bar) const { return rest_[std::min(bar.tip, bar.far)]; }
  void keep_angular_momentum(double* q, double* v);
  void store_bars(World& world, const double* q, const double* v) const;

  std::span<const std::size_t> ends_of(const RigidBody& body) const {
    return {body_ends_.data() + body.first_end, body.ends};
  }
  std::size_t row(int axis) const { return static_cast<std::size_t>(axis) * stride_; }
  std::size_t bodies_at() const { return row(axes_); }
  std::size_t body_at(std::size_t b) const { return bodies_at() + 7 * b; }
  /// A vector of an array, in the world's axes.
  Vec3 at(const double* array, std::size_t point) const {
    const double *x = array + point, *y = x + stride_;
    if (plane_) return *x * plane_->x + *y * plane_->y;
    return {*x, *y, y[stride_]};
  }
  void set(double* array, std::size_t point, const Vec3& vector) const {
    double *x = array + point, *y = x + stride_;
    *x = plane_ ? vector.dot(plane_->x) : vector.x();
    *y = plane_ ? vector.dot(plane_->y) : vector.y();
    if (!plane_) y[stride_] = vector.z();
  }
  /// A point's place in the world.
  Vec3 place_of(const double* q, std::size_t point) const {
    return plane_ ? Vec3(at(q, point) + offset_ * plane_->normal) : at(q, point);
  }
  double tension_of(std::size_t link) const { return scale_[link] * unknown_[link]; }

  const World* world_ = nullptr;
  std::optional<Plane> plane_;
  double offset_ = 0;  // m, of the plane from the origin
  std::optional<Vec3> left_plane_;
  int axes_ = 3;
  std::vector<std::size_t> body_of_, bar_of_;  // by World::bodies: bodies_, bars_
  std::vector<Span> spans_;
  std::vector<End> ends_;
  std::vector<Bar> bars_;
  std::vector<RigidBody> bodies_;
  std::vector<std::size_t> body_ends_;  // body by body
  std::vector<Coupling> couplings_;
  std::vector<std::size_t> coupled_;  // links with a row of the dense system
  bool floats_ = false;               // nothing prescribed holds it
  double length_ = 0, shortest_ = 0, mass_ = 0, work_ = 0;
  Vec3 spin_momentum_ = Vec3::Zero();  // where it floats: kg m^2/s about the centre of mass

  std::size_t points_ = 0, stride_ = 0;
  std::vector<double> point_mass_;     // kg, zero for held points
  std::vector<double> link_rest_;      // m; zero behind a span's last point
  std::vector<char> held_;             // by points
  std::vector<std::size_t> point_of_;  // by particles, span by span

  // One block. Rows and columns of the tensions' system are scaled to a diagonal of 2, near which
  // neither its minors nor their inverses overflow; unknowns are tensions / scale.
  Array arena_;
  double *rest_ = nullptr, *inverse_rest_, *inverse_mass_, *falls_, *scale_;
  double *beside_, *weight_, *after_, *before_, *wave_;  // scaled constants of the loops
  // The system, see solve_chain(). Links of different spans are no neighbours: as if at right
  // angles, where `apart_` is what that makes of turned_.
  double *near_, *far_, *apart_, *off_, *turned_, *right_, *unknown_;
  double* change_;               // of shake()
  double* stiffness_;            // N/m, of links that pull, by the last tensions
  double *pivot_, *up_, *down_;  // of factor_waves()
  double sigma_squared_ = 1;     // 1/s^2
  double frequency_ = 0;         // rad/s
  double *u_, *work_u_;          // directions, three rows each
  double* work_space_;           // three rows
  double gravity_axes_[3] = {};
  // Workspaces of add_couplings().
  Array response_;
  Eigen::MatrixXd dense_, gain_, coupled_system_;
  Eigen::VectorXd dense_right_, share_;
  Eigen::PartialPivLU<Eigen::MatrixXd> decomposed_;
};

}  // namespace taut::direct
