// The system that the direct method steps: spans and free bodies that pull on each other.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "sim/links/linear_systems.h"
#include "sim/methods/direct/system/links.h"
#include "sim/motion/plane.h"
#include "sim/topology/components.h"
#include "sim/world/world.h"

namespace taut::direct {

/// An error of velocity counts for this time (s): a share of that in which a pendulum of `length`
/// (m) would turn it into an error of position.
inline double velocity_time_of(double length) {
  constexpr double kShare = 0.15;
  constexpr double kStandardGravity = 9.80665;  // m/s^2
  return kShare * std::sqrt(length / kStandardGravity);
}

/// The estimated error (m) of a step.
struct StepError {
  double all = 0;          // in places and velocities
  double followed = 0;     // of that, less the damped part of waves passed over
  double passed_over = 0;  // in places, on those waves
};

/// The motion of a component, q'' = a(t, q, q'), with arrays of size() doubles, a multiple of four;
/// padding among them is zero. The coordinates are never places, so that every length holds
/// whatever an integrator does: the unit directions u of all links (in a plane their
/// angles), then the unit quaternions (w x y z) of the bodies. For link i of length l between the
/// points i and i+1, with a tension T_i that is positive where the link pulls:
///
///   l u'' = a_{i+1} - a_i   and   u . u'' = -|u'|^2   (from |u| = 1)
///
/// A free particle has a = g + w (T_i u_i - T_{i-1} u_{i-1}), w its inverse mass; a held point's is
/// known; that of a body's point r from its centre is g + W x (W x r) + W' x r + F/M. Every tension
/// meets only those of the neighbouring links and of the links at its bodies: one symmetric
/// tridiagonal system for all spans, and a small dense one for bodies that several links hold.
///
/// In a plane a component is one span, and bodies that hang by one point are links.
class System {
 public:
  /// Room for so many links, and spans with so many ends.
  void reserve(std::size_t links, std::size_t ends);
  /// In `plane`, which must suit the world's present state (see PlaneFinder), or in space.
  void rebuild(const World& world, const Component& component, const std::optional<Plane>& plane);

  /// Where its one span, if any, stands in the world by now.
  void renumber(const Component& component) {
    if (component.spans.size() == 1) spans_[0].range = component.spans[0];
  }

  /// The index among all links of the connector's first.
  std::size_t first_link(std::size_t connector) const;
  /// The tension (N) of a link, as of the last acceleration().
  double tension(std::size_t link) const { return links_.tension(link); }

  /// Reads the state from the world, whose time is `time`.
  void load(const World& world, double time, double* q, double* rate);
  /// Writes the state at the world's time, positions included, to the world, in which what is
  /// prescribed is at its place.
  void store(World& world, const double* q, const double* rate);
  /// Reads holds from `world` from now on.
  void attach(const World& world) { world_ = &world; }
  /// The acceleration by which a hold has left the plane since load(), if one has.
  const std::optional<Vec3>& left_plane() const { return left_plane_; }
  double length() const { return length_; }      // m, of all links
  double shortest() const { return shortest_; }  // m, of a link
  /// An upper bound of the frequencies (rad/s) of the waves under the last tensions.
  double wave_frequency() const { return links_.wave_frequency(); }

  std::size_t size() const { return links_.end() + 4 * bodies_.size() + Links::kPad; }
  /// Writes q'' at `time` (s).
  void acceleration(double time, const double* q, const double* rate, double* out);
  /// Returns q and q' to where they belong after a step: unit lengths, closed loops. False where
  /// that leaves a loop open.
  bool project(double time, double* q, double* rate);
  /// The cost of project(), in accelerations.
  double projection_cost() const;
  /// The cycles (see Counters::cycles) of an acceleration and of the integrator's use of it.
  double cycles() const { return cycles_; }
  /// By how far (m, RMS) a small change of q displaces the particles.
  double displacement(const double* change) const;
  /// A cheap upper bound of that, from the sum of the squares of `change`.
  double displacement_bound(double squares) const {
    return displacement_factor_ * std::sqrt(squares);
  }
  /// The time (s) for which an error of velocity counts.
  double velocity_time() const { return velocity_time_; }
  /// The error (m) of the particles' positions that the errors of q and q' amount to.
  double error(const double* of_q, const double* of_rate) const {
    const double place = displacement(of_q), speed = velocity_time() * displacement(of_rate);
    return std::sqrt(place * place + speed * speed);
  }

  // A chart for long steps, in which the unit lengths hold of themselves: of each q its part x
  // across its place in `base`, so that q = x + sqrt(1 - x.x) base.

  /// From the chart to q, in place; false where x has left the chart.
  bool retract(const double* base, double* x, double* rate) const;
  /// Leaves of x what lies across `base`.
  void to_tangent(const double* base, double* x) const;
  /// Factors sigma_squared - L, L the stiff part of the derivative of the last acceleration by q.
  void factor(double sigma_squared);
  void solve_factored(double* x) const;

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  struct End {  // a span's end that is neither a free particle nor a stick
    std::size_t link = 0;
    double pull = 0;  // +1 where the tension pulls along u (a span's first end), else -1
    Attachment to;
    std::size_t body = kNone;       // index into bodies_; none: prescribed
    Vec3 local_arm = Vec3::Zero();  // m, from the body's centre of mass, in its axes
    // At the present stage:
    Vec3 along = Vec3::Zero();              // the link's direction
    Vec3 arm = Vec3::Zero();                // m, in the world's axes
    Vec3 free_acceleration = Vec3::Zero();  // m/s^2, without tensions, less gravity
  };
  struct BodyLink {        // a body that is a link
    std::size_t body = 0;  // index into World::bodies
    std::size_t link = 0;
    double outward = 0;                // +1 where u points from the tip to the far mass, else -1
    double arm = 0;                    // m, of the centre of mass
    Vec3 direction = Vec3::UnitX();    // from the tip outward, when loaded
    Quat rotation = Quat::Identity();  // when loaded
  };
  struct Span {
    SpanRange range;
    bool reversed = false;                    // runs from range.last to range.first
    std::size_t offset = 0, links = 0;        // into the links, body links included
    std::size_t first = kNone, last = kNone;  // ends_
    std::size_t first_body_link = kNone, last_body_link = kNone;  // body_links_
    bool closes = false;  // the place of its last end is known without it
    std::size_t particles() const { return range.last - range.first + 1; }
    /// The connector's particle at the span's k-th point, body links left out.
    std::size_t particle(std::size_t k) const {
      return reversed ? range.last - k : range.first + k;
    }
  };
  struct Part {            // a free body that is no link
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
  struct Rotary {
    Vec3 momentum = Vec3::Zero();  // kg m^2/s
    Mat3 inertia = Mat3::Zero();   // kg m^2
  };

  // Building.
  void add_span(const World& world, const SpanRange& range, bool reversed);
  void order_spans(const World& world, std::span<const SpanRange> ranges);
  double scale_beside_bodies(const World& world, double links) const;
  void measure_links(const World& world);
  void couple();

  // The tensions' system.
  void turn_bodies(const double* q, const double* rate);
  void lead_bodies();
  void read_holds(double time);
  void add_ends(const double* q);
  void add_couplings();
  void move_bodies(const double* q, double* out);
  void respond(const double* q, double* out);
  void clear_ends(double* array) const;
  double count_cycles() const;

  // The state.
  void place(double time, const double* q, const double* rate);
  Point place_of(const End& end, double time) const;
  void place_bars(const double* q, const double* rate);
  Point centre(double time) const;
  void float_to(double time);
  void unit(double* q, double* rate) const;
  double measure_gaps(double time, const double* q, const double* rate);
  void spread(const double* q, Vec3 Point::*gap, double* array);
  bool close(double time, double* q, double* rate);
  Rotary rotary(double time) const;
  void restore_momentum(double time, double* q, double* rate);

  /// The ends that hold the body, as indices into ends_.
  std::span<const std::size_t> ends_of(const Part& part) const {
    return {body_ends_.data() + part.first_end, part.ends};
  }
  // Where a body of the world stands in bodies_ or, in a plane, in body_links_.
  std::size_t member(std::size_t body) const;
  std::size_t part_of(std::size_t body) const { return plane_ ? kNone : member(body); }
  std::size_t body_link_of(std::size_t body) const { return plane_ ? member(body) : kNone; }
  std::size_t quaternion(std::size_t body) const { return links_.end() + 4 * body; }

  const World* world_ = nullptr;
  std::optional<Plane> plane_;
  std::optional<Vec3> left_plane_;
  std::vector<std::size_t> members_;  // indices into World::bodies, rising
  std::vector<Span> spans_;           // each one's first end is placed by those before it
  std::vector<End> ends_;
  std::vector<BodyLink> body_links_;
  std::vector<Part> bodies_;
  std::vector<std::size_t> body_ends_;  // body by body
  std::vector<char> placed_, done_;     // workspaces of order_spans(): bodies, spans
  std::vector<Coupling> couplings_;
  std::vector<std::size_t> coupled_;  // links with a row of the dense system
  Links links_;
  std::vector<Links::Link> measured_;  // what links_ is made of
  double length_ = 0, shortest_ = 0;   // m, of all links, of the shortest
  double velocity_time_ = 0;           // s
  double displacement_factor_ = 0;     // m, of displacement_bound()
  double cycles_ = 0;                  // of an acceleration
  double factored_sigma_ = 1;          // 1/s^2, of factor()

  bool floats_ = false;  // nothing prescribed: its centre of mass flies freely
  double mass_ = 0;      // kg
  double loaded_at_ = 0;
  Point centre_;                       // where it floats: of mass, at the time of loading
  Vec3 spin_momentum_ = Vec3::Zero();  // where it floats: kg m^2/s about the centre of mass

  // Per point of every span (one more than its links), and per body: mass, place.
  std::vector<double> point_mass_;
  std::vector<Point> points_, centres_, body_link_centres_;
  bool loops_ = false;       // some span closes one
  std::vector<Point> gaps_;  // per span, where it closes a loop
  Array still_;              // workspace of spread()
  // Workspaces of add_couplings().
  Array response_;
  Eigen::MatrixXd dense_, gain_, system_;
  Eigen::VectorXd dense_right_, share_;
  LinearSystem decomposed_;
};

/// Finds planes for nets. Keeps its workspace.
class PlaneFinder {
 public:
  /// Room for components of so many links.
  void reserve(std::size_t links) { vectors_.reserve(2 * links + kOthers); }
  /// The plane in which a component moves as far as its present state and its holds at `time` tell,
  /// if System can step it there. `also` is one more acceleration in that plane, or zero.
  std::optional<Plane> find(const World& world, const Component& component, double time,
                            const Vec3& also);

 private:
  static constexpr std::size_t kOthers = 16;  // vectors of holds and bodies
  std::vector<Vec3> vectors_, hints_;
};

}  // namespace taut::direct
