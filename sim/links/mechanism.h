// A world as an integrator sees it: one flat state vector, and the rows that links put on it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim/material/forces.h"
#include "sim/motion/rotation.h"
#include "sim/world/world.h"

namespace taut {

// A rigid body that hangs from one of its points, as a link.

/// Two point masses on a rigid line: `tip` at the point that it hangs from and `far` at `length`
/// from it, on the line through the centre of mass. Mass, centre and moment of inertia across the
/// line are those of the body: I + M a^2 = M a s, with a the arm of the centre of mass, s the
/// length of the equivalent simple pendulum. In plane motion that is all there is to the body, and
/// in space all where it has the same moment about every axis across the line and does not turn
/// about the line itself.
struct EquimomentalLink {
  double tip = 0, far = 0;  // kg
  double length = 0;        // m
  EquimomentalLink(double mass, double inertia, double arm)
      : far(mass * arm / ((inertia + mass * arm * arm) / (mass * arm))),
        length((inertia + mass * arm * arm) / (mass * arm)) {
    tip = mass - far;
  }
};

/// An index as rows and columns are kept, in half of the memory.
constexpr std::uint32_t small(std::size_t index) {
  return static_cast<std::uint32_t>(index);
}

/// One scalar condition between two points. A link is one row, along itself; a link of rest length
/// zero (a joint) is three rows, along the world's axes. Its tension (N) pulls the points together
/// where it is positive: `a` along the row's direction, `b` against it.
struct Row {
  static constexpr int kAlongLink = -1;
  std::uint32_t a = 0, b = 0;  // points
  double rest = 0;             // m
  int axis = kAlongLink;       // of a joint's row: 0, 1, 2
  bool pulls = false;          // a string: it may be shorter, and never pushes
  std::uint32_t connector = 0, link = 0;
};

/// A link that stretches is no row but a force (MaterialForces).
///
/// The points (all particles, connector by connector), free bodies, pulleys and rows of a world, as
/// flat arrays. The state vector of P points, B free bodies and S pulleys is
///   [ P positions | B poses: centre of mass, quaternion w x y z | S lengths passed | P velocities
///   | B twists: velocity of the centre of mass, spin in the world's axes | S speeds ],
/// 6 P + 13 B + 2 S numbers in SI units. Held points stand in it too: update() puts them where
/// their holds are, and their derivatives are zero. So do joined particles but the one that stands
/// for them, which rows and forces name.
///
/// Arrays of rows hold, behind them, one number for each pulley: beside tensions its acceleration
/// (m/s^2), beside impulses the change of its speed.
class Mechanism {
 public:
  /// A point that a free body carries; `arm` (m) from its centre of mass, world axes at the instant
  /// of the last update.
  struct BodyPoint {
    std::uint32_t point = 0, body = 0;
    Vec3 local = Vec3::Zero();  // m from the centre of mass, body axes
    Vec3 arm = Vec3::Zero();
  };
  /// An end of a row at a carried point. `sign` is +1 for the row's `a`, -1 for its `b`.
  struct RowEnd {
    std::uint32_t row = 0, body_point = 0;
    double sign = 0;
  };
  struct FreeBody {
    double inverse_mass = 0;      // 1/kg
    Mat3 inertia = Mat3::Zero();  // kg m^2, body axes
    FreeRotation rotation = FreeRotation(Mat3::Zero());
    Mat3 inverse_inertia = Mat3::Zero();  // 1/(kg m^2), body axes
    Mat3 world_inverse = Mat3::Zero();    // world axes at the instant of the last update
    Vec3 gyration = Vec3::Zero();         // rad/s^2: spin rate without torque, at that instant
  };

  Mechanism() = default;
  explicit Mechanism(const World& world) { rebuild(world); }

  /// Lays `world` out; good for as long as its topology number stays. Massless spans are laid out
  /// as links. Throws std::invalid_argument where a particle that nothing holds has no mass. Makes
  /// as much room as the world has, so that a later call does not allocate.
  void rebuild(const World& world);

  std::size_t state_size() const { return twists_ + 6 * bodies_.size() + pulleys(); }
  std::size_t points() const { return inverse_mass_.size(); }
  /// The sizes of a state and of arrays of rows that there is room for.
  std::size_t state_room() const { return state_size() + 6 * (room_ - points()); }
  std::size_t row_room() const { return rows_.capacity() + pulleys(); }
  const std::vector<Row>& rows() const { return rows_; }
  const std::vector<FreeBody>& bodies() const { return bodies_; }
  const std::vector<BodyPoint>& body_points() const { return body_points_; }
  /// The free body, of bodies(), and the direction (world axes) of a bend's clamp at the instant of
  /// the last place(). Nothing where no free body turns it.
  struct ClampOnBody {
    std::uint32_t body = 0;
    Vec3 direction = Vec3::Zero();
    Vec3 local = Vec3::Zero();  // the same in the body's axes
  };
  std::optional<ClampOnBody> clamp_on_body(const material::BendElement& bend) const;
  const std::vector<RowEnd>& row_ends() const { return row_ends_; }
  /// Whether connectors are joined, so that more than two rows of a kind may meet at a point.
  bool is_joined() const { return !joined_.empty(); }
  /// Whether some rows are strings.
  bool has_strings() const { return has_strings_; }
  /// 1/kg per point; zero for held points, carried ones included, and for those that others stand
  /// for.
  const std::vector<double>& inverse_mass() const { return inverse_mass_; }
  /// The point that stands for this one: itself, unless it is joined.
  std::size_t leader(std::size_t point) const { return leaders_.empty() ? point : leaders_[point]; }
  const Vec3& gravity() const { return gravity_; }
  /// Whether winches change lengths and masses with time.
  bool has_winches() const { return !winches_.empty(); }
  /// Adds the forces (N) at each point of the material that flows past it, at the instant of the
  /// last place(), pulleys' accelerations aside.
  void add_flow(const double* state, std::vector<Vec3>& force) const;
  /// The velocity (m/s) of rope that a winch moves past a point, at the instant of the last
  /// place().
  Vec3 flow_past(std::size_t point, const double* state) const;
  std::size_t pulleys() const { return pulleys_.size(); }
  /// The numbers in an array of rows, pulleys behind them.
  std::size_t unknowns() const { return rows_.size() + pulleys(); }
  /// The coupling of a row and a pulley: the derivative of the violation's second derivative by the
  /// pulley's acceleration, and the tension's coefficients in the pulley's equation.
  struct Coupling {
    std::uint32_t row = 0, pulley = 0;
    double share = 0;  // the link's, of the material that passes the pulley
    double value = 0;
    double drive = 0;   // -value where there is no friction
    double before = 0;  // in the tension before the pulley, without friction
  };
  const std::vector<Coupling>& couplings() const { return couplings_; }  // sorted by pulleys
  /// A link that stretches, of material().stretches(), and its share of what passes a pulley.
  struct SoftCoupling {
    std::uint32_t stretch = 0, pulley = 0;
    double share = 0;
  };
  const std::vector<SoftCoupling>& soft_couplings() const { return soft_couplings_; }
  /// The inertia (kg) in a pulley's equation (row) against the acceleration of each (column).
  const Eigen::MatrixXd& passing_inertia() const { return passing_inertia_; }

  // A pulley's equation with all accelerations in it, for methods that solve velocities and
  // tensions together: what its rope drives it with, less its inertia, the forces of passing rope
  // and tensions over the shares of the links in couplings(). The part of the rope before the
  // pulley stands alone too, because friction there depends on it.

  /// Finds the forces that each_passing() visits, at the instant of the last place().
  void find_passing(const double* state);
  /// Visits the points of the rope before (0) or behind (1) a pulley, with the force (N per m/s^2)
  /// on each by the pulley's acceleration.
  template <class Visit>
  void each_passing(std::size_t pulley, std::size_t side, Visit visit) const {
    const RopeEnd& end = pulleys_[pulley].end[side];
    const std::uint32_t first = winches_[end.winched].first_point;
    for (std::uint32_t i = 0; i < end.force.size(); ++i) visit(first + i, end.force[i]);
  }
  /// Whether a point is of the rope before or behind a pulley.
  bool is_at_pulley(std::size_t pulley, std::uint32_t point) const {
    const auto holds = [&](const RopeEnd& end) {
      const std::uint32_t first = winches_[end.winched].first_point;
      return point >= first && point - first < end.force.size();
    };
    return holds(pulleys_[pulley].end[0]) || holds(pulleys_[pulley].end[1]);
  }
  /// The mass (kg) in a pulley's equation against the acceleration of `other`: all of it, or that
  /// of half the sheave and the rope before it.
  double passing_mass(std::size_t pulley, std::size_t other, bool before) const;
  /// The force (N) that drives a pulley without tensions, under `acceleration` of points.
  double passing_drive(std::size_t pulley, const double* state,
                       std::span<const Vec3> acceleration) const;
  /// The same force of the rope before the pulley, less the force that turns the rope there.
  double drive_before(std::size_t pulley, const double* state,
                      std::span<const Vec3> acceleration) const;
  /// The ratio of the larger tension to the smaller at which rope slides.
  double slide_ratio(std::size_t pulley, const double* state) const;
  /// How the velocity of rope past a point, flow_past(), grows with the speed of a pulley: by the
  /// rope before it (0) or behind it (1).
  Vec3 flow_by(std::size_t pulley, std::size_t side, std::size_t point, const double* state) const;

  /// The state of friction at a pulley.
  enum class Slip {
    free,      // no friction, or the rope pushes
    forwards,  // the rope slides into the connector behind
    backwards,
    stick,
  };
  void set_slip(std::size_t pulley, Slip slip) { pulleys_[pulley].slip = slip; }
  Slip slip(std::size_t pulley) const { return pulleys_[pulley].slip; }
  bool has_friction(std::size_t pulley) const { return pulleys_[pulley].has_friction; }
  /// The tensions (N) before and behind a pulley with friction, less the force that turns the rope
  /// there and half of the force that turns the sheave; and the ratio of the larger to the smaller
  /// at which the rope slides. `tension`: of the rows, then the accelerations of the pulleys.
  struct Pull {
    double before = 0, behind = 0, ratio = 1;
  };
  Pull pull_at(std::size_t pulley, const double* tension) const;
  /// The force (N) of the rope on the winch or pulley at a connector's first (0) or last (1) end,
  /// from tensions and accelerations (m/s^2) of all points of the same instant.
  double drum_force(std::size_t connector, std::size_t end, const double* state,
                    const double* tension, std::span<const Vec3> acceleration) const;
  /// The forces of what stretches, bends and meets the air; place() turns its clamps.
  const material::MaterialForces& material() const { return material_; }

  // Offsets into the state.
  std::size_t position(std::size_t point) const { return 3 * point; }
  std::size_t velocity(std::size_t point) const { return velocities_ + 3 * point; }
  std::size_t pose(std::size_t body) const { return 3 * points() + 7 * body; }
  std::size_t twist(std::size_t body) const { return twists_ + 6 * body; }
  std::size_t passed(std::size_t pulley) const { return velocities_ - pulleys() + pulley; }
  std::size_t speed(std::size_t pulley) const { return twists_ + 6 * bodies_.size() + pulley; }

  /// Reads the state of `world`, which must stay until the state is stored again.
  void load(const World& world, std::vector<double>& state);
  /// Writes the state, at `time`, to `world`.
  void store(const std::vector<double>& state, double time, World& world) const;

  /// Tells that the state was reached, so that twist is followed over any number of turns.
  void follow(double time, const std::vector<double>& state);

  /// Puts held points at their places, and gives winched links their lengths.
  void place(double time, double* state);
  /// The same, and measures the rows, without the forces.
  void place_and_measure(double time, double* state) {
    place(time, state);
    measure(state);
  }
  /// place(), and measures the rows; everything below speaks of the instant of the last update.
  void update(double time, double* state);

  /// Per row: direction from a to b (zero where they coincide), how far it is too long (m), and the
  /// rate of that (m/s).
  const std::vector<Vec3>& direction() const { return direction_; }
  const std::vector<double>& violation() const { return violation_; }
  const std::vector<double>& rate() const { return rate_; }
  /// Per point, m/s^2: its acceleration without tensions, or that with which it is held.
  const std::vector<Vec3>& point_acceleration() const { return point_acceleration_; }

  /// The derivative of the state under the rows' `tension` (N).
  void differentiate(const double* state, const double* tension, double* derivative) const;
  /// Changes velocities by the rows' `impulse` (N s).
  void push(const double* impulse, double* state) const;
  /// Moves points and bodies as push() changes velocities: by M^-1 J^T `shift` (kg m).
  void move(const double* shift, double* state) const;

  /// The second derivative of a row's violation without tensions, m/s^2.
  double free_acceleration(std::size_t row) const {
    return direction_[row].dot(point_acceleration_[rows_[row].b] -
                               point_acceleration_[rows_[row].a]) +
           velocity_term_[row];
  }

  /// The rows' free accelerations, and what drives the pulleys, as TensionSystem takes them.
  void right_side(std::vector<double>& right) const;

  /// The cycles (see Counters::cycles) of update(), differentiate() and the sums that an integrator
  /// makes of it: of a row some 85 additions and multiplications, two divisions and a root; of a
  /// body three products of matrices and what turns it.
  double cycles() const {
    return 250 + material_.cycles() + 58 * static_cast<double>(rows_.size()) +
           550 * static_cast<double>(bodies_.size());
  }

  struct Link {
    std::size_t connector = 0, link = 0;
  };
  /// The first link whose points are not finite or beyond any sense (a rigid one stretched a
  /// hundredfold).
  std::optional<Link> broken_link(const double* state) const;
  /// A connector whose links are under a hundredth of what they were as its rope has run through a
  /// pulley, where it whirls too fast and then is none.
  std::optional<std::size_t> run_through(double time, double* state);

 private:
  void reserve(const World& world);
  void add_bodies(const World& world);
  void add_points(const World& world);
  void join_points(const World& world);
  void add_rows(const World& world);
  void add_row_ends();
  void add_winches(const World& world);
  void find_winched_joints(const World& world);
  void add_pulleys(const World& world);
  void place_winches(double time, const double* state);
  void measure_winches();
  void measure_pulleys(const double* state);
  void add_forces(const double* state);
  void measure(const double* state);

  /// A connector whose links change their lengths; where its points and rows begin.
  struct Winched {
    std::shared_ptr<const Winch> winch;
    std::uint32_t connector = 0, first_point = 0;
    std::uint32_t first_row = 0;                      // of rigid links
    std::optional<std::uint32_t> first_stretch = {};  // of links that stretch
    std::vector<double> squared_stretch = {};  // per link that stretches: (length / rest length)^2
    std::optional<std::uint32_t> first_drag = {};  // where it meets the air
    std::uint32_t first_bend = 0, bends_end = 0;   // where it resists bending
    PaidOut first = {}, last = {}, longer = {};    // at the instant of the last place()
  };

  /// The accelerations of a free body under a material's forces at its points: m/s^2 and rad/s^2.
  struct BodyPush {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  };

  /// A connector's end at a pulley: the forces of the passing material at its points, N per m/s^2.
  struct RopeEnd {
    std::uint32_t connector = 0, winched = 0;
    std::vector<Vec3> force = {};
    std::vector<std::uint32_t> carried = {};                      // body points among them
    std::vector<std::pair<std::uint32_t, BodyPush>> pushes = {};  // bodies
  };
  /// A pulley, with the terms of its acceleration.
  struct Passing {
    double inertia = 0;  // kg, of the sheave
    bool has_friction = false;
    double friction = 0, bearing = 0;  // see Pulley
    bool has_mass = false;             // the rope
    std::array<RopeEnd, 2> end = {};   // that it passes from, and to
    double free_force = 0;             // N: the drive without tensions
    Slip slip = Slip::free;
    // With friction alone: the ratio of the tensions where rope slides; the pull before the pulley
    // without tensions (N), and by the accelerations of all pulleys (kg).
    double ratio = 1, before = 0;
    Eigen::VectorXd before_inertia = {}, inertia_of_all = {};

    /// The excess of the pull behind over the pull before, as a share of the latter.
    double excess() const {
      return slip == Slip::forwards ? ratio - 1 : slip == Slip::backwards ? 1 / ratio - 1 : 0;
    }
  };
  /// The force (N) in Lagrange's equation for the length that an end pays out, as seen from
  /// `frame`, the links' tensions aside.
  double paying_force(const Winched& at, std::size_t end, const double* state,
                      std::span<const Vec3> acceleration, const PointMotion& frame) const;
  double bending_force(const Winched& at, const double* state) const;
  double paid_pull(std::size_t stretch, const double* state) const;
  double rest_of(const Winched& at, std::size_t link) const {
    return at.first_stretch ? material_.stretches()[*at.first_stretch + link].rest
                            : rows_[at.first_row + link].rest;
  }
  double passing_inertia(const Passing& pulley, std::size_t side, const Passing& other) const;
  void measure_friction(std::size_t pulley, const double* state);
  void use_friction();
  void give_unit(const RopeEnd& end);
  void clear_unit(const Passing& pulley);
  double flow_inertia(const Winched& at, std::size_t end, std::size_t other) const;
  void find_flow(Passing& pulley, const double* state) const;
  Vec3 way_at(const Winched& at, std::size_t particle, const double* state) const;
  template <class Visit>
  void each_moved(const RopeEnd& end, Visit visit) const;
  void push_pulleys(const double* by, double* velocities, double* speeds) const;

  const World* world_ = nullptr;  // between load() and store()
  std::size_t room_ = 0;          // points
  Vec3 gravity_ = Vec3::Zero();
  std::vector<double> inverse_mass_;
  std::vector<Row> rows_;
  bool has_strings_ = false;
  std::vector<FreeBody> bodies_;
  std::vector<std::size_t> body_index_;  // into World::bodies
  std::vector<std::size_t> free_index_;  // of World::bodies into bodies_; driven ones: anything
  std::vector<BodyPoint> body_points_;
  std::vector<RowEnd> row_ends_;
  std::vector<std::pair<std::uint32_t, Attachment>> prescribed_;  // point, hold
  std::vector<std::uint32_t> leaders_;  // per point: the one that stands for it; none: no joints
  std::vector<std::pair<std::uint32_t, std::uint32_t>>
      joined_;                               // point, the one that stands for it
  std::size_t velocities_ = 0, twists_ = 0;  // offsets

  std::vector<Vec3> direction_;
  std::vector<Vec3> point_acceleration_;  // per point, m/s^2: its acceleration without tensions
  std::vector<double> violation_, rate_, velocity_term_;
  material::MaterialForces material_;
  std::vector<Winched> winches_;
  // Of joints with a particle of a winch's connector, by the points that stand for them:
  std::vector<std::uint32_t> winched_leaders_;
  std::vector<char> is_winched_group_;
  std::vector<double> kept_mass_, joined_mass_;  // kg: of the other particles, and of all
  std::vector<Passing> pulleys_;
  std::vector<Coupling> couplings_;
  std::vector<SoftCoupling> soft_couplings_;
  Eigen::MatrixXd passing_inertia_;
  std::vector<Vec3> unit_;   // per point: what one pulley's acceleration of 1 m/s^2 gives it
  std::vector<Vec3> force_;  // N, per point, of the material and of its flow
  std::vector<BodyPush> body_push_;
};

// The quaternion w x y z at `q`.
Quat quaternion(const double* q);
void set_quaternion(const Quat& rotation, double* q);
/// Turns it by `angle` (rad, world axes).
void rotate(const Vec3& angle, double* q);
/// The angle (rad) and axis of a rotation; at most half a turn.
Vec3 angle(const Quat& rotation);

}  // namespace taut
