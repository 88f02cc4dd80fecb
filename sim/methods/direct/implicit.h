// Worlds of any combination of features: one implicit step of them, and its error control.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/links/mechanism.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/spans.h"
#include "sim/methods/direct/sparse_system.h"
#include "sim/methods/direct/touches.h"
#include "sim/run/method.h"
#include "sim/world/world.h"

namespace taut::direct {

// One implicit step of a world with any combination of features.

/// A state of the world from which a step may start.
struct StepState {
  double time = 0;              // s
  std::vector<double> state;    // as Mechanism has it
  std::vector<double> tension;  // N, per link: of the elastic part where it stretches
  std::vector<double> rate;     // of the unknown velocities, per second; empty after a jump
  /// A contact: a candidate whose gap is closed.
  struct Contact {
    std::uint32_t candidate = 0;
    Vec3 force = Vec3::Zero();   // N, of the last stage
    Vec3 slip = Vec3::Zero();    // m/s, across the normal; zero below what counts as rest
    bool sticks = true;          // at rest, with static friction
    bool presses = false;        // in the last stage
    bool grips = false;          // there, with less friction than would make it slide
    bool is_anchored = false;    // a bead that has gripped since it was at `anchor`
    Vec3 anchor = Vec3::Zero();  // m, as Meeting::local
  };
  std::vector<Contact> contacts;  // by candidates
  /// Candidates of links that are inside each other and do not touch until they are apart: rope
  /// that a cut freed can slide into rope near the cut.
  std::vector<std::uint32_t> inside;
  std::vector<char> taut;  // per link: of a string, at its length
  /// An impulse (N s) of the jump at the end, of a contact or a link.
  struct Impulse {
    std::uint32_t of = 0;  // the candidate or the link
    bool contact = false;
    Vec3 place = Vec3::Zero();  // m, of a contact
    double size = 0;
  };
  std::vector<Impulse> impulses;
  std::vector<Mechanism::Slip> slips;  // per pulley, in the last stage
  /// Of what presses, pulls and slides, as a number.
  std::uint64_t pattern() const;
};

/// SDIRK of order 2 (Alexander, Diagonally implicit Runge-Kutta methods for stiff O.D.E.'s, SIAM J.
/// Numer. Anal. 14, 1977; gamma = 1 - 1/sqrt 2, L-stable, stiffly accurate) for the velocities,
/// with all conditions on rates: links keep their lengths, closed contacts their gaps. Stages are
/// solved by Newton's method on velocities, tensions and contact forces together. After the step,
/// places are projected onto lengths and surfaces. Arrivals (a bead at a surface, a string at its
/// length) end a step; then velocities jump by the law of impact.
class ImplicitStep {
 public:
  void rebuild(const World& world);
  /// Reads the world's state, and makes places and velocities consistent. False where that fails.
  bool load(const World& world, StepState& to, double touching);
  void store(const StepState& from, World& world);

  enum class Result {
    done,
    arrives,  // something arrives on the way, at arrival()
    failed,   // Newton's method found no solution
  };
  /// The two stages of a step of `h` (s). With `stops` set it looks for what arrives on the way and
  /// ends more than `touching` (m) inside. Call finish() with what it makes.
  Result step(const StepState& from, double h, double touching, bool stops, StepState& to);
  /// Puts places onto lengths and surfaces. With `jumps` set, what is nearer than `touching` (m)
  /// becomes a contact, and what has arrived stops or bounces.
  bool finish(StepState& to, double touching, bool jumps);
  /// Velocities of points and twists of bodies, as unknowns.
  void gather(std::span<const double> state, std::vector<double>& unknowns) const;
  std::size_t velocities() const { return first_link_; }
  /// Whether velocities jumped in the last finish().
  bool jumped() const { return jumped_; }
  /// Call after a step that goes on: what slides may slide back in the next one.
  void accept() { reversing_.clear(); }
  /// The distance (m) of the ends of two steps from one state, RMS over points and bodies, with
  /// velocities times `time` (s). The matrix of the last stage filters the difference: a motion
  /// much faster than the step counts less (Hairer and Wanner, Solving ODEs II, IV.8).
  double distance(const StepState& one, const StepState& other, double time);
  /// Moves `one` of the last distance() by a share of the filtered difference. With the filter,
  /// Richardson's extrapolation stays stable for undamped oscillations of any frequency.
  void extrapolate(double share, StepState& one) const;
  double arrival() const { return arrival_; }  // s after the start, estimated
  /// When (s, from now) the first of all that is apart by more than `touching` (m) arrives, if
  /// unknown velocities go on changing at `rate` (1/s, none: empty). Infinite where nothing does.
  double next_arrival(const StepState& from, std::span<const double> rate, double touching);

  /// Steps go with that share of friction: jammed contacts may have no solution with all of it
  /// (Painleve, Sur les lois du frottement de glissement, Comptes Rendus 121, 1895).
  void set_friction_share(double share) { friction_share_ = share; }

  struct Link {
    std::uint32_t a = 0, b = 0;
    bool soft = false, pulls = false;
    bool soft_string = false;  // soft, and pulls alone: while it is slack, its tension is negative
    std::uint32_t row = 0;     // of the mechanism's rows or stretches
    double inertia = 1;        // kg, that a tension moves
  };
  /// The acceleration (m/s^2) of a point in the last stage of the step that made `to`. A point that
  /// is fixed or follows a path has none.
  std::optional<Vec3> acceleration(std::size_t point, const StepState& to) const;
  /// The touching point (m) of a candidate, on the surface of what it may touch.
  Vec3 place_of(std::uint32_t candidate, const Meeting& at, const std::vector<double>& state) const;
  const std::vector<Link>& links() const { return links_; }
  Touches& touches() { return touches_; }
  const Mechanism& mechanism() const { return mechanism_; }
  Mechanism& mechanism() { return mechanism_; }
  std::uint64_t factorisations() const {
    return stage_system_.factorisations() + jump_system_.factorisations();
  }
  /// Bounces slower than `bounce` (m/s) are taken for none, slips slower than `slip` for rest.
  void set_lowest_speeds(double bounce, double slip) {
    lowest_bounce_ = bounce;
    lowest_slip_ = slip;
  }

 private:
  using Contact = StepState::Contact;
  /// A place whose velocity depends on the unknowns at `at`: three of a point, or six of a body.
  struct Handle {
    std::uint32_t at = 0;
    bool body = false;
    double weight = 0;
    Vec3 arm = Vec3::Zero();
  };
  /// A sum of weighted velocities of places, such as that of one end of a link past the other.
  struct Relative {
    std::array<Handle, 4> handles;
    int count = 0;
    void add(const Handle& handle) { handles[static_cast<std::size_t>(count++)] = handle; }
    std::span<const Handle> all() const {
      return {handles.data(), static_cast<std::size_t>(count)};
    }
  };
  /// A link of a rope that passes a pulley, and its share of what passes.
  struct LinkAtPulley {
    std::uint32_t link = 0, pulley = 0;
    double share = 0;
  };
  /// How a projection of places holds a contact.
  enum Grip : char { kFree, kAtSurface, kAtAnchor };
  /// What is asked of the unknowns.
  struct Problem {
    enum class Law { contact, projection };
    Law law = Law::contact;
    double inertia = 1;  // 1/s: 1 / (gamma h) in a stage, 1 where velocities jump
    double advance = 0;  // s: gamma h in a stage, 0 where places stay
    bool forces = false;
    double time = 0;
  };

  void lay_out(const StepState& from);
  void add_handles(std::uint32_t point, double weight, Relative& to) const;
  Relative relative(std::uint32_t a, std::uint32_t b) const;
  Relative relative(const Candidate& of, const Meeting& at) const;
  /// A touching point that moves along its link as the link turns, so that it stays the nearest.
  struct Slide {
    Relative ends;  // the way along which it moves, as velocities turn it
    Vec3 along = Vec3::Zero(), passes = Vec3::Zero();  // m, and its rate: m/s
    bool moves = false;
  };
  int slides(const Candidate& of, const Meeting& at, std::array<Slide, 2>& made) const;
  void turn_normal(const Problem& problem, std::size_t contact, const Mat3& by_n, const Vec3& force,
                   Mat3& by_v);
  void push(const Relative& at, const Vec3& force);
  void block(const Relative& row, const Relative& column, const Mat3& value);
  void row(std::size_t index, const Relative& column, const Vec3& value);
  void column(std::size_t index, const Relative& row, const Vec3& value);
  void put(std::size_t r, std::size_t c, double value) {
    if (assembles_) system_->add(r, c, value);
  }
  void entry(std::size_t r, std::size_t c, double value) {
    put(r, c, value * row_scale_[r] * column_scale_[c]);
  }
  void place_unknowns(const Problem& problem);
  void scale(const Problem& problem);
  void assemble(const Problem& problem, double kappa);
  void assemble_inertia(const Problem& problem);
  void assemble_materials(const Problem& problem);
  void assemble_applied(const Problem& problem);
  void assemble_twists(const Problem& problem);
  void assemble_links(const Problem& problem, double kappa);
  void assemble_contacts(const Problem& problem, double kappa);
  /// A pulley's row: `all` times its balance, and `before` times the pull before it, both as
  /// find_balance() has them.
  struct PulleyLaw {
    Mechanism::Slip slip = Mechanism::Slip::free;
    double all = 1, before = 0;
  };
  /// How the velocity of rope at a contact grows with the speed of a pulley, across the normal.
  struct FlowBy {
    Vec3 all = Vec3::Zero(), before = Vec3::Zero();
  };
  bool flows_at(const Candidate& of, std::size_t pulley) const;
  FlowBy flow_by(std::size_t pulley, std::size_t contact) const;
  void assemble_pulleys(const Problem& problem);
  void find_balance(const Problem& problem, std::size_t pulley, double& balance, double& before);
  PulleyLaw find_law(const Problem& problem, std::size_t pulley, double balance, double before,
                     double& value) const;
  Vec3 moves(const Relative& of, std::span<const double> by) const;
  void add_passing_difference(const StepState& one, const StepState& other);
  void solve_with_twists();
  bool goes_the_same_way() const;
  bool has_tautened() const;
  double length_of(const Link& link, const std::vector<double>& state) const;  // m
  bool iterate(const Problem& problem, double kappa, int most, double enough);
  void guess(double time, const std::vector<double>& rate);
  bool is_decided(double kappa) const;
  bool follow_central_path(const Problem& problem, double kappa, int most, double enough);
  double roundings(const Problem& problem) const;
  bool harden_friction(const Problem& problem, const std::vector<double>& start, double enough);
  bool solve(const Problem& problem);
  bool project(StepState& to, double touching);
  bool project_places(StepState& to, double allowed);
  bool project_velocities(StepState& to);
  void start_at(const StepState& from);
  void start_projection(const StepState& at, const Problem& problem);
  Vec3 direction(const Link& link) const;
  double held_rate(const Link& link) const;
  bool let_impacts_slide();
  bool jump(StepState& to, std::span<const double> before);
  double energy_of(const std::vector<double>& one, const std::vector<double>& other) const;
  void find_contacts(const StepState& at, double touching, std::vector<Contact>& contacts);
  void keep_contacts(StepState& to);
  void find_inside(double touching, bool fresh, StepState& to);
  void note_impulses(StepState& to);
  bool presses(std::size_t c) const;
  void hold_contacts();
  void measure_speed(const StepState& at);
  struct Gap {
    double gap = 0, rate = 0;  // m, m/s
    Vec3 normal = Vec3::Zero();
  };
  Gap gap(std::uint32_t candidate, const std::vector<double>& state) const;
  Gap gap(std::uint32_t candidate) const { return gap(candidate, state_); }
  void find_near(const StepState& from, const StepState& to);
  double fastest_pass(const StepState& from, const StepState& to, double h,
                      const Candidate& of) const;
  double first_pass(const StepState& from, const StepState& to, double h, double touching,
                    std::uint32_t candidate);
  void place_between(const StepState& from, const StepState& to, double h, double share);
  double first_dip(const StepState& from, const StepState& to, double h, double touching,
                   std::uint32_t candidate);
  double first_arrival(const StepState& from, const StepState& to, double h, double touching);

  const World* world_ = nullptr;
  Mechanism mechanism_;
  Touches touches_;
  SparseSystem stage_system_, jump_system_;  // of stages; where velocities or places jump
  SparseSystem* system_ = &stage_system_;
  std::vector<std::uint32_t> groups_;              // of unknowns, in the present layout
  bool stage_is_new_ = true, jump_is_new_ = true;  // that layout, to the system
  bool assembles_ = true;                          // the matrix as well as the residual
  bool reuses_ = false;                            // the matrix of the stage before, to begin with
  std::vector<Link> links_;
  std::vector<std::uint32_t> node_;             // per point: its first unknown, or kNone
  std::vector<std::uint32_t> carried_;          // per point: of body_points(), or kNone
  std::vector<std::uint32_t> body_;             // per free body: its first unknown
  std::vector<std::uint32_t> pulley_;           // per pulley: its unknown, the speed
  std::vector<LinkAtPulley> links_at_pulleys_;  // by pulleys
  std::vector<PulleyLaw> pulley_law_;           // of the last assembly
  std::vector<Mechanism::Slip> slip_before_;    // of Newton's last correction
  std::vector<double> slid_;                    // m/s, per pulley: as the step began
  std::vector<double> pulley_mass_;     // kg, of that assembly: what a pulley's row is scaled by
  std::vector<Vec3> own_acceleration_;  // per point, m/s^2: without changes of velocities
  std::vector<double> change_;          // of the unknown velocities, per second
  std::vector<Mat3> by_speed_;          // per contact: of its law, by its velocity
  std::vector<double> by_rate_;         // per link: of its law, by the rate of its length
  /// Soft strings pull nothing where they are shorter than at rest, or where damping would push.
  enum Slack : char { kTaut, kSlack, kHeldBack };
  std::vector<Slack> slack_;       // per link
  std::vector<double> by_rest_;    // per link: of that rate, by the rate of its rest length
  std::vector<double> soft_rate_;  // m/s, per link: how fast it stretches
  std::size_t first_link_ = 0, first_contact_ = 0, unknowns_ = 0;
  std::vector<Contact> contacts_;         // of the present problem
  std::vector<std::uint32_t> reversing_;  // candidates that slide forwards to their stop
  std::vector<char> on_;                  // per link: a rod, or a string that is taut
  std::vector<std::uint32_t> shape_of_;   // candidates of the present layout
  std::vector<Meeting> meetings_;         // per contact
  std::vector<Vec3> off_;                 // m, per contact in a projection: what it has to move
  std::vector<double> bounce_, snap_;     // m/s, per contact and per link: asked of an impact
  std::vector<char> law_;                 // per contact in a projection: a Grip

  std::vector<double> unknown_, way_, residual_, row_scale_, column_scale_;
  std::vector<double> base_;    // state at zero velocities: places before the stage's part
  std::vector<double> wanted_;  // velocities without the stage's own forces, by unknowns
  std::vector<Vec3> turn_;      // per body: rotation since the step's start before the stage's part
  std::vector<Quat> start_turn_;
  std::vector<double> loose_;                 // per link: tension before the stage's part
  std::vector<double> state_;                 // of the present unknowns
  std::vector<Vec3> force_;                   // N, per point
  std::array<std::vector<Vec3>, 2> applied_;  // N, per point: in a state, and in a changed one
  std::vector<Mat3> by_motion_;               // per point: minus the derivative of what is applied
  std::vector<double> kept_;                  // the state that was changed
  std::vector<double> violation_;             // m, per link in a projection
  double speed_ = 1;                          // m/s, typical
  double length_ = 1, shortest_ = 1;          // m: of the longest connector, of the shortest link
  double stiffest_ = 0;                       // m2/s2: the largest stiffness of a bend over a mass
  double creep_ = 0;                          // of friction: slip over impulse, where it sticks
  double first_way_ = 0;                      // m/s, of Newton's first correction
  double exact_ = 0;                          // m: roundings of places
  bool jumped_ = false;
  double arrival_ = 0, lowest_bounce_ = 0, lowest_slip_ = 0, friction_share_ = 1;
  /// The moment of a rod that is twisted couples all its particles: a column times a row, scaled.
  struct Twisted {
    std::vector<double> column, row, solved;
  };
  std::vector<Twisted> twisted_;
  std::vector<Vec3> slope_;
  double stage_inertia_ = 1;                // of the last step's stages
  bool settled_ = true;                     // there was no step yet
  double yields_ = 0;                       // 1/s^2: see project_places()
  std::vector<double> column_scale_stage_;  // of its last one
  std::vector<double> moved_, sped_;        // of distance(): places and velocities, by unknowns
};

/// Each step is taken once and again in two halves. The difference tells the error of the halves;
/// a third of it corrects them, where contacts and strings stay as they are. The times that are
/// asked for end no step: a state within the last step is made by a shorter one from its start.
class Implicit : public Stepping {
 public:
  explicit Implicit(const StepOptions& options) : options_(options), controller_(options) {}
  Implicit(const Implicit&) = delete;

  /// Advances the whole world, and adds the events until then. Throws Diverged.
  void advance(World& world, double until, std::vector<Event>& events);
  /// Since this was made.
  const Counters& counters() const { return counters_; }

  double first_step() const override;
  double longest_step(double time) override;
  double order() const override { return order_; }
  bool lands(double left, double wish) const override;
  Attempt attempt(double time, double h, double until) override;
  void accept(double time) override;
  [[noreturn]] void give_up(double time) override;

 private:
  void advance_strings(World& world, double until);
  void rebuild(const World& world);
  void note_events();
  Attempt try_step(double h);
  const StepState& at(double time);
  double arrival_ahead();
  double allowed_error(double h) const;
  double allowed_change() const;
  double size(const StepState& one, const StepState& other, double time) const;

  StepOptions options_;
  Controller controller_;
  Counters counters_;
  const World* world_ = nullptr;  // in advance()
  bool built_ = false;
  std::uint64_t topology_ = 0;
  SpansAsStrings spans_;
  std::uint64_t spans_topology_ = 0;  // of the world with spans
  ImplicitStep step_;
  StepState from_, now_;  // where the last step began, and ended: at or beyond the shown time
  StepState middle_, end_, whole_, within_;
  std::vector<double> rate_;  // of the last step that ended without an impact, as StepState has it
  std::vector<double> shown_, loaded_;  // the state that advance() left in the world; found there
  double length_ = 1, shortest_ = 1, touching_ = 0;
  double order_ = 0;           // of the last estimate
  double friction_ = 1;        // share of it, in the present step
  bool runs_through_ = false;  // the last step tried lets rope run through a pulley
  std::vector<Event> events_;  // not told yet: after the time that was asked for
  double jam_ = 0;             // s: steps no longer than that go with less friction if they have to
};

}  // namespace taut::direct
