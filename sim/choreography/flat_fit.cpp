#include "sim/choreography/flat_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "sim/contact/capsule.h"
#include "sim/features/features.h"
#include "sim/motion/rotation.h"
#include "sim/run/reduced.h"
#include "sim/world/state.h"

namespace taut::choreography {
namespace {

/// The hold at the other end of the connector that the body hangs by.
const Attachment& lead(const World& world, std::size_t body) {
  const auto& holds = hanging_chain(world, body).holds;
  const bool first = holds[0].to.kind == Attachment::Kind::body && holds[0].to.body == body;
  return holds[first ? 1 : 0].to;
}

}  // namespace

std::shared_ptr<const Path> hand_path(const World& world, std::size_t body) {
  const Attachment& to = lead(world, body);
  return to.kind == Attachment::Kind::path ? to.path : world.bodies[to.body].path;
}

HandFrame::HandFrame(const World& world, std::size_t body, double pivot) : pivot_(pivot) {
  const Attachment& to = lead(world, body);
  const Vec3 lever =
      to.kind == Attachment::Kind::path ? to.point : Vec3(to.point - world.bodies[to.body].grip);
  const PathKey& last = hand_path(world, body)->keys().back();
  lever_ = lever.norm();
  rest_rotation_ = last.rotation;
  along_ = lever_ > 0 ? Vec3(last.rotation * lever / lever_) : Vec3::UnitY();
  rest_ = last.position + lever_ * along_;
}

TaylorSeries HandFrame::origin(const TaylorSeries& end) const {
  TaylorSeries origin = end;
  if (!turns()) {
    origin.col(0) -= lever_ * along_;
    return origin;
  }
  TaylorSeries from_pivot = end;
  from_pivot.col(0) -= rest_ - pivot_ * along_;
  return end - lever_ * unit_series(from_pivot);
}

Quat HandFrame::rotation(const Vec3& end) const {
  if (!turns()) return rest_rotation_;
  return (rotation_between(along_, end - rest_ + pivot_ * along_) * rest_rotation_).normalized();
}

GaussianSum GaussianSum::between(double from, double until, double spacing) {
  const double room = (until - from) / spacing - 2 * kSupport;
  if (room < 0) return {from, spacing, 0};
  return {from + kSupport * spacing, spacing, static_cast<Eigen::Index>(std::floor(room)) + 1};
}

GaussianSum::Local GaussianSum::at(double time, Eigen::Index columns) const {
  const double place = (time - first) / spacing;
  const auto clamped = [&](double index) {
    return static_cast<Eigen::Index>(std::clamp(index, 0.0, static_cast<double>(count)));
  };
  Local local{clamped(std::ceil(place - kSupport)), {}};
  const Eigen::Index end = std::max(local.begin, clamped(std::floor(place + kSupport) + 1));
  local.series.resize(end - local.begin, columns);
  for (Eigen::Index i = 0; i < local.series.rows(); ++i) {
    // g = exp(-x^2 / 2) has g' = -x g, with x in standard deviations.
    const double x = place - static_cast<double>(local.begin + i);
    auto g = local.series.row(i);
    g[0] = std::exp(-x * x / 2);
    for (Eigen::Index k = 0; k + 1 < columns; ++k) {
      g[k + 1] = -(x * g[k] + (k > 0 ? g[k - 1] : 0)) / static_cast<double>(k + 1);
    }
    double power = 1;
    for (Eigen::Index k = 0; k < columns; ++k, power /= spacing) g[k] *= power;
  }
  return local;
}

namespace {

constexpr std::size_t kNoWaypoint = static_cast<std::size_t>(-1);
constexpr Eigen::Index kHandColumns = 4;  // of the hand's series: to its third derivative
constexpr Eigen::Index kTerms = 8;        // residuals of an instant of the hand
constexpr int kInstants = 2, kKeys = 8;   // of the hand, for each Gaussian
// Of the chain. Each takes two more derivatives; the simulation shows the effect of more links.
constexpr std::size_t kLinks = 4;

// The values at which residuals are 1, or their growth.
constexpr double kNear = 1e-3;      // m, of a waypoint
constexpr double kJerk = 0.1;       // of a jerk of g in the time constant of the pendulum
constexpr double kFullUse = 0.97;   // share of a limit up to which it costs nothing
constexpr double kBeyond = 30;      // per share of a limit beyond
constexpr double kLeastPull = 0.5;  // of the body's weight, below which
constexpr double kSlackening = 3;   // the logarithm keeps the chain taut

// The continuation in gravity: from how many of it, in which steps of the logarithm.
constexpr double kGravities = 8, kFirstStep = 0.4, kLastStep = 0.004;
constexpr double kSmallJump = 2;                   // of the cost: the step is taken
constexpr double kRoughly = 1e-3, kFinely = 1e-4;  // relative changes at which fits end
constexpr int kMostTrials = 60;
constexpr double kFirstDamping = 1e-3;  // share of the diagonal
constexpr double kRidge = 1e-14;        // of the largest: what nothing determines stays

constexpr double kNudge = 1e-6;  // m, of a coefficient, for differences

double beyond_limit(double value, double limit) {
  return kBeyond * std::max(0.0, value / limit - kFullUse);
}

/// Gaussians as near as waypoints, and the body's own swing, ask for; nearer ones would only let
/// the fit end at motions that jerk between the instants looked at.
double spacing_of(const Choreography& problem, double length) {
  double spacing = 2 * std::numbers::pi * std::sqrt(length / problem.world.gravity.norm()) / 8;
  for (std::size_t k = 1; k < problem.waypoints.size(); ++k) {
    spacing = std::min(spacing, problem.waypoints[k].time - problem.waypoints[k - 1].time);
  }
  return spacing;
}

double total(const std::vector<double>& numbers) {
  double sum = 0;
  for (const double number : numbers) sum += number;
  return sum;
}

}  // namespace

Eigen::Index FlatFit::gaussians(const Choreography& problem, double from) {
  const double length = total(flat_chain(problem.world, problem.body).length);
  return GaussianSum::between(from, problem.until, spacing_of(problem, length)).count;
}

FlatFit::FlatFit(const Choreography& problem, double from)
    : problem_(problem),
      chain_(coarser(flat_chain(problem.world, problem.body), kLinks)),
      last_{chain_.gravity, {chain_.mass[0]}, {chain_.length[0]}},
      hand_(problem.world, problem.body, problem.pivot),
      from_(from) {
  const double length = total(chain_.length), gravity = chain_.gravity.norm();
  const Body& body = problem.world.bodies[problem.body];
  const Vec3 hangs = hanging_hold(problem.world, problem.body).to.point;
  rest_ = hand_.rest() + length / gravity * chain_.gravity;
  along_ = (problem.point - hangs).dot((body.bare.centre - hangs).normalized()) / chain_.length[0];
  weight_ = chain_.mass[0] * gravity;
  jerk_ = gravity / std::sqrt(length / gravity);

  curve_ = GaussianSum::between(from, problem.until, spacing_of(problem, length));
  coefficients_ = Eigen::VectorXd::Zero(3 * curve_.count);
  for (std::size_t k = 0; k < problem.waypoints.size(); ++k) {
    const double time = problem.waypoints[k].time;
    instants_.push_back({time, curve_.at(time, last_.columns(1)), k, hangs_at(time)});
  }
  const int steps = steps_of(curve_.spacing / kInstants);
  for (int k = 1; k < steps; ++k) {
    const double time = from + (problem.until - from) * k / steps;
    instants_.push_back(
        {time, curve_.at(time, chain_.columns(kHandColumns)), kNoWaypoint, hangs_at(time)});
  }
  start();
}

double FlatFit::hangs_at(double time) const {
  const std::vector<Waypoint>& points = problem_.waypoints;
  const auto held_by_turning = [&](std::size_t k) {
    if (k == 0 || k + 1 >= points.size()) return false;
    const double before = points[k].time - points[k - 1].time;
    const double after = points[k + 1].time - points[k].time;
    const Vec3 acceleration = 2 / (before + after) *
                              ((points[k + 1].position - points[k].position) / after -
                               (points[k].position - points[k - 1].position) / before);
    const Vec3 out = (points[k].position - hand_.rest()).normalized();
    return -acceleration.dot(out) > problem_.world.gravity.norm();
  };
  const auto next = std::ranges::upper_bound(points, time, {}, &Waypoint::time);
  const auto k = static_cast<std::size_t>(next - points.begin());
  const double begin = k == 0 ? from_ : points[k - 1].time;
  const double end = k == points.size() ? problem_.until : points[k].time;
  const double first = k > 0 && held_by_turning(k - 1) ? 0 : 1;
  const double last = k < points.size() && held_by_turning(k) ? 0 : 1;
  return first + (last - first) * (time - begin) / (end - begin);
}

int FlatFit::steps_of(double longest) const {
  return static_cast<int>(std::ceil((problem_.until - from_) / longest));
}

void FlatFit::start() {
  const auto points = static_cast<Eigen::Index>(problem_.waypoints.size());
  const auto rows = static_cast<Eigen::Index>(instants_.size());
  Eigen::MatrixXd curve = Eigen::MatrixXd::Zero(rows, curve_.count);
  Eigen::MatrixX3d values = Eigen::MatrixX3d::Zero(rows, 3);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const GaussianSum::Local& basis = instants_[static_cast<std::size_t>(row)].basis;
    const bool passes = row < points;
    curve.row(row).segment(basis.begin, basis.series.rows()) =
        (passes ? 1 / kNear : 6 * kJerk / jerk_) * basis.series.col(passes ? 0 : 3);
    if (!passes) continue;
    const Vec3& at = problem_.waypoints[static_cast<std::size_t>(row)].position;
    const Vec3 out = (at - hand_.rest()).normalized();
    values.row(row) = (at - (along_ - 1) * chain_.length[0] * out - rest_) / kNear;
  }
  Eigen::MatrixXd normal = curve.transpose() * curve;
  normal.diagonal().array() += kRidge * normal.diagonal().maxCoeff();
  const Eigen::LDLT<Eigen::MatrixXd> decomposed(normal);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::VectorXd right = curve.transpose() * values.col(axis);
    const Eigen::VectorXd fitted = decomposed.solve(right);
    for (Eigen::Index k = 0; k < curve_.count; ++k) coefficients_[3 * k + axis] = fitted[k];
  }
}

TaylorSeries FlatFit::free_end(const GaussianSum::Local& basis,
                               const Eigen::VectorXd& coefficients) const {
  const Eigen::Map<const TaylorSeries> of_gaussians(coefficients.data(), 3, curve_.count);
  TaylorSeries series = of_gaussians.middleCols(basis.begin, basis.series.rows()) * basis.series;
  series.col(0) += rest_;
  return series;
}

double FlatFit::clearance(const FlatMotion& motion) const {
  const std::optional<Vec3> pivot = hand_.pivot();
  if (!(problem_.limits.clearance > 0 && pivot)) return std::numeric_limits<double>::infinity();
  const Vec3 hangs = motion.particles[1].col(0), end = motion.particles[0].col(0);
  return contact::least_gap(contact::Capsule{motion.particles.back().col(0), *pivot},
                            contact::Capsule{hangs, hangs + along_ * (end - hangs)});
}

Eigen::VectorXd FlatFit::residuals(const Instant& instant, const TaylorSeries& free_end) const {
  const double gravities = std::pow(gravities_, instant.hangs);
  if (instant.waypoint != kNoWaypoint) {
    const FlatMotion motion = flat_motion(last_, free_end, gravities);
    const Vec3 hangs = motion.particles[1].col(0), end = motion.particles[0].col(0);
    return (hangs + along_ * (end - hangs) - aims_[instant.waypoint]) / kNear;
  }
  const FlatMotion motion = flat_motion(chain_, free_end, gravities);
  const TaylorSeries hand = hand_.origin(motion.particles.back());
  const HandLimits& limits = problem_.limits;
  Eigen::VectorXd terms(kTerms);
  terms << kJerk / jerk_ * 6 * hand.col(3),
      beyond_limit((hand.col(0) - limits.shoulder).norm(), limits.reach),
      beyond_limit(hand.col(1).norm(), limits.speed),
      beyond_limit(2 * hand.col(2).norm(), limits.acceleration),
      kSlackening * std::max(0.0, std::log(kLeastPull * weight_ / motion.tension[0])),
      kBeyond * std::max(0.0, 1 - clearance(motion) / limits.clearance);
  return terms;
}

double FlatFit::cost(const Eigen::VectorXd& coefficients) const {
  double squares = 0;
  for (const Instant& instant : instants_) {
    squares += residuals(instant, free_end(instant.basis, coefficients)).squaredNorm();
  }
  return std::isfinite(squares) ? std::sqrt(squares) : std::numeric_limits<double>::infinity();
}

void FlatFit::linearize(Eigen::MatrixXd& normal, Eigen::VectorXd& slope) const {
  normal.setZero(coefficients_.size(), coefficients_.size());
  slope.setZero(coefficients_.size());
  for (const Instant& instant : instants_) {
    const TaylorSeries series = free_end(instant.basis, coefficients_);
    const Eigen::VectorXd here = residuals(instant, series);
    const Eigen::Index size = 3 * instant.basis.series.rows();
    Eigen::MatrixXd jacobian(here.size(), size);
    for (Eigen::Index k = 0; k < size; ++k) {
      TaylorSeries nudged = series;
      nudged.row(k % 3) += kNudge * instant.basis.series.row(k / 3);
      jacobian.col(k) = (residuals(instant, nudged) - here) / kNudge;
    }
    const Eigen::Index first = 3 * instant.basis.begin;
    normal.block(first, first, size, size) += jacobian.transpose() * jacobian;
    slope.segment(first, size) += jacobian.transpose() * here;
  }
}

// Nielsen, "Damping parameter in Marquardt's method", 1999; the damping is by the diagonal's share,
// so that it has no unit.
double FlatFit::fit(double gravities, double fine) {
  gravities_ = gravities;
  Eigen::MatrixXd normal, damped;
  Eigen::VectorXd slope;
  double now = cost(coefficients_), damping = kFirstDamping, growth = 2;
  linearize(normal, slope);
  for (int trial = 0; trial < kMostTrials; ++trial) {
    if (tick_) tick_();
    damped = normal;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += kRidge * normal.diagonal().maxCoeff();
    const Eigen::VectorXd step = -damped.ldlt().solve(slope);
    const double next = cost(coefficients_ + step);
    const double foreseen = -step.dot(2 * slope + normal * step);  // of the squares
    const double gained = now * now - next * next;
    if (!(gained > 0)) {
      if (!(foreseen > fine * now * now)) break;
      damping *= growth;
      growth *= 2;
      continue;
    }
    coefficients_ += step;
    now = next;
    if (gained <= fine * now * now && foreseen <= fine * now * now) break;
    damping *= std::max(1.0 / 3, 1 - std::pow(2 * gained / foreseen - 1, 3));
    growth = 2;
    linearize(normal, slope);
  }
  return now;
}

void FlatFit::solve(const std::vector<Vec3>& aims, const std::function<void()>& tick) {
  aims_ = aims;
  tick_ = tick;
  double gravities = fitted_ ? 1 : kGravities, step = kFirstStep;
  for (double cost = fitted_ ? 0 : fit(gravities, kRoughly); gravities > 1 && step > kLastStep;) {
    const double next = std::max(1.0, gravities * std::exp(-step));
    const Eigen::VectorXd kept = coefficients_;
    const double now = fit(next, kRoughly);
    if (now < kSmallJump * (cost + 1)) {
      gravities = next;
      cost = now;
      step *= 1.5;
    } else {
      coefficients_ = kept;
      step /= 2;
    }
  }
  fitted_ = true;
  fit(1, kFinely);
}

std::vector<PathKey> FlatFit::keys() const {
  const int steps = steps_of(curve_.spacing / kKeys);
  std::vector<PathKey> keys;
  for (int k = 1; k < steps; ++k) {
    const double time = from_ + (problem_.until - from_) * k / steps;
    const FlatMotion motion =
        flat_motion(chain_, free_end(curve_.at(time, chain_.columns(1)), coefficients_));
    const TaylorSeries& end = motion.particles.back();
    keys.push_back({time, hand_.origin(end).col(0), hand_.rotation(end.col(0))});
  }
  keys.push_back({problem_.until, hand_.origin(hand_.rest()), hand_.rotation(hand_.rest())});
  return keys;
}

double FlatFit::least_tension() const {
  double least = weight_;
  for (const Instant& instant : instants_) {
    least = std::min(least, flat_motion(last_, free_end(instant.basis, coefficients_)).tension[0]);
  }
  return least;
}

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
