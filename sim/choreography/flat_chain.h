// A taut chain that hangs from a driven end, as a differentially flat system: the motion of its
// free end gives, link by link, the tensions, every particle and the driven end in closed form.
//
// Of a particle's acceleration a, what the links have to pull is m (a - g); so the last particle's
// motion gives the direction and the tension of the last link, that link the next particle, and so
// on: each link takes two more derivatives. Fliess, Levine, Martin, Rouchon, "Flatness and defect
// of non-linear systems", International Journal of Control 61, 1995; Murray, "Trajectory generation
// for a towed cable system using differential flatness", IFAC World Congress, 1996; Petit and
// Rouchon, "Flatness of heavy chain systems", SIAM Journal on Control and Optimization 40, 2001.
#pragma once

#include <string>
#include <vector>

#include "sim/interventions/interventions.h"
#include "sim/world/world.h"

namespace taut::choreography {

/// A Taylor series in time: column k is the k-th derivative over k!, m/s^k.
using TaylorSeries = Eigen::Matrix3Xd;

/// The series of the unit vector along `series`, which is not zero at the instant itself.
TaylorSeries unit_series(const TaylorSeries& series);
/// The series of the second derivative, two columns shorter.
TaylorSeries second_derivative(const TaylorSeries& series);

/// Particles on rigid links, numbered from the free end. A body that hangs at the end is one more
/// link (see Stick), whose free end is its centre of oscillation.
struct FlatChain {
  Vec3 gravity = Vec3(0, -9.81, 0);  // m/s^2
  std::vector<double> mass;          // kg, of the particle at the free end of each link
  std::vector<double> length;        // m, of each link

  /// Columns that the free end's series needs so that the driven end's has `columns`.
  Eigen::Index columns(Eigen::Index columns) const {
    return columns + 2 * static_cast<Eigen::Index>(length.size());
  }
};

struct FlatMotion {
  std::vector<TaylorSeries> particles;  // from the free end to the driven one, ever shorter
  std::vector<double> tension;          // N, of each link
};

/// Under so many times the chain's gravity. Exact to rounding; no number is finite where a link's
/// pull is zero.
FlatMotion flat_motion(const FlatChain& chain, const TaylorSeries& free_end, double gravities = 1);

/// Why the motion of the body and of the connector that it hangs by does not follow from that of
/// one of its points, or empty. Beside what why_no_link() says, the connector's other end has to be
/// driven, and the body to have the same moment about every axis across its line. Links that only
/// pull count as rigid: while the chain is taut they are.
std::string why_not_flat(const World& world, const Timeline& timeline, std::size_t body);

/// The connector that the body hangs by, and its hold on the body.
const Connector& hanging_chain(const World& world, std::size_t body);
const Hold& hanging_hold(const World& world, std::size_t body);

/// The chain that ends in that body, for which why_not_flat() has no reason.
FlatChain flat_chain(World world, std::size_t body);

/// The same with at most so many even links beside the body's: each mass is shared by the two
/// particles that it lies between, so that the chain's moment about the driven end stays.
FlatChain coarser(const FlatChain& chain, std::size_t links);

}  // namespace taut::choreography
