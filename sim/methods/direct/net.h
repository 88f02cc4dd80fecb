// Spans and free bodies that pull on each other: the full model in three dimensions.
#pragma once

#include <Eigen/LU>
#include <cstddef>
#include <vector>

#include "sim/methods/direct/motion.h"
#include "sim/world.h"

namespace taut::direct {

/// The links of a connector between two neighbouring holds, or a hold and a free end.
struct SpanRange {
  std::size_t connector = 0;
  std::size_t first = 0, last = 0;  // particles
};

/// The parts of a world that only move together.
struct Component {
  std::vector<SpanRange> spans;
  std::vector<std::size_t> bodies;  // free ones; indices into World::bodies
};

/// Cuts a world at everything whose motion is known beforehand.
std::vector<Component> components(const World& world);

/// One component's motion. Coordinates: the unit directions u of all links (all x, all y, all z),
/// then the unit quaternions (w x y z) of the bodies. For link i of length l between the points i
/// and i+1, with a tension T_i that is positive where the link pulls:
///
///   l u'' = a_{i+1} - a_i   and   u . u'' = -|u'|^2   (from |u| = 1)
///
/// A free particle has a = g + w (T_i u_i - T_{i-1} u_{i-1}), w its inverse mass; a held point's is
/// known; that of a body's point r from its centre is g + W x (W x r) + W' x r + F/M. Every tension
/// meets only those of the neighbouring links and of the links at its bodies: one symmetric
/// tridiagonal system for all spans, and a small dense one for bodies that several links hold.
class Net : public Motion {
 public:
  Net(const World& world, Component component);

  /// Reads the state from the world.
  void load(const World& world, std::vector<double>& q, std::vector<double>& rate);
  /// Writes the state at `time`, positions included, to the world.
  void store(World& world, double time, const double* q, const double* rate);
  /// Reads holds from `world` from now on.
  void attach(const World& world) { world_ = &world; }

  std::size_t size() const override { return 3 * links_ + 4 * bodies_.size(); }
  void acceleration(double time, const double* q, const double* rate, double* out) override;
  void project(double time, double* q, double* rate) override;
  double error(const double* q, const double* eq, const double* er) const override;

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  struct End {  // a span's end that is not a free particle
    std::size_t link = 0;
    double pull = 0;  // +1 where the tension pulls along u (a span's first end), else -1
    Attachment to;
    std::size_t body = kNone;       // index into bodies_; none: prescribed
    Vec3 local_arm = Vec3::Zero();  // m, from the body's centre of mass, in its axes
    // At the present stage:
    Vec3 arm = Vec3::Zero();   // m, in the world's axes
    Vec3 lead = Vec3::Zero();  // m/s^2, the acceleration that no tension causes, less gravity
  };
  struct Span {
    SpanRange range;
    std::size_t offset = 0, links = 0;        // into the arrays of links
    bool reversed = false;                    // runs from range.last to range.first
    std::size_t first = kNone, last = kNone;  // ends_
    bool closes = false;                      // the place of its last end is known without it
    std::size_t particle(std::size_t k) const {
      return reversed ? range.last - k : range.first + k;
    }
  };
  struct Part {            // a free body
    std::size_t body = 0;  // index into World::bodies
    double mass = 0;
    Mat3 inertia = Mat3::Identity(), inverse_inertia = Mat3::Identity();  // in its axes
    std::vector<std::size_t> ends;
    // At the present stage:
    Mat3 rotation = Mat3::Identity(), world_inverse_inertia = Mat3::Identity();
    Vec3 spin = Vec3::Zero(), spin_rate = Vec3::Zero();  // the rate that no tension causes
  };
  struct Coupling {                   // two different ends on one body
    std::size_t a = 0, b = 0;         // ends_
    std::size_t row = 0, column = 0;  // of the dense system
  };
  struct Point {
    Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();
  };
  struct Rotary {
    Vec3 momentum = Vec3::Zero();  // kg m^2/s
    Mat3 inertia = Mat3::Zero();   // kg m^2
  };

  void add_span(const World& world, const SpanRange& range, bool reversed);
  void order_spans(const World& world);
  void couple();
  void measure_links(const World& world);

  void read_bodies(const double* q, const double* rate);
  void read_holds(double time);
  void assemble(const double* q, const double* rate);
  void add_couplings(const double* q);

  void place(double time, const double* q, const double* rate);
  void close(double time, double* q, double* rate);
  Rotary rotary(double time) const;
  void restore_momentum(double time, double* q, double* rate);

  Vec3 at(const double* array, std::size_t link) const {
    return {array[link], array[links_ + link], array[2 * links_ + link]};
  }
  void add(double* array, std::size_t link, const Vec3& v) const {
    for (int c = 0; c < 3; ++c) array[c * static_cast<std::ptrdiff_t>(links_) + link] += v[c];
  }

  const World* world_;
  Component component_;
  std::size_t links_ = 0;
  std::vector<Span> spans_;  // each one's first end is placed by those before it
  std::vector<End> ends_;
  std::vector<Part> bodies_;
  std::vector<Coupling> couplings_;
  std::vector<std::size_t> coupled_;  // links with a row of the dense system

  bool floats_ = false;  // nothing prescribed: its centre of mass flies freely
  double mass_ = 0;      // kg
  double memory_ = 0;    // s, see error()
  double loaded_at_ = 0;
  Point centre_;        // where it floats: of mass, at the time of loading
  Vec3 spin_momentum_;  // where it floats: kg m^2/s about the centre of mass

  // Per link: rest length and its inverse, the inverse masses of both its particles together, and
  // that of the particle it shares with the next link (zero where there is none).
  std::vector<double> rest_, inverse_rest_, both_, shared_;
  // Per particle of every span (one more than its links): mass, place.
  std::vector<double> particle_mass_;
  std::vector<Point> points_, centres_;
  // Workspaces of acceleration().
  std::vector<double> diagonal_, off_, tension_, response_;
  Eigen::MatrixXd dense_, gain_;
  Eigen::VectorXd dense_right_;
};

}  // namespace taut::direct
