// The smooth motion of links whose beads touch obstacles, the events that end it, and the linear
// systems of its links' impulses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/body_contacts.h"
#include "sim/contact/touch.h"
#include "sim/links/linear_systems.h"
#include "sim/links/mechanism.h"
#include "sim/world/obstacle.h"

namespace taut::contact {

// The linear systems of the rows of links whose particles respond to pulls in ways of their own,
// and ones whose matrix has a narrow band.

/// The ends of rows at free bodies that rows meet in several points; indices into row_ends().
/// `together`, per body: the number of those that may touch each other and count as one; empty:
/// each by itself.
std::vector<std::size_t> ends_that_meet(const Mechanism& mechanism,
                                        std::span<const std::uint32_t> together = {});

/// A x = b over the rows of a mechanism, where A(r, s) says by how much row r stays shorter under a
/// pull along row s. Particle p moves by mobility[p] times what pulls it (1/kg): a multiple of the
/// identity where it is free; less across a surface; not symmetric where it slides with friction.
/// Rows pull along `right` and are measured along `left`, unit vectors. Body b responds to what
/// pulls it, and what pulls those that it touches, as `bodies` says, or freely for null.
///
/// Linear time: elimination along the connectors, and by Woodbury's identity a dense system for the
/// rows that meet in free bodies which have several. A row that nothing can change, or that its
/// neighbours determine already, is left out: its x is zero.
class RowSystem {
 public:
  void rebuild(const Mechanism& mechanism, std::span<const std::uint32_t> together = {});

  void assemble(const Mechanism& mechanism, std::span<const Mat3> mobility,
                std::span<const Vec3> left, std::span<const Vec3> right,
                const BodyMobility* bodies = nullptr);
  /// In place.
  void solve(std::span<double> x) const;
  bool left_out(std::size_t row) const { return inverse_pivot_[row] == 0; }

 private:
  void add_bodies(const Mechanism& mechanism, std::span<const Vec3> left,
                  std::span<const Vec3> right, const BodyMobility* bodies);
  void eliminate();
  void sweep(std::span<double> x) const;

  std::vector<double> diagonal_, lower_, upper_, inverse_pivot_;  // 1/kg, kg
  std::vector<double> scale_;                      // 1/kg, of the row's ends as they respond
  std::vector<std::size_t> border_, border_rows_;  // ends of rows at bodies that have several
  std::vector<double> columns_;  // what a pull along each of those rows would take, A without them
  Eigen::MatrixXd coupling_;
  LinearSystem decomposed_;
  mutable Eigen::VectorXd share_, given_;
};

/// Between events the set of closed touches stays, and each of them slides or sticks: then links
/// and touches are equations, and accelerations follow from one linear system. Events are: a bead
/// or a body's capsule arrives, a touch would have to pull, friction is exhausted, sliding ends; a
/// string goes taut, or would have to push; a link is led apart between what sticks. resolve()
/// finds the velocities and the active set that follow, by the laws of Signorini, Coulomb and
/// Newton.
///
/// No bead may touch two obstacles at once; a body may. Where links touch, too, beads and links are
/// to this class what bodies are, and all that touches responds together with all links: one dense
/// system.
class ContactMotion {
 public:
  using State = std::vector<double>;  // as Mechanism has it

  /// A state that has no solution, or none that is found.
  struct Unresolved {
    std::size_t row = 0;
    const char* what = "";
  };

  /// Call when the topology is new. Bounces slower than `slowest` (m/s) are not followed.
  void rebuild(const World& world, double slowest);
  void load(const World& world, State& state) { mechanism_.load(world, state); }
  void store(const State& state, double time, World& world) const {
    mechanism_.store(state, time, world);
  }

  /// Brings the first state to lengths and surfaces, and resolves it. Throws Unresolved.
  void begin(double time, State& state);
  /// The derivative of a state under the active set.
  void differentiate(double time, const State& state, State& derivative);
  /// Back to lengths, surfaces and what sticks; returns the largest violation (m) that is left.
  double project(double time, State& state);
  /// Functions of the state that are positive until an event.
  void events(double time, const State& state, std::vector<double>& values);
  /// The jump of the velocities, where beads arrive, and the active set from now on. Throws
  /// Unresolved.
  void resolve(double time, State& state);

  const Mechanism& mechanism() const { return mechanism_; }
  std::uint64_t solves() const { return solves_; }

 private:
  static constexpr double kStill = 1e-10;  // m/s: slower is no sliding
  /// m/s: the same of two bodies, whose turns let it waver by more.
  static constexpr double kStillOfTwo = 2e-9;
  /// m/s: the same where links touch. Several slides that slow each other pass rest by as much.
  static constexpr double kStillOfLinks = 1e-7;
  static constexpr double kTouching = 1e-11;  // of the longest connector

  enum class Mode { open, slides, sticks };
  struct Bead {
    Mode mode = Mode::open;
    std::uint32_t obstacle = 0;
    Vec3 anchor = Vec3::Zero();  // m, where it sticks, in the obstacle's frame
    Vec3 ahead = Vec3::Zero();   // the way in which it slid when that began
    Touch touch;                 // of velocities or accelerations, as asked last
  };

  /// Velocities of all. Of points that bodies carry those of the bodies count.
  struct Motion {
    std::vector<Vec3> points;  // m/s
    std::vector<Vec6> bodies;
  };

  /// A bead, or a link between two, where links touch. Parts are numbered behind the bodies.
  struct Part {
    std::uint32_t first = 0, next = 0;  // points; the same: a bead
    double radius = 0;                  // m
    bool is_bead() const { return first == next; }
  };

  Vec3 place(const State& state, std::size_t point) const;
  Vec3 velocity(const State& state, std::size_t point) const;
  void move_obstacles(double time);
  PointMotion surface(const Bead& bead, const Vec3& at) const;
  double least_acceleration(const Bead& bead, const Vec3& at, const Vec3& velocity) const;
  void accelerate(double time, const State& state);
  Vec3 plane_of(const State& state) const;
  Vec3 heading(const Vec3& across, const Vec3& ahead) const;
  Response response(Bead& bead, const Vec3& bare) const;
  void find_touches(const State& state);
  bool arrive(double time, State& state);
  bool is_driven() const;
  double energy_of(const State& state, const Motion& one, const Motion& other) const;
  Motion after_impact() const;
  void lower_bounces(const State& state);
  void choose(double time, const State& state);
  double margin(std::size_t point, const Vec3& more) const;
  void centre();
  void balance(std::span<const double> start);
  double measure(std::span<const double> start);
  double until_it_slides(std::size_t row, double error) const;
  void relax(std::span<const double> start);
  void relax_row(std::size_t row, double start);
  std::span<const Vec3> pulling();
  bool find_taut(double time, State& state);
  void sort_strings();
  double spare(std::size_t row) const;
  double inverse_mass(std::size_t point) const;

  // Of free bodies.
  void rebuild_bodies(const World& world);
  Capsule capsule(const State& state, std::size_t body) const;
  Vec6 twist(const State& state, std::size_t body) const;
  Pose solid(const BodyMeeting& meeting, const State& state) const;
  SpotGap aim(BodyTouch& at, const State& state) const;
  Vec3 where(const BodyTouch& at, const State& state) const;
  Vec3 passing(const BodyTouch& at, const State& state) const;
  double still(const BodyTouch& at) const {
    if (!parts_.empty()) return kStillOfLinks;
    return at.other == kNoBody ? kStill : kStillOfTwo;
  }
  double quickness(const BodyTouch& at, const State& state) const;
  void ask_accelerations(BodyTouch& at, const State& state) const;
  void free_bodies(const State* velocities);
  void free_mobilities();
  void add_twists(std::span<const BodyTouch> touches, std::span<Vec6> twists) const;
  void couple_bodies(std::span<const double> tension, std::span<const Vec3> along, bool held);
  void aim_bodies(const State& state);
  double project_bodies(State& state);
  void shift_bodies(std::span<const Vec3> along, bool poses, State& state);
  /// The event of a distance (m) that falls below zero. A distance below zero by rounding, that
  /// returns, is none.
  double crossing(double distance, bool returns) const {
    constexpr double kRounding = 100;  // times touching_
    return distance < 0 && distance > -kRounding * touching_ && returns ? touching_ : distance;
  }
  void body_events(const State& state, std::vector<double>& values) const;
  void add_ways_of_bodies(const State& state, std::vector<Vec3>& places,
                          std::vector<Vec3>& ways) const;
  bool turn_within(const State& state, const Vec3& normal) const;
  void find_body_touches(const State& state);
  bool bodies_arrive(const State& state);
  void ask_of_bodies(const State& state);
  void gather();
  void take_touches();

  // Where links touch.
  void rebuild_parts(const World& world);
  bool is_part(std::uint32_t one) const { return one >= capsules_.size(); }
  const Part& part(std::uint32_t one) const { return parts_[one - capsules_.size()]; }
  Capsule capsule_of_part(const State& state, const Part& part) const;
  SpotGap gap_of_part(const BodyTouch& at, const Pose& place, const Capsule& own) const;
  Vec3 velocity_of_part(const BodyTouch& at, const State& state) const;
  Vec3 led(const State& state, std::uint32_t point) const;
  void ask_of_part(BodyTouch& at, const State& state) const;
  double slope(const BodyMeeting& meeting, const State& state, double along) const;
  bool is_place(const BodyMeeting& meeting, const State& state, const std::array<SpotGap, 5>& gaps,
                Spot spot) const;
  void leave_to_links();
  void part_events(const BodyTouch& at, const State& state, std::vector<double>& values) const;
  double inverse_mass(const BodyTouch& at) const;
  Vec3 weight(std::size_t point) const;
  double stir(const BodyTouch& at) const;
  double off(const BodyTouch& at) const;
  std::uint32_t carrier(std::uint32_t point) const;
  Motion no_motion() const;
  Vec3 velocity_of(const Motion& motion, std::uint32_t point) const;
  Vec3 passing(const Motion& motion, const BodyTouch& at) const;
  void give(std::uint32_t point, const Vec3& impulse, Motion& motion) const;
  void give(const BodyTouch& at, const Vec3& impulse, Motion& motion) const;
  void pull(std::span<const double> tension, std::span<const Vec3> along, Motion& motion) const;
  std::vector<double> answer(std::span<const double> rate, std::span<const Vec3> along,
                             Motion& motion) const;
  std::span<const Vec3> assemble_together();
  bool respond_together(std::span<const double> start, bool held);
  void balance_together(std::span<const double> start);
  bool swap_strings(bool all);
  double project_together(double time, State& state);
  void shift(const Motion& way, bool places, State& state) const;

  std::vector<Obstacle> obstacles_;
  Mechanism mechanism_;
  RowSystem system_;
  double slowest_ = 0, touching_ = 0;    // m/s, m
  std::vector<double> radius_;           // per point, m; negative: it touches nothing
  std::vector<std::uint64_t> category_;  // per point
  std::vector<Bead> beads_;              // per point
  std::vector<FrameMotion> frames_;      // of the obstacles
  std::vector<char> is_carried_;         // per point: a free body has it
  std::vector<BodyCapsule> capsules_;    // per free body, from its centre of mass
  std::vector<Part> parts_;              // none where no links touch
  std::vector<BodyMeeting> meetings_;    // of free bodies and parts
  std::vector<BodyTouch> body_touches_;  // those that are closed, in order of clusters
  Clusters clusters_;
  BodySystem body_system_;
  Vec3 aside_ = Vec3::Zero();  // out of the plane of the motion, where there is one
  State scratch_;
  // Per point, of velocities or accelerations: without links, what links add, what links and
  // touches add.
  std::vector<Vec3> free_, pulled_, added_;
  std::vector<Vec6> body_free_, body_pulled_, body_added_;  // the same of twists, per body
  std::vector<Mat6> body_mobility_;                         // per body, by itself
  BodyMobility body_coupled_;
  std::vector<Vec6> twists_;              // per body, scratch
  std::vector<Mat3> mobility_;            // per point, 1/kg
  std::vector<double> tension_, change_;  // per row
  std::vector<double> start_;             // per row, of what is asked
  // Where there are strings, per row: whether it is a rod or as long as it may be; whether it pulls
  // besides; the directions of those that do, zero for the others.
  std::vector<char> taut_, pulls_;
  std::vector<Vec3> along_;
  std::uint64_t solves_ = 0;
};

}  // namespace taut::contact
