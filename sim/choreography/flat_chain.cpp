#include "sim/choreography/flat_chain.h"

#include <algorithm>
#include <cmath>

#include "sim/features/features.h"
#include "sim/run/reduced.h"
#include "sim/world/state.h"

namespace taut::choreography {
namespace {

bool is_on(const Hold& hold, std::size_t body) {
  return hold.to.kind == Attachment::Kind::body && hold.to.body == body;
}

/// Links that only pull move as rigid ones do while they are taut, as those of a flat chain are;
/// and so little is bent then that what damps bends is left to the certificate.
World while_taut(World world) {
  const Features more = features(world) & (kMaterialFeatures | Feature::strings);
  const bool damped =
      (more - Features{Feature::bending_damping, Feature::taper, Feature::material_on_body})
          .empty();
  for (Connector& connector : world.connectors) {
    connector.pulls = false;
    if (damped) connector.sections.clear();
  }
  return world;
}

}  // namespace

const Connector& hanging_chain(const World& world, std::size_t body) {
  return *std::ranges::find_if(world.connectors, [&](const Connector& connector) {
    return std::ranges::any_of(connector.holds,
                               [&](const Hold& hold) { return is_on(hold, body); });
  });
}

const Hold& hanging_hold(const World& world, std::size_t body) {
  return *std::ranges::find_if(hanging_chain(world, body).holds,
                               [&](const Hold& hold) { return is_on(hold, body); });
}

TaylorSeries unit_series(const TaylorSeries& series) {
  const Eigen::Index n = series.cols();
  Eigen::VectorXd square = Eigen::VectorXd::Zero(n), inverse = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    for (Eigen::Index i = 0; i <= k; ++i) square[k] += series.col(i).dot(series.col(k - i));
  }
  // The power r = s^p has s r' = p s' r.
  constexpr double kPower = -0.5;
  inverse[0] = std::pow(square[0], kPower);
  for (Eigen::Index k = 1; k < n; ++k) {
    double sum = 0;
    for (Eigen::Index i = 1; i <= k; ++i) {
      sum += (kPower * static_cast<double>(i) - static_cast<double>(k - i)) * square[i] *
             inverse[k - i];
    }
    inverse[k] = sum / (static_cast<double>(k) * square[0]);
  }
  TaylorSeries unit = TaylorSeries::Zero(3, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    for (Eigen::Index i = 0; i <= k; ++i) unit.col(k) += inverse[k - i] * series.col(i);
  }
  return unit;
}

TaylorSeries second_derivative(const TaylorSeries& series) {
  TaylorSeries second(3, series.cols() - 2);
  for (Eigen::Index k = 0; k < second.cols(); ++k) {
    second.col(k) = static_cast<double>((k + 1) * (k + 2)) * series.col(k + 2);
  }
  return second;
}

FlatMotion flat_motion(const FlatChain& chain, const TaylorSeries& free_end, double gravities) {
  FlatMotion motion{{free_end}, {}};
  TaylorSeries pull = TaylorSeries::Zero(3, free_end.cols());
  for (std::size_t link = 0; link < chain.length.size(); ++link) {
    TaylorSeries needed = second_derivative(motion.particles.back());
    needed.col(0) -= gravities * chain.gravity;
    pull = (pull.leftCols(needed.cols()) + chain.mass[link] * needed).eval();
    motion.tension.push_back(pull.col(0).norm());
    motion.particles.push_back(motion.particles.back().leftCols(needed.cols()) +
                               chain.length[link] * unit_series(pull));
  }
  return motion;
}

std::string why_not_flat(const World& world, const Timeline& timeline, std::size_t body) {
  std::string reason = why_no_link(while_taut(world), timeline, body);
  if (!reason.empty()) return reason;
  const Connector& chain = hanging_chain(world, body);
  const Hold& hold = hanging_hold(world, body);
  const auto leads = [&](const Hold& other) {
    return other.to.kind != Attachment::Kind::fixed && is_prescribed(world, other.to);
  };
  if (chain.holds.size() != 2 || !std::ranges::any_of(chain.holds, leads)) {
    return "on a connector whose other end follows no path";
  }
  const MassProperties& mass = world.bodies[body].bare;
  const Vec3 along = (mass.centre - hold.to.point).normalized();
  const Mat3 across = Mat3::Identity() - along * along.transpose();
  const double moment = (mass.inertia * across).trace() / 2;
  const Mat3 uneven =
      mass.inertia - moment * across - along.dot(mass.inertia * along) * along * along.transpose();
  constexpr double kEven = 1e-6;
  if (!(uneven.norm() <= kEven * moment)) return "not of even moment about the line it hangs by";
  return {};
}

FlatChain flat_chain(World world, std::size_t body) {
  world = while_taut(std::move(world));
  const std::string name = hanging_chain(world, body).name;
  world.bodies[body].model = BodyModel::link;
  BodiesAsLinks links(world);
  const Connector& whole = *std::ranges::find(world.connectors, name, &Connector::name);
  FlatChain chain{world.gravity, whole.particle_mass, whole.rest};
  if (whole.holds.at(0).particle == 0) {
    std::ranges::reverse(chain.mass);
    std::ranges::reverse(chain.length);
  }
  chain.mass.pop_back();  // the driven end's is the driver's to carry
  return chain;
}

FlatChain coarser(const FlatChain& chain, std::size_t links) {
  if (chain.length.size() <= links + 1) return chain;
  double whole = 0;
  for (std::size_t i = 1; i < chain.length.size(); ++i) whole += chain.length[i];
  const double link = whole / static_cast<double>(links);
  FlatChain other{chain.gravity, std::vector<double>(links + 1), std::vector<double>(links + 1)};
  std::ranges::fill(other.length, link);
  other.length[0] = chain.length[0];
  other.mass[0] = chain.mass[0];
  double along = 0;
  for (std::size_t i = 1; i < chain.mass.size(); ++i) {
    const double place = along / link;
    const auto before = std::min(static_cast<std::size_t>(place), links - 1);
    const double share = place - static_cast<double>(before);
    other.mass[1 + before] += (1 - share) * chain.mass[i];
    if (before + 1 < links) other.mass[2 + before] += share * chain.mass[i];
    along += chain.length[i];
  }
  return other;
}

}  // namespace taut::choreography
