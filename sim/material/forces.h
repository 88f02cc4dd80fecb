// The forces on particles that stretch, bend and meet the air, as lists of elements of a world.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/material/elements.h"
#include "sim/world/twist.h"
#include "sim/world/world.h"

namespace taut::material {

/// A link that stretches: it pulls with stiffness (length - rest) + damping d(length)/dt.
struct StretchElement {
  std::uint32_t a = 0, b = 0;  // points
  double rest = 0;             // m
  double stiffness = 0;        // N/m: EA over the rest length
  double damping = 0;          // N s/m
  std::uint32_t connector = 0, link = 0;
  double rest_rate = 0;  // m/s: of `rest`, where a winch pays the link out
  bool pulls = false;    // only, as strings do

  /// N, by its length (m) and the rate (m/s) at which that grows beyond what is paid out.
  double tension(double length, double rate) const {
    if (pulls && length <= rest) return 0;
    const double pull = stiffness * (length - rest) + damping * rate;
    return pulls ? std::max(pull, 0.0) : pull;
  }
};

/// Two links in a row that resist bending; or a link at a clamp, whose direction is one of the two
/// edges. Its three points are a, b, c; at a clamp `a` and `b` or `b` and `c` are the same.
struct BendElement {
  static constexpr std::uint32_t kNone = 0xffffffff;
  std::uint32_t a = 0, b = 0, c = 0;
  double stiffness = 0;         // N m: EI over the length that bends
  double damping = 0;           // N m s
  std::uint32_t clamp = kNone;  // index of the clamp
  Vec3 rest = Vec3::Zero();     // 1: how it is bent at rest

  bool clamped_before() const { return clamp != kNone && a == b; }
  bool clamped_behind() const { return clamp != kNone && b == c; }
};

/// A link that meets the air.
struct DragElement {
  std::uint32_t a = 0, b = 0;
  double density = 0;               // kg/m^3, of the air
  double length = 0, diameter = 0;  // m
  double across = 0, along = 0;
  double flow = 0;  // m/s, of its material towards b, where a winch moves that past its points

  double density_area() const { return density * length * diameter; }  // kg/m, see drag_force()
};

/// The first link that is pressed together to less than a thousandth of its length, with its points
/// at `positions`; null where there is none. It is about to lose its direction, without which
/// nothing bends: no motion goes on from there.
const StretchElement* pressed_together(std::span<const StretchElement> stretches,
                                       const double* positions);
/// Of its length: a shorter link is pressed together to nothing.
inline constexpr double kShareOfNothing = 1e-3;
inline constexpr const char* kPressedTogether =
    "a link is pressed together to nothing and has no direction, expected a greater "
    "axial_stiffness";

/// The elements of one connector whose first particle is the point `first`, appended.
void add_stretches(const Connector& connector, std::uint32_t index, std::uint32_t first,
                   std::vector<StretchElement>& elements);
/// `clamps` is the number of the first clamp; returns how many there are.
std::uint32_t add_bends(const Connector& connector, std::uint32_t clamps, std::uint32_t first,
                        std::vector<BendElement>& elements);
/// The bend of a closed loop where it closes.
void add_closing_bend(const Connector& connector, std::uint32_t first,
                      std::vector<BendElement>& elements);
void add_drags(const Connector& connector, const Air& air, std::uint32_t first,
               std::vector<DragElement>& elements);

/// All elements of a world. Points are all particles, connector by connector.
class MaterialForces {
 public:
  /// Lays the world's elements out, with room for so many points; where connectors are joined,
  /// between the points of find_leaders().
  void rebuild(const World& world, std::size_t room, std::span<const std::uint32_t> leaders = {});

  bool any() const { return any_; }
  const std::vector<StretchElement>& stretches() const { return stretches_; }
  const std::vector<BendElement>& bends() const { return bends_; }
  const std::vector<DragElement>& drags() const { return drags_; }
  const std::vector<TwistElement>& twists() const { return twists_; }
  const Vec3& wind() const { return wind_; }

  /// Turns the clamps to where they are at `time` (s), and the wind to what it is then.
  void place(const World& world, double time);
  /// The clamps that free bodies turn: place() takes their turns from the world, which may be of
  /// another time.
  struct BodyClamp {
    std::uint32_t clamp = 0;         // BendElement::clamp
    std::size_t body = 0;            // of World::bodies
    Vec3 direction = Vec3::UnitX();  // in the body's axes
    std::size_t bend = 0;            // the first of bends() that it clamps
  };
  const std::vector<BodyClamp>& body_clamps() const { return body_clamps_; }
  /// Visits the indices of the bends at such a clamp: one, or two where it is between the ends.
  template <class Visit>
  void each_bend_at(const BodyClamp& at, Visit visit) const {
    for (std::size_t b = at.bend; b < bends_.size() && bends_[b].clamp == at.clamp; ++b) visit(b);
  }
  /// How much of a rope bends there at rest, m: half of either link.
  double bent_length(std::size_t bend) const;
  const Vec3& direction(std::uint32_t clamp) const { return clamps_[clamp].motion.direction; }
  void turn(std::uint32_t clamp, const ClampMotion& motion) { clamps_[clamp].motion = motion; }
  // Where a winch changes lengths:
  /// gives the link behind a point another rest length (m);
  void set_rest(std::uint32_t point, double rest) { rest_[point] = rest; }
  /// gives a link that stretches another rest length (m), which grows at a rate (m/s);
  void pay_out(std::size_t stretch, double rest, double rate);
  /// gives a link that meets the air another length (m), and its material a flow (m/s);
  void flow_past(std::size_t drag, double length, double speed);
  /// gives the bends from `first` until `end` the stiffness of their lengths.
  void bend_over_lengths(std::size_t first, std::size_t end);
  /// The two edges that an element bends, and their rates.
  void edges(const BendElement& bend, const double* positions, Vec3& e0, Vec3& e1) const;
  void edge_rates(const BendElement& bend, const double* velocities, Vec3& e0, Vec3& e1) const;
  /// The derivatives of a bend's energy by its two edges, and of half its damping's power by their
  /// rates, N.
  void slope(const BendElement& bend, const double* positions, const double* velocities,
             Vec3& by_e0, Vec3& by_e1) const;
  /// Adds the forces (N) at each point.
  void add(const double* positions, const double* velocities, std::vector<Vec3>& force) const;
  /// The half of the air's force on a link that acts at either end, N.
  Vec3 drag(const DragElement& link, const double* positions, const double* velocities) const;
  /// Add the forces of bends, of the air and of twist alone, and applied forces alone.
  void add_bends(const double* positions, const double* velocities, std::vector<Vec3>& force) const;
  void add_drag(const double* positions, const double* velocities, std::vector<Vec3>& force) const;
  void add_twists(const double* positions, const double* velocities,
                  std::vector<Vec3>& force) const;
  void add_applied(const double* positions, const double* velocities,
                   std::vector<Vec3>& force) const;
  bool has_applied() const { return !applied_.empty(); }

  /// The moment (N m) of a clamp on its rope, by bending and twist.
  struct ClampMoment {
    std::size_t connector = 0, hold = 0;  // the index of the hold on the connector
    Vec3 moment = Vec3::Zero();
  };
  /// All clamps, connector by connector.
  std::vector<ClampMoment> clamp_moments(const double* positions, const double* velocities) const;

  /// The twist (rad) of a connector with its clamps where they are placed, less than half a turn
  /// from what follow() saw last; and its rate (rad/s).
  double twist(const TwistElement& rod, const double* positions) const;
  double twist_rate(const TwistElement& rod, const double* positions,
                    const double* velocities) const;
  /// The derivatives of twist() by the connector's particles, rad/m.
  void twist_slope(const TwistElement& rod, const double* positions,
                   std::vector<Vec3>& slope) const;
  /// The point of a particle of the connector.
  std::uint32_t point_of(const TwistElement& rod, std::uint32_t particle) const {
    const std::uint32_t point = rod.first + particle;
    return leaders_.empty() ? point : leaders_[point];
  }
  /// Takes the clamps' turns from a state that was reached, with the clamps placed.
  void follow(const double* positions);
  /// The same of the only connector that twists, with its turn known.
  void follow_turn(double since) {
    if (!twists_.empty()) twists_.front().since = since;
  }
  /// EndTurn::since at these places, less than half a turn from that last one.
  double turned(const TwistElement& rod, const double* positions) const;
  /// Takes them from a world, and gives them to it.
  void load_twists(const World& world);
  void store_twists(World& world) const;

  /// An oscillator x'' + damping x' + frequency^2 x = 0 for which no longer step is stable than for
  /// all that stretches and bends, by the points' inverse masses (1/kg): Gershgorin's bounds on
  /// M^-1 K and M^-1 C of the straight connector, or of one whose links meet at
  /// angles (rad) up to `bent`, where bends are stiffer.
  struct HighestMode {
    double frequency = 0;  // rad/s
    double damping = 0;    // 1/s
  };
  HighestMode highest_mode(const std::vector<double>& inverse_mass, double bent = 0) const;

  /// The cycles of add().
  double cycles() const;

 private:
  void name_leaders(std::span<const std::uint32_t> leaders);
  struct Clamp {
    std::size_t connector = 0, hold = 0;
    ClampMotion motion;
    ClampFrame frame;  // placed where something resists twist
  };
  void add_twist(const Connector& connector, std::uint32_t index, std::uint32_t first,
                 std::uint32_t clamps, bool closed);
  Vec3 link_of(const TwistElement& rod, std::uint32_t link, const double* positions) const;
  template <class Visit>
  void each_slope(const TwistElement& rod, const double* positions, Visit visit) const;

  /// The applied force of a connector whose first particle is the point `first`.
  struct Applied {
    std::uint32_t first = 0, particles = 0;
    std::shared_ptr<const AppliedForce> force;
  };
  std::vector<Applied> applied_;
  double time_ = 0;                                 // s, of place()
  mutable std::vector<Vec3> at_, moving_, pushed_;  // of one connector, in add_applied()
  bool any_ = false;
  Vec3 wind_ = Vec3::Zero();
  std::vector<StretchElement> stretches_;
  /// The links before and behind the middle of a bend, by their first points.
  struct BentLinks {
    std::uint32_t before = 0, behind = 0;
  };
  std::vector<BentLinks> bent_links_;
  struct Axial {
    double stiffness = 0, damping = 0;  // N, N s: of a unit of length
  };
  std::vector<Axial> axial_;  // of stretches_, in worlds with winches
  std::vector<BendElement> bends_;
  std::vector<DragElement> drags_;
  std::vector<TwistElement> twists_;
  std::vector<std::uint32_t> leaders_;  // of the points; empty: each stands for itself
  std::vector<Clamp> clamps_;
  std::vector<BodyClamp> body_clamps_;
  struct Lengths {
    double before = 0, behind = 0;  // m, at rest
  };
  std::vector<double> rest_;      // m, per point: of the link behind it
  std::vector<Lengths> lengths_;  // of the edges of each bend
  std::vector<double> moduli_;    // EI (N m^2) of each bend
};

}  // namespace taut::material
