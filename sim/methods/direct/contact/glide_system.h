// Newton's equations of the first stage of a step at obstacles.
#pragma once

#include <span>
#include <vector>

#include "sim/contact/band_system.h"
#include "sim/contact/body_mobility.h"
#include "sim/links/dense.h"
#include "sim/links/mechanism.h"

namespace taut::direct {

/// How the points and rows of a mechanism respond to small changes of the points' velocities v
/// (m/s, mean over the step) and the rows' impulses (N s). Ordered by points (a point's velocity,
/// then what touches the link there, then the rows that begin there) the system has a narrow band.
/// Bodies that rows meet in several points, or that beads touch, couple these, by Woodbury's
/// identity.
class GlideSystem {
 public:
  /// A touch of a link: its impulse J (N s, of the mean velocities) acts at a share of the way from
  /// one point to the next, and obeys respond(u - mobility J) = u there, see touch.h.
  struct LinkTouch {
    std::uint32_t first = 0;  // point
    double share = 0, mobility = 0;
    Mat3 derivative;               // of respond()
    Mat3 bend_first, bend_next;    // 1/s: of respond() by the points' displacements
    Vec3 slope_first, slope_next;  // 1/m: of the share by these
    Vec3 given, apart;             // N s: J; m/s: how the next point moves past the first
  };

  /// A bead that touches a free body: its impulse J (N s, of the mean velocities) acts at the
  /// point, and against it at the body's `arm`; it obeys respond(u - mobility J) = u of the
  /// velocity past the body.
  struct BeadTouch {
    std::uint32_t point = 0, body = 0;
    Vec3 arm;  // m
    double mobility = 0;
    Mat3 derivative, bend;  // as of a link's
  };

  /// The terms of the equations, per point and per row.
  struct Terms {
    double h = 0;                     // s
    std::span<const Mat3> mobility;   // 1/kg: of a point to what pulls it
    std::span<const Mat3> bend;       // 1: to its own displacement over h, as surfaces curve
    std::span<const Mat3> turn;       // N s/m: of a row's impulse with the way from a to b
    std::span<const Vec3> along, to;  // of the row's pull; in which its length grows
    /// Of bodies to what pulls them; null: freely.
    const contact::BodyMobility* bodies = nullptr;
    std::span<const LinkTouch> touches = {};  // in order of points
    std::span<const BeadTouch> beads = {};    // in order of points
  };

  /// `together`: see contact::ends_that_meet().
  void rebuild(const Mechanism& mechanism, std::span<const std::uint32_t> together = {});
  void assemble(const Mechanism& mechanism, const Terms& terms);
  /// In: by how much each point is slower than its response, each row grows too slowly and each
  /// touch of a link or bead falls short of its law (m/s). Out: what to add to velocities and
  /// impulses.
  void solve(std::span<Vec3> velocity, std::span<double> impulse, std::span<Vec3> given,
             std::span<Vec3> by_beads);

 private:
  /// What an unknown gives a body: so much (N s) of each of it, at `arm` (m). What that does to the
  /// equations from `own` on is in the band.
  struct Source {
    std::uint32_t body = 0;
    std::size_t unknown = 0, own = 0;
    Vec3 arm, gives;
  };
  /// Equations that know how a body moves at `arm` (m), times `response`.
  struct Receiver {
    std::uint32_t body = 0;
    std::size_t equation = 0;
    Vec3 arm;
    Mat3 response;
  };

  void arrange(const Mechanism& mechanism, const Terms& terms);
  void add_touch(const Terms& terms, std::size_t touch);
  void add_bead(const Mechanism& mechanism, const Terms& terms, std::size_t touch);
  void add(std::size_t row, std::size_t column, const Mat3& block);
  void add_row(const Mechanism& mechanism, const Terms& terms, std::size_t row);
  void find_border(const Mechanism& mechanism, const Terms& terms);
  void add_bodies(const Mechanism& mechanism, const Terms& terms);

  std::vector<std::size_t> first_;  // per point: its velocity's first unknown
  std::vector<std::size_t> row_;    // per row: its unknown
  std::vector<std::size_t> touch_;  // per touch of a link: its impulse's first unknown
  std::vector<std::size_t> bead_;   // the same per touch of a bead
  std::size_t size_ = 0, half_ = 0;
  contact::BandSystem band_;
  std::vector<double> values_;
  std::vector<std::uint32_t> together_;  // per body: the number of those that may touch each other
  std::vector<std::size_t> count_;       // per body of such a number: what couples it
  std::vector<std::uint32_t> body_point_;  // per point: of it, or any number
  std::vector<Source> border_;
  std::vector<Receiver> receivers_;
  std::vector<double> columns_;  // per source: what it does through others
  LinearSystem decomposed_;
  Eigen::VectorXd found_, share_;
};

}  // namespace taut::direct
