#include "sim/contact/contact_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/motion/hash.h"
#include "sim/motion/stop.h"

namespace taut::contact {
namespace {

constexpr double kSingular = 1e-12;    // of a row's own mobility: a pivot below is rounding
constexpr double kNoMobility = 1e-12;  // of a particle's largest mobility: it has none

double or_nothing(double along, const Mat3& mobility) {
  return std::abs(along) > kNoMobility * mobility.lpNorm<Eigen::Infinity>() ? along : 0;
}

}  // namespace

std::vector<std::size_t> ends_that_meet(const Mechanism& mechanism,
                                        std::span<const std::uint32_t> together) {
  const auto& ends = mechanism.row_ends();
  const auto body = [&](const Mechanism::RowEnd& end) {
    const std::uint32_t own = mechanism.body_points()[end.body_point].body;
    return together.empty() ? own : together[own];
  };
  std::vector<std::size_t> count(mechanism.bodies().size()), found;
  for (const auto& end : ends) ++count[body(end)];
  for (std::size_t e = 0; e < ends.size(); ++e) {
    if (count[body(ends[e])] > 1) found.push_back(e);
  }
  return found;
}

void RowSystem::rebuild(const Mechanism& mechanism, std::span<const std::uint32_t> together) {
  const std::size_t rows = mechanism.rows().size();
  for (auto* array : {&diagonal_, &lower_, &upper_, &inverse_pivot_, &scale_}) {
    array->reserve(mechanism.row_room());
    array->assign(rows, 0);
  }
  border_ = ends_that_meet(mechanism, together);
  border_rows_.clear();
  for (const std::size_t end : border_) border_rows_.push_back(mechanism.row_ends()[end].row);
  const auto size = static_cast<Eigen::Index>(border_.size());
  columns_.assign(rows * border_.size(), 0);
  coupling_.resize(size, size);
  share_.resize(size);
}

void RowSystem::assemble(const Mechanism& mechanism, std::span<const Mat3> mobility,
                         std::span<const Vec3> left, std::span<const Vec3> right,
                         const BodyMobility* bodies) {
  const auto& rows = mechanism.rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Row& row = rows[r];
    const Vec3 from_a = mobility[row.a].transpose() * left[r];
    const Vec3 from_b = mobility[row.b].transpose() * left[r];
    const double at_a = or_nothing(from_a.dot(right[r]), mobility[row.a]);
    const double at_b = or_nothing(from_b.dot(right[r]), mobility[row.b]);
    scale_[r] = std::abs(at_a) + std::abs(at_b);
    diagonal_[r] = at_a + at_b;
    // Neighbours share a particle that the one's b and the other's a is.
    lower_[r] = r > 0 && rows[r - 1].b == row.a ? -from_a.dot(right[r - 1]) : 0;
    const bool followed = r + 1 < rows.size() && rows[r + 1].a == row.b;
    upper_[r] = followed ? -from_b.dot(right[r + 1]) : 0;
  }
  add_bodies(mechanism, left, right, bodies);
  eliminate();
  if (border_.empty()) return;
  const std::size_t count = rows.size();
  Eigen::MatrixXd system = Eigen::MatrixXd::Identity(coupling_.rows(), coupling_.cols());
  Eigen::MatrixXd response(coupling_.rows(), coupling_.cols());
  for (std::size_t k = 0; k < border_.size(); ++k) {
    check_stop();
    const std::span column(&columns_[k * count], count);
    std::ranges::fill(column, 0.0);
    column[border_rows_[k]] = 1;
    sweep(column);
    for (std::size_t i = 0; i < border_.size(); ++i) {
      response(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          column[border_rows_[i]];
    }
  }
  system += response * coupling_;
  decomposed_.compute(system);
}

void RowSystem::add_bodies(const Mechanism& mechanism, std::span<const Vec3> left,
                           std::span<const Vec3> right, const BodyMobility* bodies) {
  const auto& ends = mechanism.row_ends();
  const auto mobility = [&](const Mechanism::RowEnd& end, const Mechanism::RowEnd& other) {
    const auto& at = mechanism.body_points()[end.body_point];
    const auto& pulled = mechanism.body_points()[other.body_point];
    const auto& body = mechanism.bodies()[at.body];
    if (bodies) {
      const Mat3 coupled =
          contact::mobility(bodies->between(at.body, pulled.body), at.arm, pulled.arm);
      const double moves = left[end.row].dot(coupled * right[other.row]);
      return end.sign * other.sign * or_nothing(moves, Mat3(body.inverse_mass * Mat3::Identity()));
    }
    const Vec3 turn = at.arm.cross(left[end.row]);
    return end.sign * other.sign *
           (body.inverse_mass * left[end.row].dot(right[other.row]) +
            turn.dot(body.world_inverse * pulled.arm.cross(right[other.row])));
  };
  for (const auto& end : ends) {
    const double own = mobility(end, end);
    diagonal_[end.row] += own;
    scale_[end.row] += std::abs(own);
  }
  for (std::size_t i = 0; i < border_.size(); ++i) {
    for (std::size_t k = 0; k < border_.size(); ++k) {
      const auto &end = ends[border_[i]], &other = ends[border_[k]];
      const std::uint32_t moved = mechanism.body_points()[end.body_point].body;
      const std::uint32_t pulled = mechanism.body_points()[other.body_point].body;
      const bool same = moved == pulled || (bodies && bodies->meet(moved, pulled));
      coupling_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          i != k && same ? mobility(end, other) : 0;
    }
  }
}

void RowSystem::eliminate() {
  double last = 0;  // the inverse pivot before
  for (std::size_t r = 0; r < diagonal_.size(); ++r) {
    const double above = r > 0 ? upper_[r - 1] : 0;
    const double pivot = diagonal_[r] - lower_[r] * last * above;
    last = std::abs(pivot) > kSingular * scale_[r] ? 1 / pivot : 0;
    inverse_pivot_[r] = last;
  }
}

void RowSystem::sweep(std::span<double> x) const {
  for (std::size_t r = 0; r < x.size(); ++r) {
    const double before = r > 0 ? x[r - 1] : 0;
    x[r] = (x[r] - lower_[r] * before) * inverse_pivot_[r];
  }
  for (std::size_t r = x.size(); r-- > 1;) {
    x[r - 1] -= upper_[r - 1] * inverse_pivot_[r - 1] * x[r];
  }
}

void RowSystem::solve(std::span<double> x) const {
  sweep(x);
  if (border_.empty()) return;
  // A = T + E C E', T as swept: x = T^-1 b - T^-1 E C (I + E' T^-1 E C)^-1 E' T^-1 b.
  const std::size_t count = x.size();
  for (std::size_t k = 0; k < border_.size(); ++k) {
    share_[static_cast<Eigen::Index>(k)] = x[border_rows_[k]];
  }
  decomposed_.solve(share_, given_);
  share_.noalias() = coupling_ * given_;
  for (std::size_t k = 0; k < border_.size(); ++k) {
    const double part = share_[static_cast<Eigen::Index>(k)];
    for (std::size_t r = 0; r < count; ++r) x[r] -= part * columns_[k * count + r];
  }
}

namespace {

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

constexpr double kSpare = 1e-9;     // of forces per mass: no event yet
constexpr double kArrives = 1e-10;  // m/s
constexpr double kInPlane = 1e-12;  // m, m/s, rad/s: out of a plane by rounding
constexpr double kLedApart = 1e-6;  // of accelerations: what links that are left out may be off
constexpr double kLonger = 1e-4;    // times that: a string so much too long is taut
constexpr int kProjections = 20;

}  // namespace

void ContactMotion::rebuild(const World& world, double slowest) {
  obstacles_ = world.obstacles;
  slowest_ = slowest;
  mechanism_.rebuild(world);
  radius_.clear();
  category_.clear();
  double longest = 0;
  for (const Connector& connector : world.connectors) {
    longest = std::max(longest, connector.length);
    radius_.insert(radius_.end(), connector.particles(), connector.radius);
    category_.insert(category_.end(), connector.particles(), connector.category);
  }
  for (std::size_t p = 0; p < radius_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) radius_[p] = -1;
  }
  touching_ = kTouching * longest;
  const std::size_t points = mechanism_.points(), rows = mechanism_.rows().size();
  beads_.assign(points, {});
  for (auto* array : {&free_, &pulled_, &added_}) array->assign(points, Vec3::Zero());
  for (auto* array : {&tension_, &change_, &start_}) array->assign(rows, 0);
  mobility_.assign(points, Mat3::Zero());
  taut_.clear();
  for (const Row& row : mechanism_.rows()) taut_.push_back(!row.pulls);
  pulls_ = taut_;
  along_.assign(rows, Vec3::Zero());
  frames_.resize(obstacles_.size());
  rebuild_bodies(world);
  rebuild_parts(world);
  system_.rebuild(mechanism_, bodies_together(meetings_, capsules_.size()));
}

Vec3 ContactMotion::place(const State& state, std::size_t point) const {
  return ConstMap(&state[mechanism_.position(point)]);
}

Vec3 ContactMotion::velocity(const State& state, std::size_t point) const {
  return ConstMap(&state[mechanism_.velocity(point)]);
}

void ContactMotion::move_obstacles(double time) {
  for (std::size_t o = 0; o < obstacles_.size(); ++o) frames_[o] = obstacles_[o].frame(time);
}

/// The motion of the obstacle's material at a place.
PointMotion ContactMotion::surface(const Bead& bead, const Vec3& at) const {
  const FrameMotion& frame = frames_[bead.obstacle];
  return frame.point(frame.rotation.conjugate() * (at - frame.position));
}

/// The acceleration along the normal with which a bead stays on the surface: the second derivative
/// of its distance is zero.
double ContactMotion::least_acceleration(const Bead& bead, const Vec3& at,
                                         const Vec3& velocity) const {
  const FrameMotion& frame = frames_[bead.obstacle];
  const PointMotion carried = surface(bead, at);
  const Vec3 passing = velocity - carried.velocity;
  const Quat back = frame.rotation.conjugate();
  const Vec3 local = back * passing;
  const Vec3 turning =
      obstacles_[bead.obstacle].shape.normal_rate(back * (at - frame.position), local);
  return bead.touch.normal.dot(carried.acceleration + 2 * frame.spin.cross(passing)) -
         turning.dot(local);
}

// Strings among the rows: which are taut, and which of these pull.

namespace {

constexpr double kSeparating = 1e-10;  // m/s, at which ends part
/// m/s: a bead in a corner of two strings bounces between them, ever slower. Ends that approach
/// more slowly than this and are pulled apart again approach by less than a picometre.
constexpr double kSlow = 1e-6;
constexpr double kSpareTension = 1e-9;  // of the tension by which the ends move as they do

}  // namespace

/// The rows' directions; zero for strings that do not pull, so that systems leave these out.
std::span<const Vec3> ContactMotion::pulling() {
  const std::vector<Vec3>& all = mechanism_.direction();
  if (!mechanism_.has_strings()) return all;
  for (std::size_t r = 0; r < all.size(); ++r) {
    along_[r] = pulls_[r] ? all[r] : Vec3(Vec3::Zero());
  }
  return along_;
}

void ContactMotion::begin(double time, State& state) {
  const State before = state;
  mechanism_.update(time, state.data());
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    pulls_[r] = !mechanism_.rows()[r].pulls || mechanism_.violation()[r] >= -touching_;
  }
  project(time, state);
  if (mechanism_.has_strings()) {  // which stop nothing that comes together
    const auto velocities = static_cast<std::ptrdiff_t>(mechanism_.velocity(0));
    std::copy(before.begin() + velocities, before.end(), state.begin() + velocities);
  }
  resolve(time, state);
}

/// Tells the strings that are as long as they may be and not about to be shorter; whether the
/// length of a rod is about to change, or that of such a string to grow.
bool ContactMotion::find_taut(double time, State& state) {
  if (!mechanism_.has_strings()) return false;
  mechanism_.update(time, state.data());
  bool any = false;
  for (std::size_t r = 0; r < taut_.size(); ++r) {
    const double separating = mechanism_.rate()[r];
    if (!mechanism_.rows()[r].pulls) {
      any = any || std::abs(separating) > kSeparating;
      continue;
    }
    taut_[r] = mechanism_.violation()[r] >= -touching_ && separating >= -kSlow;
    if (!taut_[r]) {
      pulls_[r] = false;
      tension_[r] = 0;
    }
    any = any || (taut_[r] && separating > kSeparating);
  }
  return any;
}

/// Lets those strings pull that would part otherwise, under tensions as they are, and no others.
void ContactMotion::sort_strings() {
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    const Row& row = mechanism_.rows()[r];
    if (!row.pulls) continue;
    const double separating =
        (inverse_mass(row.a) + inverse_mass(row.b)) * tension_[r] + change_[r];
    pulls_[r] = taut_[r] && separating > 0;
    if (!pulls_[r]) tension_[r] = 0;
  }
}

/// Of a point, or of the body that carries it, 1/kg.
double ContactMotion::inverse_mass(std::size_t point) const {
  if (!is_carried_[point]) return mechanism_.inverse_mass()[point];
  const auto carried =
      std::ranges::find(mechanism_.body_points(), point, &Mechanism::BodyPoint::point);
  return mechanism_.bodies()[carried->body].inverse_mass;
}

/// By how much (N) a string may push, as roundings do, before it goes slack.
double ContactMotion::spare(std::size_t row) const {
  const Row& at = mechanism_.rows()[row];
  const std::size_t point = inverse_mass(at.a) > inverse_mass(at.b) ? at.a : at.b;
  if (!(inverse_mass(point) > 0)) return 1;
  return kSpareTension * (free_[point].norm() + pulled_[point].norm()) / inverse_mass(point);
}

// Free bodies in the smooth motion among obstacles: how they respond to pulls and to what their
// capsules touch.

namespace {

constexpr double kNudge = 2e-3;    // of a curve: the step of a difference
constexpr double kLongest = 1e-4;  // s, of it

/// A frame after so many seconds.
FrameMotion later(const FrameMotion& frame, double time) {
  FrameMotion moved = frame;
  moved.position += time * (frame.velocity + time / 2 * frame.acceleration);
  moved.velocity += time * frame.acceleration;
  moved.spin += time * frame.spin_rate;
  const Vec3 turn = time * (frame.spin + time / 2 * frame.spin_rate);
  const double size = turn.norm();
  if (size > 0) moved.rotation = Quat(Eigen::AngleAxisd(size, turn / size)) * frame.rotation;
  return moved;
}

Vec3 surface_velocity(const FrameMotion& frame, const Vec3& at) {
  return frame.velocity + frame.spin.cross(at - frame.position);
}

}  // namespace

void ContactMotion::rebuild_bodies(const World& world) {
  capsules_ = capsules_of_free_bodies(world);
  meetings_ = meetings_of_bodies(world, world.obstacles, world.pairs);
  is_carried_.assign(mechanism_.points(), false);
  for (const auto& carried : mechanism_.body_points()) is_carried_[carried.point] = true;
  double longest = 0;
  for (const BodyCapsule& capsule : capsules_) {
    if (capsule.touches()) longest = std::max(longest, (capsule.to - capsule.from).norm());
  }
  if (touching_ == 0) touching_ = kTouching * (longest > 0 ? longest : 1);
  for (auto* array : {&body_free_, &body_pulled_, &body_added_, &twists_}) {
    array->assign(capsules_.size(), Vec6::Zero());
  }
  body_mobility_.assign(capsules_.size(), Mat6::Zero());
  body_coupled_.set_apart(body_mobility_);
  body_touches_.clear();
}

Capsule ContactMotion::capsule(const State& state, std::size_t body) const {
  if (is_part(small(body))) return capsule_of_part(state, part(small(body)));
  const double* q = &state[mechanism_.pose(body)];
  const Quat rotation = quaternion(q + 3).normalized();
  const BodyCapsule& own = capsules_[body];
  const Vec3 centre = ConstMap(q);
  return {centre + rotation * own.from, centre + rotation * own.to, own.radius};
}

Vec6 ContactMotion::twist(const State& state, std::size_t body) const {
  return Eigen::Map<const Vec6>(&state[mechanism_.twist(body)]);
}

/// Where what a body may touch is.
Pose ContactMotion::solid(const BodyMeeting& meeting, const State& state) const {
  if (meeting.other == kNoBody) return frames_[meeting.obstacle].pose();
  const double* q = &state[mechanism_.pose(meeting.other)];
  return pose_of_solid(meeting, ConstMap(q), quaternion(q + 3).normalized());
}

/// Tells a touch where it is; the gap there.
SpotGap ContactMotion::aim(BodyTouch& at, const State& state) const {
  const BodyMeeting& meeting = meetings_[at.meeting];
  const Capsule own = capsule(state, at.body);
  const Pose place = solid(meeting, state);
  if (is_part(at.body)) {
    const SpotGap near = gap_of_part(at, place, own);
    at.touch.normal = near.normal;
    at.share = near.along;
    at.arm = own.at(near.along);
    return near;
  }
  const SpotGap near = gap_at(meeting.shape, place, own, at.spot);
  const Vec3 there = own.at(near.along) - own.radius * near.normal;
  at.touch.normal = near.normal;
  at.arm = there - ConstMap(&state[mechanism_.pose(at.body)]);
  if (at.other != kNoBody) at.other_arm = there - ConstMap(&state[mechanism_.pose(at.other)]);
  return near;
}

/// The place of a touch, of a link on its line.
Vec3 ContactMotion::where(const BodyTouch& at, const State& state) const {
  if (is_part(at.body)) return at.arm;
  return ConstMap(&state[mechanism_.pose(at.body)]) + at.arm;
}

/// The velocity of a body past what it touches, there.
Vec3 ContactMotion::passing(const BodyTouch& at, const State& state) const {
  const Vec3 moves =
      is_part(at.body) ? velocity_of_part(at, state) : velocity_at(twist(state, at.body), at.arm);
  if (at.other != kNoBody) return moves - velocity_at(twist(state, at.other), at.other_arm);
  return moves - surface_velocity(frames_[meetings_[at.meeting].obstacle], where(at, state));
}

/// m/s: no point of what touches there moves faster past another.
double ContactMotion::quickness(const BodyTouch& at, const State& state) const {
  const BodyMeeting& meeting = meetings_[at.meeting];
  const Vec6 moves = twist(state, at.body);
  const double length = (capsules_[at.body].to - capsules_[at.body].from).norm();
  const double curve = capsules_[at.body].radius + std::min(meeting.shape.sharpest(), 1.0);
  if (at.other != kNoBody) {
    const Vec6 other = twist(state, at.other);
    return moves.head<3>().norm() + other.head<3>().norm() +
           (moves.tail<3>().norm() + other.tail<3>().norm()) *
               (length + meeting.shape.length + curve);
  }
  const FrameMotion& frame = frames_[meeting.obstacle];
  return moves.head<3>().norm() + frame.velocity.norm() +
         (moves.tail<3>().norm() + frame.spin.norm()) * (length + curve);
}

/// Asks for the accelerations with which a body stays on the surface, and with which it does not
/// slide: they cancel the acceleration of its passing under the present twists and motions. The
/// touch's point travels along both.
void ContactMotion::ask_accelerations(BodyTouch& at, const State& state) const {
  if (is_part(at.body)) return ask_of_part(at, state);
  const BodyMeeting& meeting = meetings_[at.meeting];
  const double curve = capsules_[at.body].radius + std::min(meeting.shape.sharpest(), 1.0);
  const double step =
      std::min(kLongest, kNudge * std::max(curve, 1e-3) / std::max(quickness(at, state), 1e-9));
  Vec3 past = Vec3::Zero();
  double separating = 0;
  State moved = state;
  const auto move = [&](std::size_t body, double time) {
    double* q = &moved[mechanism_.pose(body)];
    const Vec6 moves = twist(state, body);
    std::copy_n(&state[mechanism_.pose(body)], 7, q);
    Map{q} += time * moves.head<3>();
    rotate(time * moves.tail<3>(), q + 3);
    return moves;
  };
  for (const auto& [times, weight] :
       {std::pair(-2.0, 1.0), std::pair(-1.0, -8.0), std::pair(1.0, 8.0), std::pair(2.0, -1.0)}) {
    const Vec6 moves = move(at.body, times * step);
    const Vec6 others = at.other != kNoBody ? move(at.other, times * step) : Vec6(Vec6::Zero());
    FrameMotion frame;
    if (at.other == kNoBody) frame = later(frames_[meeting.obstacle], times * step);
    const Pose place = at.other != kNoBody ? solid(meeting, moved) : frame.pose();
    const Capsule own = capsule(moved, at.body);
    const SpotGap near = gap_at(meeting.shape, place, own, at.spot);
    const Vec3 point = own.at(near.along) - own.radius * near.normal;
    const Vec3 surface =
        at.other != kNoBody
            ? velocity_at(others, point - ConstMap(&moved[mechanism_.pose(at.other)]))
            : surface_velocity(frame, point);
    const Vec3 passes =
        velocity_at(moves, point - ConstMap(&moved[mechanism_.pose(at.body)])) - surface;
    past += weight / (12 * step) * passes;
    separating += weight / (12 * step) * near.normal.dot(passes);
  }
  at.touch.surface = -past;
  at.touch.least = -separating;
}

/// Accelerations (or velocities) of bodies without links and touches.
void ContactMotion::free_bodies(const State* velocities) {
  for (std::size_t b = 0; b < body_free_.size(); ++b) {
    body_free_[b] << mechanism_.gravity(), mechanism_.bodies()[b].gyration;
    if (velocities) body_free_[b] = twist(*velocities, b);
  }
}

/// How bodies respond without what they touch.
void ContactMotion::free_mobilities() {
  for (std::size_t b = 0; b < body_mobility_.size(); ++b) {
    const auto& body = mechanism_.bodies()[b];
    body_mobility_[b] = contact::mobility(body.inverse_mass, body.world_inverse);
  }
  body_coupled_.set_apart(body_mobility_);
}

/// Adds what touches give to the bodies that the system has.
void ContactMotion::add_twists(std::span<const BodyTouch> touches, std::span<Vec6> twists) const {
  for (std::size_t i = 0; i < body_system_.bodies().size(); ++i) {
    twists[body_system_.bodies()[i]] += body_system_.twist(touches, i);
  }
}

/// The response of bodies, and of the points that they carry, to `tension`: in the touches' present
/// states (`held`) or in those that the laws ask for.
void ContactMotion::couple_bodies(std::span<const double> tension, std::span<const Vec3> along,
                                  bool held) {
  if (body_free_.empty()) return;
  std::ranges::fill(body_pulled_, Vec6::Zero());
  free_mobilities();
  for (const auto& end : mechanism_.row_ends()) {
    const auto& carried = mechanism_.body_points()[end.body_point];
    const Vec3 pull = end.sign * tension[end.row] * along[end.row];
    body_pulled_[carried.body] += body_mobility_[carried.body] * wrench(pull, carried.arm);
  }
  body_added_ = body_pulled_;
  for (std::size_t b = 0; b < twists_.size(); ++b) twists_[b] = body_free_[b] + body_pulled_[b];
  clusters_.each(body_touches_, [&](std::size_t first, std::size_t count) {
    const std::span touches(&body_touches_[first], count);
    std::vector<Vec3> bare;
    for (const BodyTouch& at : touches) bare.push_back(contact::passing(twists_, at));
    body_system_.assemble(body_mobility_, touches);
    if (held) {
      body_system_.hold(bare, touches);
    } else if (!body_system_.solve(bare, touches, 0)) {
      throw Unresolved{0, "contact and friction of a body have no solution"};
    }
    add_twists(touches, body_added_);
    body_system_.couple(touches, body_coupled_);
  });
  for (const auto& carried : mechanism_.body_points()) {
    added_[carried.point] = velocity_at(body_added_[carried.body], carried.arm);
  }
}

/// Aims the closed touches of bodies and the accelerations that they ask for.
void ContactMotion::aim_bodies(const State& state) {
  for (BodyTouch& at : body_touches_) {
    aim(at, state);
    ask_accelerations(at, state);
    const Vec3 slip = passing(at, state);
    const Vec3 across = slip - at.touch.normal.dot(slip) * at.touch.normal;
    if (at.touch.state != Touch::State::slides) continue;
    at.ahead = at.touch.sliding;  // the way in which it began
    if (across.norm() > still(at)) at.ahead = heading(across, at.touch.sliding);
  }
}

/// Takes bodies back to surfaces and from velocities that leave them; returns the largest gap (m).
double ContactMotion::project_bodies(State& state) {
  double worst = 0;
  free_mobilities();
  clusters_.each(body_touches_, [&](std::size_t first, std::size_t count) {
    std::vector<BodyTouch> touches(&body_touches_[first], &body_touches_[first] + count);
    std::vector<BodyTouch> normals = touches;
    std::vector<Vec3> apart, bare;
    for (std::size_t i = 0; i < touches.size(); ++i) {
      BodyTouch& at = touches[i];
      const SpotGap near = aim(at, state);
      worst = std::max(worst, std::abs(near.distance));
      apart.push_back(near.distance * near.normal);
      bare.push_back(passing(at, state));
      at.touch.least = at.touch.slide = 0;
      at.touch.surface.setZero();
      normals[i] = at;
      normals[i].touch.state = Touch::State::slides;
    }
    body_system_.assemble(body_mobility_, normals);
    body_system_.hold(apart, normals);
    std::ranges::fill(twists_, Vec6::Zero());
    add_twists(normals, twists_);
    body_system_.assemble(body_mobility_, touches);
    body_system_.hold(bare, touches);
    body_system_.couple(touches, body_coupled_);
    for (std::size_t i = 0; i < body_system_.bodies().size(); ++i) {
      const std::uint32_t b = body_system_.bodies()[i];
      Eigen::Map<Vec6>(&state[mechanism_.twist(b)]) += body_system_.twist(touches, i);
      double* q = &state[mechanism_.pose(b)];
      Map{q} += twists_[b].head<3>();
      rotate(twists_[b].tail<3>(), q + 3);
    }
  });
  return worst;
}

/// Moves bodies as rows' impulses `change_` change their velocities, or poses by as much.
void ContactMotion::shift_bodies(std::span<const Vec3> along, bool poses, State& state) {
  std::ranges::fill(body_pulled_, Vec6::Zero());
  for (const auto& end : mechanism_.row_ends()) {
    const auto& carried = mechanism_.body_points()[end.body_point];
    const Vec3 pull = end.sign * change_[end.row] * along[end.row];
    const Vec6 by = wrench(pull, carried.arm);
    for (const std::uint32_t moved : body_coupled_.moved_with(carried.body)) {
      body_pulled_[moved] += body_coupled_.between(moved, carried.body) * by;
    }
  }
  for (std::size_t b = 0; b < body_pulled_.size(); ++b) {
    if (poses) {
      double* q = &state[mechanism_.pose(b)];
      Map{q} += body_pulled_[b].head<3>();
      rotate(body_pulled_[b].tail<3>(), q + 3);
    } else {
      Eigen::Map<Vec6>(&state[mechanism_.twist(b)]) += body_pulled_[b];
    }
  }
}

// Links as capsules in the smooth motion between events, and the beads beside them.

namespace {

constexpr double kBeyond = 0.25;     // of a link: its line goes on so far beyond its beads
constexpr double kLevel = 1e-9;      // rad: a link that rises by less lies level
constexpr double kAtBead = 1e-4;     // of a link, from its bead: they are one place
constexpr double kAtEnd = 1e-6;      // of a link or an axis: a spot so near to an end is the end
constexpr double kBeside = 1e-6;     // of a link, beside the end of what it lies on
constexpr double kStraight = 1e-12;  // 1/m: a solid that bends by less is straight along a link
constexpr double kLevelled = 1e-10;  // of a link: ends that are no farther than the nearest
constexpr double kBroken = 1e-6;     // of accelerations: by so much a closed touch may be broken

/// Whether a link lies flat on a face, or nearly so.
bool lies_evenly(const std::array<SpotGap, 5>& gaps) {
  return gaps[static_cast<std::size_t>(Spot::first)].even;
}

}  // namespace

/// Where links touch, beads and links are parts that meet obstacles.
void ContactMotion::rebuild_parts(const World& world) {
  parts_.clear();
  if (!has_touching_links(world)) return;
  const auto meet = [&](const Part& part, const Connector& of) {
    const auto number = small(capsules_.size() + parts_.size());
    parts_.push_back(part);
    add_meetings(number, of.category, obstacles_, meetings_);
  };
  std::uint32_t first = 0;
  const auto& mobile = mechanism_.inverse_mass();
  for (const Connector& connector : world.connectors) {
    const auto end = small(first + connector.particles());
    for (std::uint32_t p = first; p < end; ++p) {
      if (mobile[p] > 0) meet({p, p, connector.radius}, connector);
      if (p + 1 == end || !connector.links_touch) continue;
      if (inverse_mass(p) > 0 || inverse_mass(p + 1) > 0) {
        meet({p, p + 1, connector.radius}, connector);
      }
    }
    first = end;
  }
  std::ranges::fill(radius_, -1);  // no bead touches by itself
}

Capsule ContactMotion::capsule_of_part(const State& state, const Part& part) const {
  return {place(state, part.first), place(state, part.next), part.radius};
}

/// The gap of a touch. Between its beads it stays one of the line of its link beyond these as well,
/// until the event in which it gets there.
SpotGap ContactMotion::gap_of_part(const BodyTouch& at, const Pose& place,
                                   const Capsule& own) const {
  const Shape& shape = meetings_[at.meeting].shape;
  if (at.spot != Spot::nearest) {
    const SpotGap near = gap_at(shape, place, own, at.spot);
    if (part(at.body).is_bead() || near.even) return near;
  }
  const Vec3 more = kBeyond * (own.to - own.from);
  SpotGap near =
      gap_at(shape, place, Capsule{own.from - more, own.to + more, own.radius}, Spot::nearest);
  near.along = (1 + 2 * kBeyond) * near.along - kBeyond;
  return near;
}

/// m/s, of its line where it touches.
Vec3 ContactMotion::velocity_of_part(const BodyTouch& at, const State& state) const {
  const Part& own = part(at.body);
  return (1 - at.share) * velocity(state, own.first) + at.share * velocity(state, own.next);
}

/// The acceleration of a point that is held or carried, of which neither forces nor twists have a
/// part: along a path, or about the centre of mass.
Vec3 ContactMotion::led(const State& state, std::uint32_t point) const {
  if (const std::uint32_t c = carrier(point); c != kNoBody) {
    const Mechanism::BodyPoint& carried = mechanism_.body_points()[c];
    const Vec3 spin = twist(state, carried.body).tail<3>();
    return spin.cross(spin.cross(carried.arm));
  }
  if (mechanism_.inverse_mass()[point] > 0) return Vec3::Zero();
  return mechanism_.point_acceleration()[point];
}

/// Asks for the accelerations with which a part stays on the surface, and with which it does not
/// slide. In the frame of the obstacle, with the normal n at p = (1 - s) a + s b, the way
/// w = b - a, the velocity v there and the derivative H of the normal by the place, n w = 0 gives
///   s' = -(w H v + n w')/(w H w),   0 = d/dt (n v) = n p'' + (v + s' w) H v + s' n w'.
void ContactMotion::ask_of_part(BodyTouch& at, const State& state) const {
  const BodyMeeting& meeting = meetings_[at.meeting];
  const Part& own = part(at.body);
  const FrameMotion& frame = frames_[meeting.obstacle];
  const Quat back = frame.rotation.conjugate();
  const Vec3 local = back * (at.arm - frame.position), n = back * at.touch.normal;
  const PointMotion carried = frame.point(local);
  const Vec3 passes = velocity_of_part(at, state) - carried.velocity;
  Vec3 asked = carried.acceleration + 2 * frame.spin.cross(passes);
  asked -= (1 - at.share) * led(state, own.first) + at.share * led(state, own.next);
  const Vec3 way = place(state, own.next) - place(state, own.first);
  const Vec3 w = back * way, v = back * passes;
  const Vec3 turns =
      back * (velocity(state, own.next) - velocity(state, own.first) - frame.spin.cross(way));
  Vec3 there = local;  // what tips about the end of a face rolls over the edge beside it
  if (at.spot == Spot::first) there -= kBeside * w;
  if (at.spot == Spot::last) there += kBeside * w;
  const Vec3 bends = meeting.shape.normal_rate(there, w);
  const double curve = bends.dot(w);
  const double travels =
      curve > kStraight * w.squaredNorm() ? -(bends.dot(v) + n.dot(turns)) / curve : 0;
  const Vec3 rate = meeting.shape.normal_rate(there, v + travels * w);
  at.touch.least = at.touch.normal.dot(asked) - rate.dot(v) - travels * n.dot(turns);
  at.touch.surface = asked - travels * (frame.rotation * turns);
}

/// m/s^2, without pulls and touches. What is held has none of its own where links touch.
Vec3 ContactMotion::weight(std::size_t point) const {
  const bool held = mechanism_.inverse_mass()[point] == 0;
  return held && !parts_.empty() ? Vec3(Vec3::Zero()) : mechanism_.gravity();
}

/// By how much the distance from a solid rises along a link, at one of its ends.
double ContactMotion::slope(const BodyMeeting& meeting, const State& state, double along) const {
  const Capsule own = capsule(state, meeting.body);
  return gap_at(meeting.shape, solid(meeting, state), own, along)
      .normal.dot((own.to - own.from).normalized());
}

/// Whether a spot is one that may touch: a bead; the nearest of a link between its beads, however
/// close to one; or both ends of what lies flat.
bool ContactMotion::is_place(const BodyMeeting& meeting, const State& state,
                             const std::array<SpotGap, 5>& gaps, Spot spot) const {
  const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
  if (!is_part(meeting.body)) return near.distinct;
  if (part(meeting.body).is_bead()) return spot == Spot::from;
  if (spot == Spot::from || spot == Spot::to) return false;
  const bool flat = lies_evenly(gaps);
  const auto inside = [&](double by) { return near.along > by && near.along < 1 - by; };
  if (meeting.shape.kind == Shape::Kind::plane || flat != (spot != Spot::nearest)) return false;
  if (flat) return inside(kAtEnd);
  const double level =
      near.distance +
      kLevelled *
          (place(state, part(meeting.body).next) - place(state, part(meeting.body).first)).norm();
  if (gaps[0].distance <= level && gaps[1].distance <= level) return false;  // its beads touch
  if (inside(kAtBead)) return true;
  return slope(meeting, state, 0) < -kLevel / 2 && slope(meeting, state, 1) > kLevel / 2;
}

/// Opens beads where a link beside them touches at the same place.
void ContactMotion::leave_to_links() {
  const auto is_there = [&](const BodyTouch& at, std::uint32_t point, std::uint32_t obstacle) {
    if (part(at.body).is_bead() || meetings_[at.meeting].obstacle != obstacle) return false;
    return (part(at.body).first == point && at.share < kAtBead) ||
           (part(at.body).next == point && at.share > 1 - kAtBead);
  };
  const auto links = std::vector<BodyTouch>(body_touches_);
  std::erase_if(body_touches_, [&](const BodyTouch& bead) {
    if (!is_part(bead.body) || !part(bead.body).is_bead()) return false;
    return std::ranges::any_of(links, [&](const BodyTouch& at) {
      return is_part(at.body) &&
             is_there(at, part(bead.body).first, meetings_[bead.meeting].obstacle);
    });
  });
}

/// The events of a closed touch of a part: a link gets to its bead, or a bead to a link; a law is
/// broken, as what touches is led apart.
void ContactMotion::part_events(const BodyTouch& at, const State& state,
                                std::vector<double>& values) const {
  const BodyMeeting& meeting = meetings_[at.meeting];
  values.push_back(kBroken * stir(at) - off(at));
  if (!part(at.body).is_bead()) {
    const bool flat =
        lies_evenly(all_gaps(meeting.shape, solid(meeting, state), capsule(state, at.body)));
    values.push_back(flat == (at.spot != Spot::nearest) ? 1 : -1);
    if (at.spot != Spot::nearest) {
      values.push_back(std::min(at.share, 1 - at.share) - kAtEnd);
      return;
    }
    values.push_back(-slope(meeting, state, 0));
    values.push_back(slope(meeting, state, 1));
    return;
  }
  if (meeting.shape.kind == Shape::Kind::plane) return;
  const std::uint32_t point = part(at.body).first;
  for (const BodyMeeting& other : meetings_) {
    if (!is_part(other.body) || other.obstacle != meeting.obstacle) continue;
    const Part& link = part(other.body);
    if (link.is_bead() || (link.first != point && link.next != point)) continue;
    const double along = link.first == point ? 0 : 1;
    const bool flat =
        lies_evenly(all_gaps(other.shape, solid(other, state), capsule(state, other.body)));
    values.push_back(flat ? 1 : kLevel + (1 - 2 * along) * slope(other, state, along));
  }
}

/// m/s^2, by which a closed touch breaks its law under what was found last.
double ContactMotion::off(const BodyTouch& at) const {
  const Vec3 moves = passing(after_impact(), at);
  const double apart = moves.dot(at.touch.normal) - at.touch.least;
  if (at.touch.state != Touch::State::sticks) return std::abs(apart);
  return std::hypot(apart, (across(at.touch.normal) * (moves - at.touch.surface)).norm());
}

/// The number among the body points; kNoBody: no free body carries it.
std::uint32_t ContactMotion::carrier(std::uint32_t point) const {
  if (!is_carried_[point]) return kNoBody;
  const auto found =
      std::ranges::find(mechanism_.body_points(), point, &Mechanism::BodyPoint::point);
  return small(std::size_t(found - mechanism_.body_points().begin()));
}

// Where links touch: all links and all touches of a world as one system.

namespace {

constexpr double kOfRounding = 1e-12;  // of velocities or accelerations: by rounding
constexpr int kAtOnce = 20;            // changes of all strings that have to
constexpr int kOneByOne = 1000;        // of the last of these alone, which ends (Murty, 1974)
constexpr int kReturns = 20;

}  // namespace

ContactMotion::Motion ContactMotion::no_motion() const {
  return {std::vector<Vec3>(beads_.size(), Vec3::Zero()),
          std::vector<Vec6>(capsules_.size(), Vec6::Zero())};
}

Vec3 ContactMotion::velocity_of(const Motion& motion, std::uint32_t point) const {
  const std::uint32_t c = carrier(point);
  if (c == kNoBody) return motion.points[point];
  const Mechanism::BodyPoint& carried = mechanism_.body_points()[c];
  return velocity_at(motion.bodies[carried.body], carried.arm);
}

/// The velocity of what touches there: of a body past the other, if there is one.
Vec3 ContactMotion::passing(const Motion& motion, const BodyTouch& at) const {
  if (!is_part(at.body)) return contact::passing(motion.bodies, at);
  const Part& own = part(at.body);
  return (1 - at.share) * velocity_of(motion, own.first) + at.share * velocity_of(motion, own.next);
}

/// Adds what an impulse at a point does to it, or to the body that carries it.
void ContactMotion::give(std::uint32_t point, const Vec3& impulse, Motion& motion) const {
  const std::uint32_t c = carrier(point);
  if (c == kNoBody) {
    motion.points[point] += mechanism_.inverse_mass()[point] * impulse;
    return;
  }
  const Mechanism::BodyPoint& carried = mechanism_.body_points()[c];
  motion.bodies[carried.body] += body_mobility_[carried.body] * wrench(impulse, carried.arm);
}

/// Adds what an impulse of a touch does: to the beads of a link by the lever rule.
void ContactMotion::give(const BodyTouch& at, const Vec3& impulse, Motion& motion) const {
  if (is_part(at.body)) {
    const Part& own = part(at.body);
    give(own.first, (1 - at.share) * impulse, motion);
    if (at.share != 0) give(own.next, at.share * impulse, motion);
    return;
  }
  const auto turn = [&](std::uint32_t body, const Vec3& arm, const Vec3& by) {
    motion.bodies[body] += body_mobility_[body] * wrench(by, arm);
  };
  turn(at.body, at.arm, impulse);
  if (at.other != kNoBody) turn(at.other, at.other_arm, -impulse);
}

/// Adds what tensions do.
void ContactMotion::pull(std::span<const double> tension, std::span<const Vec3> along,
                         Motion& motion) const {
  const auto& rows = mechanism_.rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (tension[r] == 0) continue;
    give(rows[r].a, tension[r] * along[r], motion);
    give(rows[r].b, -tension[r] * along[r], motion);
  }
}

/// The tensions under which no link gets longer that would by `rate` and a motion, to which they
/// add what they do.
std::vector<double> ContactMotion::answer(std::span<const double> rate, std::span<const Vec3> along,
                                          Motion& motion) const {
  const auto& rows = mechanism_.rows();
  std::vector<double> tension(rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (!pulls_[r]) continue;
    tension[r] =
        rate[r] + along[r].dot(velocity_of(motion, rows[r].b) - velocity_of(motion, rows[r].a));
  }
  system_.solve(tension);
  for (std::size_t r = 0; r < rows.size(); ++r) tension[r] *= pulls_[r];
  pull(tension, along, motion);
  return tension;
}

/// How touches respond to what each of them gives, with all links; the directions of these.
std::span<const Vec3> ContactMotion::assemble_together() {
  const std::span<const Vec3> along = pulling();
  free_mobilities();
  for (std::size_t p = 0; p < mobility_.size(); ++p) {
    mobility_[p] = mechanism_.inverse_mass()[p] * Mat3::Identity();
  }
  system_.assemble(mechanism_, mobility_, along, along, &body_coupled_);
  ++solves_;
  const std::vector<double> at_rest(along.size(), 0);
  const auto count = static_cast<Eigen::Index>(body_touches_.size());
  Eigen::MatrixXd coupling(3 * count, 3 * count);
  std::vector<double> inverse_masses;
  for (Eigen::Index k = 0; k < count; ++k) {
    const BodyTouch& by = body_touches_[static_cast<std::size_t>(k)];
    inverse_masses.push_back(inverse_mass(by));
    for (int axis = 0; axis < 3; ++axis) {
      Motion motion = no_motion();
      give(by, Vec3::Unit(axis), motion);
      answer(at_rest, along, motion);
      for (Eigen::Index i = 0; i < count; ++i) {
        coupling.block<3, 1>(3 * i, 3 * k + axis) =
            passing(motion, body_touches_[static_cast<std::size_t>(i)]);
      }
    }
  }
  body_system_.assemble(coupling, inverse_masses);
  return along;
}

/// The response of all where rows get longer at the rates `start` without: in the touches' present
/// states (`held`) or in those that the laws ask for. Finds tension_, what is added, and in change_
/// how rows go on getting longer. False: no solution.
bool ContactMotion::respond_together(std::span<const double> start, bool held) {
  const std::span<const Vec3> along = assemble_together();
  const Motion free{free_, body_free_};
  Motion pulled = no_motion(), given = no_motion();
  tension_ = answer(start, along, pulled);
  std::vector<Vec3> bare;
  for (const BodyTouch& at : body_touches_) bare.push_back(passing(free, at) + passing(pulled, at));
  if (held) {
    body_system_.hold(bare, body_touches_);
  } else if (!body_system_.solve(bare, body_touches_, 0)) {
    return false;
  }
  for (const BodyTouch& at : body_touches_) give(at, at.given, given);
  const Motion touched = given;
  const std::vector<double> at_rest(along.size(), 0);
  const std::vector<double> more = answer(at_rest, along, given);
  for (std::size_t r = 0; r < more.size(); ++r) tension_[r] += more[r];
  for (std::size_t p = 0; p < added_.size(); ++p) {
    added_[p] = pulled.points[p] + given.points[p];
    pulled_[p] = added_[p] - touched.points[p];
  }
  for (std::size_t b = 0; b < body_added_.size(); ++b) {
    body_added_[b] = pulled.bodies[b] + given.bodies[b];
    body_pulled_[b] = body_added_[b] - touched.bodies[b];
  }
  for (const auto& carried : mechanism_.body_points()) {
    added_[carried.point] = velocity_at(body_added_[carried.body], carried.arm);
  }
  const auto& rows = mechanism_.rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    change_[r] = start[r] + mechanism_.direction()[r].dot(added_[rows[r].b] - added_[rows[r].a]);
  }
  return true;
}

/// Tensions and what touches give, by the laws of all.
void ContactMotion::balance_together(std::span<const double> start) {
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    pulls_[r] = taut_[r] && (pulls_[r] || !mechanism_.rows()[r].pulls);
  }
  for (int i = 0; i < kAtOnce + kOneByOne; ++i) {
    if (!respond_together(start, false)) break;
    if (!swap_strings(i < kAtOnce)) return;
    for (BodyTouch& at : body_touches_) at.given.setZero();
  }
  throw Unresolved{0, "contact and friction have no solution"};
}

/// Lets strings go that push, and others pull that would part; the last of them alone or `all`.
/// Whether there were any.
bool ContactMotion::swap_strings(bool all) {
  if (!mechanism_.has_strings()) return false;
  double scale = 1;
  for (std::size_t p = 0; p < free_.size(); ++p) {
    scale = std::max({scale, free_[p].norm(), pulled_[p].norm()});
  }
  bool any = false;
  for (std::size_t r = pulls_.size(); r-- > 0 && (all || !any);) {
    const Row& row = mechanism_.rows()[r];
    if (!row.pulls || !taut_[r]) continue;
    const double by =
        pulls_[r] ? -(inverse_mass(row.a) + inverse_mass(row.b)) * tension_[r] : change_[r];
    if (by <= kOfRounding * scale) continue;
    pulls_[r] = !pulls_[r];
    any = true;
  }
  return any;
}

/// Takes all back to lengths and surfaces, and from velocities that leave them; returns the largest
/// of what was off (m).
double ContactMotion::project_together(double time, State& state) {
  double worst = 0;
  for (std::size_t b = 0; b < capsules_.size(); ++b) {
    double* q = &state[mechanism_.pose(b) + 3];
    set_quaternion(quaternion(q).normalized(), q);
  }
  for (int i = 0; i < kReturns; ++i) {
    mechanism_.update(time, state.data());
    worst = 0;
    std::vector<Vec3> apart, passes;
    for (BodyTouch& at : body_touches_) {
      const SpotGap near = aim(at, state);
      worst = std::max(worst, std::abs(near.distance));
      apart.push_back(near.distance * near.normal);
      passes.push_back(passing(at, state));
    }
    for (std::size_t r = 0; r < pulls_.size(); ++r) {
      if (pulls_[r]) worst = std::max(worst, std::abs(mechanism_.violation()[r]));
    }
    const std::span<const Vec3> along = assemble_together();
    const auto back = [&](std::span<const double> rate, std::vector<Vec3> off, bool places) {
      std::vector<BodyTouch> touches = body_touches_;
      Motion way = no_motion();
      answer(rate, along, way);
      for (std::size_t k = 0; k < touches.size(); ++k) {
        Touch& touch = touches[k].touch;
        touch.least = touch.slide = 0;
        touch.surface.setZero();
        if (places) touch.state = Touch::State::slides;
        off[k] += passing(way, touches[k]);
      }
      body_system_.hold(off, touches);
      Motion given = no_motion();
      for (const BodyTouch& at : touches) give(at, at.given, given);
      answer(std::vector<double>(rate.size(), 0), along, given);
      shift(way, places, state);
      shift(given, places, state);
    };
    back(mechanism_.rate(), passes, false);
    if (worst < 1e-3 * touching_) break;
    back(mechanism_.violation(), apart, true);
  }
  mechanism_.place(time, state.data());
  return worst;
}

/// Adds a motion to velocities, or a way to places.
void ContactMotion::shift(const Motion& way, bool places, State& state) const {
  const std::size_t offset = places ? mechanism_.position(0) : mechanism_.velocity(0);
  for (std::size_t p = 0; p < way.points.size(); ++p) Map(&state[offset + 3 * p]) += way.points[p];
  for (std::size_t b = 0; b < way.bodies.size(); ++b) {
    if (!places) {
      Eigen::Map<Vec6>(&state[mechanism_.twist(b)]) += way.bodies[b];
      continue;
    }
    double* q = &state[mechanism_.pose(b)];
    Map{q} += way.bodies[b].head<3>();
    rotate(way.bodies[b].tail<3>(), q + 3);
  }
}

// Free bodies in the smooth motion between events: its ends, and their consequences.

namespace {

constexpr double kFly = 1e-3;  // m/s^2, for what flies together without any force
constexpr double kFar = 1;     // an event that is none

/// A touch that is not aimed yet.
BodyTouch touch_of(std::span<const BodyMeeting> meetings, std::uint32_t index, Spot spot) {
  const BodyMeeting& meeting = meetings[index];
  BodyTouch made{
      .body = meeting.body, .other = meeting.other, .meeting = index, .spot = spot, .touch = {}};
  made.touch.stick = meeting.static_friction;
  made.touch.slide = meeting.kinetic_friction;
  return made;
}

}  // namespace

void ContactMotion::body_events(const State& state, std::vector<double>& values) const {
  for (std::uint32_t m = 0; m < meetings_.size(); ++m) {
    const BodyMeeting& meeting = meetings_[m];
    const Capsule own = capsule(state, meeting.body);
    const auto gaps = all_gaps(meeting.shape, solid(meeting, state), own);
    for (const Spot spot : kSpots) {
      const auto is_here = [&](const BodyTouch& at) { return at.meeting == m && at.spot == spot; };
      if (std::ranges::any_of(body_touches_, is_here)) continue;
      const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
      double value = is_place(meeting, state, gaps, spot) ? near.distance + touching_ / 2 : kFar;
      if (value < 0) {
        BodyTouch there = touch_of(meetings_, m, spot);
        aim(there, state);
        value = crossing(value, near.normal.dot(passing(there, state)) >= -kStill);
      }
      values.push_back(value);
    }
  }
  for (const BodyTouch& at : body_touches_) {
    const double inverse_mass = this->inverse_mass(at), push = inverse_mass * at.touch.push;
    const double spare = kSpare * (stir(at) + std::abs(push));
    values.push_back(push + spare);
    if (is_part(at.body)) {
      part_events(at, state, values);
    } else if (at.spot != Spot::from && at.spot != Spot::to) {
      const BodyMeeting& meeting = meetings_[at.meeting];
      const Pose place = solid(meeting, state);
      const double along = gap_at(meeting.shape, place, capsule(state, at.body), at.spot).along;
      values.push_back(std::min(along, 1 - along) - kAtEnd);
    }
    if (at.touch.stick == 0) continue;
    if (at.touch.state == Touch::State::sticks) {
      values.push_back(at.touch.stick * push - inverse_mass * at.touch.friction.norm() + spare);
    } else {
      values.push_back(passing(at, state).dot(at.touch.sliding) + still(at) / 2);
    }
  }
}

/// 1/kg, of what touches there.
double ContactMotion::inverse_mass(const BodyTouch& at) const {
  if (is_part(at.body)) {
    const Part& own = part(at.body);
    const double left = 1 - at.share;
    return left * left * inverse_mass(std::size_t(own.first)) +
           at.share * at.share * inverse_mass(std::size_t(own.next));
  }
  const double own = mechanism_.bodies()[at.body].inverse_mass;
  return at.other == kNoBody ? own : own + mechanism_.bodies()[at.other].inverse_mass;
}

/// m/s^2: what pulls and weighs there.
double ContactMotion::stir(const BodyTouch& at) const {
  const auto moves = [&](std::uint32_t body) {
    return body_free_[body].head<3>().norm() + body_pulled_[body].head<3>().norm();
  };
  if (!is_part(at.body)) {
    return at.other == kNoBody ? moves(at.body) : moves(at.body) + moves(at.other) + kFly;
  }
  double sum = kFly;
  for (const std::uint32_t p : {part(at.body).first, part(at.body).next}) {
    const std::uint32_t c = carrier(p);
    sum += c == kNoBody ? free_[p].norm() + pulled_[p].norm()
                        : moves(mechanism_.body_points()[c].body);
  }
  return sum;
}

/// Adds their places, and the ways in which they and what they touch go.
void ContactMotion::add_ways_of_bodies(const State& state, std::vector<Vec3>& places,
                                       std::vector<Vec3>& ways) const {
  for (std::size_t b = 0; b < capsules_.size(); ++b) {
    places.push_back(ConstMap(&state[mechanism_.pose(b)]));
    ways.push_back(twist(state, b).head<3>());
    if (!capsules_[b].touches()) continue;
    const Capsule own = capsule(state, b);
    places.push_back(own.from);
    places.push_back(own.to);
  }
  for (const BodyTouch& at : body_touches_) {
    const Vec3 there = where(at, state);
    places.push_back(there);
    ways.push_back(at.touch.normal);
    if (at.other != kNoBody) continue;
    ways.push_back(surface_velocity(frames_[meetings_[at.meeting].obstacle], there));
  }
}

/// Whether bodies turn about a direction alone, and go on to.
bool ContactMotion::turn_within(const State& state, const Vec3& normal) const {
  for (std::size_t b = 0; b < capsules_.size(); ++b) {
    const Vec3 spin = twist(state, b).tail<3>();
    const Vec3 eased = mechanism_.bodies()[b].world_inverse * normal;
    if (normal.cross(spin).norm() > kInPlane) return false;
    if (normal.cross(eased).norm() > kInPlane * eased.norm()) return false;
  }
  return true;
}

/// All that bodies touch and do not leave.
void ContactMotion::find_body_touches(const State& state) {
  body_touches_.clear();
  for (std::uint32_t m = 0; m < meetings_.size(); ++m) {
    const BodyMeeting& meeting = meetings_[m];
    const auto gaps = all_gaps(meeting.shape, solid(meeting, state), capsule(state, meeting.body));
    for (const Spot spot : kSpots) {
      const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
      if (near.distance > touching_ || !is_place(meeting, state, gaps, spot)) continue;
      BodyTouch found = touch_of(meetings_, m, spot);
      aim(found, state);
      const Vec3 slip = passing(found, state);
      const double separating = near.normal.dot(slip);
      // What leaves more slowly than bounces that are followed may be pushed back at once.
      const double leaves = parts_.empty() ? kArrives : slowest_;
      if (separating > leaves) continue;
      found.touch.sliding = slip - separating * near.normal;
      body_touches_.push_back(found);
    }
  }
  if (!parts_.empty()) leave_to_links();
  gather();
}

/// Puts the touches in order of their clusters.
void ContactMotion::gather() {
  if (!parts_.empty()) return;  // all are one
  clusters_.find(capsules_.size(), body_touches_);
  std::ranges::stable_sort(body_touches_, {},
                           [&](const BodyTouch& at) { return clusters_.of(at); });
}

/// Asks for velocities after an impact; whether a body arrives.
bool ContactMotion::bodies_arrive(const State& state) {
  free_bodies(&state);
  const Motion before{free_, body_free_};
  bool any = false;
  for (BodyTouch& at : body_touches_) {
    const BodyMeeting& meeting = meetings_[at.meeting];
    at.ahead.setZero();
    at.given.setZero();
    at.touch.surface.setZero();
    if (at.other == kNoBody) {
      at.touch.surface = surface_velocity(frames_[meeting.obstacle], where(at, state));
    }
    const double carried = at.touch.normal.dot(at.touch.surface);
    const double into = carried - at.touch.normal.dot(passing(before, at));
    any = any || into > kArrives;
    const double bounce = meeting.restitution * into;
    at.touch.least = carried + (bounce > slowest_ ? bounce : 0);
  }
  return any;
}

/// Asks for accelerations, before the active set is chosen.
void ContactMotion::ask_of_bodies(const State& state) {
  free_bodies(nullptr);
  for (BodyTouch& at : body_touches_) {
    aim(at, state);
    ask_accelerations(at, state);
    at.given.setZero();
    at.ahead.setZero();
    if (at.touch.sliding.norm() > still(at)) at.ahead = heading(at.touch.sliding, at.touch.sliding);
    at.touch.sliding.setZero();
  }
}

/// Takes the active set that was chosen.
void ContactMotion::take_touches() {
  std::erase_if(body_touches_,
                [](const BodyTouch& at) { return at.touch.state == Touch::State::open; });
  gather();
  const Motion after = after_impact();  // of accelerations
  for (BodyTouch& at : body_touches_) {
    if (at.touch.stick == 0) at.touch.state = Touch::State::slides;
    if (at.touch.state == Touch::State::sticks) continue;
    if (at.ahead.isZero(0)) {
      const Vec3 slip = passing(after, at) - at.touch.surface;
      const Vec3 across = slip - at.touch.normal.dot(slip) * at.touch.normal;
      if (across.squaredNorm() > 0) at.ahead = heading(across, across);
    }
    at.touch.sliding = at.ahead;
  }
}

// The smooth motion, and the events that end it.

/// Finds all accelerations under the active set.
void ContactMotion::accelerate(double time, const State& state) {
  scratch_ = state;
  mechanism_.update(time, scratch_.data());
  move_obstacles(time);
  const auto& mobile = mechanism_.inverse_mass();
  const auto& rows = mechanism_.rows();
  const std::span<const Vec3> along = pulling();
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    Bead& bead = beads_[p];
    free_[p] = weight(p);
    pulled_[p].setZero();
    if (bead.mode == Mode::open) continue;
    const Vec3 at = place(scratch_, p), moves = velocity(scratch_, p);
    const Obstacle& obstacle = obstacles_[bead.obstacle];
    const Pose pose = frames_[bead.obstacle].pose();
    bead.touch.normal = gap(obstacle, pose, at, radius_[p]).normal;
    if (bead.mode == Mode::sticks) {
      bead.touch.surface = frames_[bead.obstacle].point(bead.anchor).acceleration;
      continue;
    }
    bead.touch.least = least_acceleration(bead, at, moves);
    const Vec3 slip = moves - surface(bead, at).velocity;
    const Vec3 across = slip - bead.touch.normal.dot(slip) * bead.touch.normal;
    const double speed = across.norm();
    bead.touch.sliding = bead.ahead;
    if (speed > kStill) bead.touch.sliding = heading(across, bead.ahead);
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    pulled_[rows[r].a] += mobile[rows[r].a] * tension_[r] * along[r];
    pulled_[rows[r].b] -= mobile[rows[r].b] * tension_[r] * along[r];
  }
  free_bodies(nullptr);
  aim_bodies(scratch_);
  if (!parts_.empty()) {
    for (std::size_t r = 0; r < rows.size(); ++r) start_[r] = mechanism_.free_acceleration(r);
    respond_together(start_, true);
    change_ = tension_;
    return;
  }
  const auto respond_all = [&](std::span<const double> tension) {
    for (std::size_t p = 0; p < beads_.size(); ++p) {
      Bead& bead = beads_[p];
      Touch& touch = bead.touch;
      const Vec3 bare = free_[p] + pulled_[p];
      mobility_[p] = mobile[p] * Mat3::Identity();
      added_[p] = pulled_[p];
      if (bead.mode == Mode::slides) {
        touch.push = touch.least - touch.normal.dot(bare);
        const Vec3 force = touch.normal - touch.slide * touch.sliding;
        touch.friction = -touch.slide * touch.push * touch.sliding;
        added_[p] += touch.push * force;
        mobility_[p] -= mobile[p] * force * touch.normal.transpose();
      } else if (bead.mode == Mode::sticks) {
        const Vec3 given = touch.surface - bare;
        touch.push = touch.normal.dot(given);
        touch.friction = given - touch.push * touch.normal;
        added_[p] += given;
        mobility_[p].setZero();
      }
    }
    couple_bodies(tension, along, true);
  };
  // Where links and what sticks leave a tension open, it is what it was.
  respond_all(tension_);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    change_[r] = pulls_[r] ? mechanism_.free_acceleration(r) +
                                 along[r].dot(added_[rows[r].b] - added_[rows[r].a])
                           : 0;
  }
  system_.assemble(mechanism_, mobility_, along, along, &body_coupled_);
  system_.solve(change_);
  ++solves_;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    pulled_[rows[r].a] += mobile[rows[r].a] * change_[r] * along[r];
    pulled_[rows[r].b] -= mobile[rows[r].b] * change_[r] * along[r];
    change_[r] += tension_[r];
  }
  respond_all(change_);
}

void ContactMotion::differentiate(double time, const State& state, State& derivative) {
  accelerate(time, state);
  mechanism_.differentiate(scratch_.data(), change_.data(), derivative.data());
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    if (beads_[p].mode == Mode::open && parts_.empty()) continue;
    if (mechanism_.inverse_mass()[p] == 0) continue;
    double* rate = &derivative[mechanism_.velocity(p)];
    Map{rate} = free_[p] + added_[p];
  }
  for (std::size_t b = 0; b < body_added_.size(); ++b) {
    Eigen::Map<Vec6>{&derivative[mechanism_.twist(b)]} += body_added_[b] - body_pulled_[b];
  }
}

double ContactMotion::project(double time, State& state) {
  move_obstacles(time);
  if (!parts_.empty()) return project_together(time, state);
  const auto& mobile = mechanism_.inverse_mass();
  const auto& rows = mechanism_.rows();
  std::span<const Vec3> along = mechanism_.direction();
  double worst = 0;
  for (std::size_t b = 0; b < capsules_.size(); ++b) {
    double* q = &state[mechanism_.pose(b) + 3];
    set_quaternion(quaternion(q).normalized(), q);
  }
  const auto shift = [&](std::size_t offset) {  // along the surfaces
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const Vec3 pull = change_[r] * along[r];
      Map(&state[offset + 3 * rows[r].a]) += mobility_[rows[r].a] * pull;
      Map(&state[offset + 3 * rows[r].b]) -= mobility_[rows[r].b] * pull;
    }
    shift_bodies(along, offset == mechanism_.position(0), state);
  };
  for (int i = 0; i < kProjections; ++i) {
    check_stop();
    worst = 0;
    for (std::size_t p = 0; p < beads_.size(); ++p) {
      const Bead& bead = beads_[p];
      mobility_[p] = mobile[p] * Mat3::Identity();
      if (bead.mode == Mode::open) continue;
      Map at(&state[mechanism_.position(p)]);
      Map moves(&state[mechanism_.velocity(p)]);
      const FrameMotion& frame = frames_[bead.obstacle];
      if (bead.mode == Mode::sticks) {
        const PointMotion anchor = frame.point(bead.anchor);
        at = anchor.position;
        moves = anchor.velocity;
        mobility_[p].setZero();
        continue;
      }
      const SurfaceDistance near = gap(obstacles_[bead.obstacle], frame.pose(), at, radius_[p]);
      worst = std::max(worst, std::abs(near.distance));
      at -= near.distance * near.normal;
      moves += near.normal.dot(surface(bead, at).velocity - moves) * near.normal;
      mobility_[p] -= mobile[p] * near.normal * near.normal.transpose();
    }
    mechanism_.place(time, state.data());
    if (!capsules_.empty()) worst = std::max(worst, project_bodies(state));
    mechanism_.update(time, state.data());
    along = pulling();
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (pulls_[r]) worst = std::max(worst, std::abs(mechanism_.violation()[r]));
    }
    system_.assemble(mechanism_, mobility_, along, along, &body_coupled_);
    ++solves_;
    std::ranges::copy(mechanism_.rate(), change_.begin());
    system_.solve(change_);
    shift(mechanism_.velocity(0));
    if (worst < 1e-3 * touching_) break;
    std::ranges::copy(mechanism_.violation(), change_.begin());
    system_.solve(change_);
    shift(mechanism_.position(0));
  }
  return worst;
}

void ContactMotion::events(double time, const State& state, std::vector<double>& values) {
  values.clear();
  accelerate(time, state);
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    if (radius_[p] < 0) continue;
    const Bead& bead = beads_[p];
    const Vec3 at = place(scratch_, p);
    for (std::size_t o = 0; o < obstacles_.size(); ++o) {
      if (bead.mode != Mode::open && bead.obstacle == o) continue;
      if (!obstacles_[o].touches(category_[p])) continue;
      const SurfaceDistance near = gap(obstacles_[o], frames_[o].pose(), at, radius_[p]);
      const Bead there{.obstacle = static_cast<std::uint32_t>(o), .touch = {}};
      const double separating =
          near.normal.dot(velocity(scratch_, p) - surface(there, at).velocity);  // m/s
      values.push_back(crossing(near.distance + touching_ / 2, separating >= -kStill));
    }
    if (bead.mode == Mode::open) continue;
    const Touch& touch = bead.touch;
    const double spare = kSpare * (free_[p].norm() + pulled_[p].norm() + touch.push);
    values.push_back(touch.push + spare);
    if (touch.stick == 0) continue;
    if (bead.mode == Mode::sticks) {
      values.push_back(touch.stick * touch.push - touch.friction.norm() + spare);
    } else {
      const Vec3 slip = velocity(scratch_, p) - surface(bead, at).velocity;
      values.push_back(slip.dot(bead.ahead) + kStill / 2);
    }
  }
  body_events(scratch_, values);
  // A link whose ends are led apart while what it joins sticks: that has to slide.
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    const Row& row = mechanism_.rows()[r];
    double size = mechanism_.gravity().norm();
    for (const std::uint32_t p : {row.a, row.b}) size += free_[p].norm() + pulled_[p].norm();
    double off = 0;
    if (pulls_[r] && system_.left_out(r)) {
      off = mechanism_.free_acceleration(r) +
            mechanism_.direction()[r].dot(added_[row.b] - added_[row.a]);
    }
    values.push_back(kLedApart * size - std::abs(off));
  }
  if (!mechanism_.has_strings()) return;
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    if (!mechanism_.rows()[r].pulls) continue;
    if (pulls_[r]) {
      values.push_back(change_[r] + spare(r));
      continue;
    }
    values.push_back(
        crossing(kLonger * touching_ - mechanism_.violation()[r], mechanism_.rate()[r] <= kStill));
  }
}

// The consequences of an event: impacts and new active sets, as nonsmooth systems of all rows.

namespace {

constexpr double kSolved = 1e-12;  // of the velocities or accelerations
constexpr double kImmobileRow = 1e-12;
constexpr int kStepTrials = 8;
constexpr int kRelaxations = 8;  // along the rows and back, of a relaxation
constexpr int kShrinkings = 30;  // of the interval of a tension

}  // namespace

/// Marks all beads at surfaces as open or sliding, where they do not stick already.
void ContactMotion::find_touches(const State& state) {
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    if (radius_[p] < 0) continue;
    Bead& bead = beads_[p];
    int count = 0;
    const Bead was = bead;
    for (std::uint32_t o = 0; o < obstacles_.size(); ++o) {
      if (!obstacles_[o].touches(category_[p])) continue;
      const SurfaceDistance near =
          gap(obstacles_[o], frames_[o].pose(), place(state, p), radius_[p]);
      if (near.distance > touching_) continue;
      Bead found{.mode = Mode::slides, .obstacle = o, .touch = {}};
      if (was.mode == Mode::sticks && was.obstacle == o) found = was;
      found.touch.normal = near.normal;
      found.touch.stick = obstacles_[o].static_friction;
      found.touch.slide = obstacles_[o].kinetic_friction;
      const Vec3 passing = velocity(state, p) - surface(found, place(state, p)).velocity;
      if (near.normal.dot(passing) > kArrives) continue;  // it leaves
      found.touch.sliding = passing - near.normal.dot(passing) * near.normal;
      bead = found;
      ++count;
    }
    if (count == 0) bead = {};
    if (count > 1) throw Unresolved{0, "a bead touches two obstacles at once"};
  }
  find_body_touches(state);
}

/// The direction of sliding. In motions in a plane exactly along it: sliding out of it by rounding
/// is a stiff equation, for friction turns slow sliding at once.
Vec3 ContactMotion::heading(const Vec3& across, const Vec3& ahead) const {
  const Vec3 within = across - aside_.dot(across) * aside_;
  return (within.dot(ahead) < 0 ? -1 : 1) * within.normalized();
}

/// How a bead goes on without what it touches, and with it.
Response ContactMotion::response(Bead& bead, const Vec3& bare) const {
  Touch& touch = bead.touch;
  if (bead.mode == Mode::open) return {bare, Mat3::Identity()};
  if (bead.ahead.isZero(0)) return respond(bare, {&touch, 1});
  // Already sliding: friction is against that, whatever accelerates it.
  touch.push = touch.least - touch.normal.dot(bare);
  if (!(touch.push > 0)) {
    touch.state = Touch::State::open;
    return {bare, Mat3::Identity()};
  }
  touch.state = Touch::State::slides;
  const Vec3 force = touch.normal - touch.slide * bead.ahead;
  return {bare + touch.push * force, Mat3::Identity() - force * touch.normal.transpose()};
}

/// The response of all beads to tension_; returns the largest error of a row.
double ContactMotion::measure(std::span<const double> start) {
  const auto& mobile = mechanism_.inverse_mass();
  const auto& rows = mechanism_.rows();
  const auto& along = mechanism_.direction();
  std::ranges::fill(pulled_, Vec3::Zero());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    pulled_[rows[r].a] += mobile[rows[r].a] * tension_[r] * along[r];
    pulled_[rows[r].b] -= mobile[rows[r].b] * tension_[r] * along[r];
  }
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    const Response found = response(beads_[p], free_[p] + pulled_[p]);
    mobility_[p] = mobile[p] * found.derivative;
    added_[p] = mobile[p] > 0 ? Vec3(found.velocity - free_[p]) : Vec3(Vec3::Zero());
  }
  couple_bodies(tension_, along, false);
  double worst = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    change_[r] = start[r] + along[r].dot(added_[rows[r].b] - added_[rows[r].a]);
    if (taut_[r]) worst = std::max(worst, pulls_[r] ? std::abs(change_[r]) : change_[r]);
  }
  return worst;
}

/// Tensions (or impulses) under which no row's error, `start` without them, is left.
void ContactMotion::balance(std::span<const double> start) {
  if (!parts_.empty()) return balance_together(start);
  Damping damping;
  for (int i = 0; i < kIterations; ++i) {
    double worst = measure(start);
    if (mechanism_.has_strings()) {
      sort_strings();
      worst = measure(start);
    }
    double scale = 1;
    for (std::size_t p = 0; p < beads_.size(); ++p) {
      scale = std::max({scale, free_[p].squaredNorm(), pulled_[p].squaredNorm()});
    }
    if (worst <= kSolved * std::sqrt(scale)) return;
    if (!std::isfinite(worst)) break;
    Hash pattern;
    for (const Bead& bead : beads_) pattern.word(static_cast<std::uint64_t>(bead.touch.state));
    for (const BodyTouch& at : body_touches_) {
      pattern.word(static_cast<std::uint64_t>(at.touch.state));
    }
    if (mechanism_.has_strings()) {
      for (const char pulls : pulls_) pattern.word(std::uint64_t(pulls != 0));
    }
    if (damping.relaxes(pattern.value())) {
      relax(start);
      continue;
    }
    const std::span<const Vec3> along = pulling();
    system_.assemble(mechanism_, mobility_, along, along, &body_coupled_);
    for (std::size_t r = 0; r < change_.size(); ++r) change_[r] *= pulls_[r];
    const std::vector<double> error = change_;
    system_.solve(change_);
    ++solves_;
    for (std::size_t r = 0; r < change_.size(); ++r) {
      const bool sticks = system_.left_out(r) && std::abs(error[r]) > kSolved * std::sqrt(scale);
      tension_[r] += damping.share() * (sticks ? until_it_slides(r, error[r]) : change_[r]);
    }
  }
  throw Unresolved{0, "contact and friction have no solution"};
}

/// By how much more a row pulls that leads apart what sticks, until some of it slides.
double ContactMotion::until_it_slides(std::size_t row, double error) const {
  double mobile = 0, size = 0;
  for (const std::size_t p : {mechanism_.rows()[row].a, mechanism_.rows()[row].b}) {
    mobile += mechanism_.inverse_mass()[p];
    size += free_[p].norm() + pulled_[p].norm();
  }
  return mobile > 0 ? std::copysign(size / mobile, error) : 0;
}

/// Nonlinear Gauss-Seidel along the rows and back (Jean 1999, section 5).
void ContactMotion::relax(std::span<const double> start) {
  for (int sweep = 0; sweep < kRelaxations; ++sweep) {
    check_stop();
    for (std::size_t r = 0; r < start.size(); ++r) relax_row(r, start[r]);
    for (std::size_t r = start.size(); r-- > 0;) relax_row(r, start[r]);
  }
}

void ContactMotion::relax_row(std::size_t row, double start) {
  const std::size_t a = mechanism_.rows()[row].a, b = mechanism_.rows()[row].b;
  const double mobile_a = mechanism_.inverse_mass()[a], mobile_b = mechanism_.inverse_mass()[b];
  const Vec3& along = mechanism_.direction()[row];
  const bool string = mechanism_.rows()[row].pulls;
  if (!taut_[row] || is_carried_[a] || is_carried_[b]) return;
  for (int i = 0; i < kStepTrials && mobile_a + mobile_b > 0; ++i) {
    Bead bead_a = beads_[a], bead_b = beads_[b];
    const Response at_a = response(bead_a, free_[a] + pulled_[a]);
    const Response at_b = response(bead_b, free_[b] + pulled_[b]);
    double error = start, slope = 0;
    for (const auto& [mobile, found, free, sign] :
         {std::tuple(mobile_a, at_a, free_[a], -1.0), std::tuple(mobile_b, at_b, free_[b], 1.0)}) {
      if (mobile == 0) continue;
      error += sign * along.dot(found.velocity - free);
      const double gives = along.dot(found.derivative * along);
      if (std::abs(gives) > kImmobileRow) slope += mobile * gives;
    }
    if (std::abs(error) <= 1e-2 * kSolved || !(slope > 0)) return;
    double more = error / slope;
    if (string) more = std::max(more, -tension_[row]);
    if (more == 0) return;
    tension_[row] += more;
    pulled_[a] += mobile_a * more * along;
    pulled_[b] -= mobile_b * more * along;
  }
}

/// Stops what arrives; whether anything did.
bool ContactMotion::arrive(double time, State& state) {
  bool any = find_taut(time, state);
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    Bead& bead = beads_[p];
    free_[p] = velocity(state, p);
    bead.ahead.setZero();
    if (bead.mode == Mode::open) continue;
    Touch& touch = bead.touch;
    touch.surface = surface(bead, place(state, p)).velocity;
    const double carried = touch.normal.dot(touch.surface);
    const double into = carried - touch.normal.dot(free_[p]);
    any = any || into > kArrives;
    const double bounce = obstacles_[bead.obstacle].restitution * into;
    touch.least = carried + (bounce > slowest_ ? bounce : 0);
  }
  any = bodies_arrive(state) || any;
  if (!any) return false;
  mechanism_.update(time, state.data());
  std::ranges::copy(mechanism_.rate(), start_.begin());
  const std::vector<double> tension = tension_;
  std::ranges::fill(tension_, 0.0);
  balance(start_);
  if (!is_driven()) lower_bounces(state);
  tension_ = tension;
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] > 0) Map(&state[mechanism_.velocity(p)]) += added_[p];
  }
  for (std::size_t b = 0; b < body_added_.size(); ++b) {
    Eigen::Map<Vec6>{&state[mechanism_.twist(b)]} += body_added_[b];
  }
  mechanism_.place(time, state.data());  // what bodies carry
  return true;
}

/// The active set: which touches close, and which of them stick, so that accelerations agree with
/// the laws.
void ContactMotion::choose(double time, const State& state) {
  scratch_ = state;
  find_taut(time, scratch_);
  mechanism_.update(time, scratch_.data());
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    Bead& bead = beads_[p];
    free_[p] = weight(p);
    bead.ahead.setZero();
    if (bead.mode == Mode::open) continue;
    const Vec3 at = place(state, p);
    Touch& touch = bead.touch;
    const double speed = touch.sliding.norm();
    touch.least = least_acceleration(bead, at, velocity(state, p));
    touch.surface = surface(bead, at).acceleration;
    if (speed > kStill) bead.ahead = heading(touch.sliding, touch.sliding);
    touch.sliding.setZero();
  }
  ask_of_bodies(scratch_);
  for (std::size_t r = 0; r < start_.size(); ++r) start_[r] = mechanism_.free_acceleration(r);
  balance(start_);
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    Bead& bead = beads_[p];
    Touch& touch = bead.touch;
    if (bead.mode == Mode::open) continue;
    if (touch.state == Touch::State::open) {
      bead = {};
      continue;
    }
    const bool stuck = bead.mode == Mode::sticks;
    const bool sticks = touch.state == Touch::State::sticks && touch.stick > 0;
    bead.mode = sticks ? Mode::sticks : Mode::slides;
    const FrameMotion& frame = frames_[bead.obstacle];
    if (sticks && !stuck) {
      bead.anchor = frame.rotation.conjugate() * (place(state, p) - frame.position);
    }
    if (sticks || !bead.ahead.isZero(0)) continue;
    const Vec3 slip = free_[p] + added_[p] - touch.surface;
    const Vec3 across = slip - touch.normal.dot(slip) * touch.normal;
    if (across.squaredNorm() > 0) bead.ahead = heading(across, across);
  }
  take_touches();
}

/// The normal of the plane in which all places, velocities and gravity lie; zero: there is none.
Vec3 ContactMotion::plane_of(const State& state) const {
  std::vector<Vec3> places, ways{mechanism_.gravity()};
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    places.push_back(place(state, p));
    ways.push_back(velocity(state, p));
    if (beads_[p].mode == Mode::open) continue;
    ways.push_back(beads_[p].touch.normal);
    ways.push_back(surface(beads_[p], places.back()).velocity);
  }
  add_ways_of_bodies(state, places, ways);
  Vec3 normal = Vec3::Zero(), first = mechanism_.gravity();
  for (const Vec3& at : places) {
    const Vec3 from = at - places[0];
    if (first.squaredNorm() == 0) first = from;
    const Vec3 across = first.cross(from);
    if (across.squaredNorm() > normal.squaredNorm()) normal = across;
  }
  if (!(normal.squaredNorm() > 0)) return Vec3::Zero();
  normal.normalize();
  double out = 0;
  for (const Vec3& at : places) out = std::max(out, std::abs(normal.dot(at - places[0])));
  for (const Vec3& way : ways) out = std::max(out, std::abs(normal.dot(way)));
  if (!turn_within(state, normal)) return Vec3::Zero();
  return out <= kInPlane ? normal : Vec3(Vec3::Zero());
}

/// How far (m/s^2) a bead that sticks, and is pulled by so much more, is from sliding.
double ContactMotion::margin(std::size_t point, const Vec3& more) const {
  const Bead& bead = beads_[point];
  if (bead.mode != Mode::sticks) return std::numeric_limits<double>::infinity();
  const Vec3 given = added_[point] - pulled_[point] - more;
  const double push = bead.touch.normal.dot(given);
  return bead.touch.stick * push - (given - push * bead.touch.normal).norm();
}

/// Where tensions are left open, between beads that stick, each gets the value that keeps both
/// beads farthest from sliding: margins are concave, a golden section finds their highest point.
void ContactMotion::centre() {
  const double ratio = (std::sqrt(5.0) - 1) / 2;
  double most = 0;
  for (const double tension : tension_) most = std::max(most, std::abs(tension));
  const auto& rows = mechanism_.rows();
  for (std::size_t i = 0; i < 2 * kRelaxations * rows.size(); ++i) {
    const std::size_t k = i % (2 * rows.size());
    const std::size_t r = k < rows.size() ? k : 2 * rows.size() - 1 - k;
    const std::size_t a = rows[r].a, b = rows[r].b;
    const double mobile_a = mechanism_.inverse_mass()[a], mobile_b = mechanism_.inverse_mass()[b];
    const auto is_open = [&](std::size_t point, double mobile) {
      return is_carried_[point] || (mobile > 0 && beads_[point].mode != Mode::sticks);
    };
    if (is_open(a, mobile_a) || is_open(b, mobile_b) || mobile_a + mobile_b == 0) continue;
    if (!pulls_[r]) continue;
    const Vec3& along = mechanism_.direction()[r];
    const auto least = [&](double more) {
      return std::min(margin(a, mobile_a * more * along), margin(b, -mobile_b * more * along));
    };
    double low = rows[r].pulls ? -tension_[r] : -2 * most, high = 2 * most;
    double left = high - ratio * (high - low), right = low + ratio * (high - low);
    double at_left = least(left), at_right = least(right);
    for (int s = 0; s < kShrinkings; ++s) {
      if (at_left > at_right) {
        high = right, right = left, at_right = at_left;
        left = high - ratio * (high - low), at_left = least(left);
      } else {
        low = left, left = right, at_left = at_right;
        right = low + ratio * (high - low), at_right = least(right);
      }
    }
    const double more = (low + high) / 2;
    if (!(least(more) > least(0))) continue;
    tension_[r] += more;
    pulled_[a] += mobile_a * more * along;
    pulled_[b] -= mobile_b * more * along;
  }
}

void ContactMotion::resolve(double time, State& state) {
  mechanism_.place(time, state.data());
  move_obstacles(time);
  find_touches(state);
  if (arrive(time, state)) find_touches(state);
  aside_ = plane_of(state);
  choose(time, state);
  centre();
}

// Impacts that would make energy.

/// Whether obstacles or what holds points move, and may give energy.
bool ContactMotion::is_driven() const {
  const auto moves = [](const Obstacle& obstacle) { return obstacle.path != nullptr; };
  if (std::ranges::any_of(obstacles_, moves)) return true;
  for (std::size_t p = 0; p < free_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0 && !is_carried_[p] && !free_[p].isZero(0)) return true;
  }
  return false;
}

/// J, half of the product of two motions with all masses: for one alone its kinetic energy.
double ContactMotion::energy_of(const State& state, const Motion& one, const Motion& other) const {
  double sum = 0;
  for (std::size_t p = 0; p < one.points.size(); ++p) {
    const double inverse_mass = mechanism_.inverse_mass()[p];
    if (inverse_mass > 0) sum += one.points[p].dot(other.points[p]) / inverse_mass / 2;
  }
  for (std::size_t b = 0; b < one.bodies.size(); ++b) {
    const Mechanism::FreeBody& body = mechanism_.bodies()[b];
    const Quat back = quaternion(&state[mechanism_.pose(b) + 3]).normalized().conjugate();
    const Vec3 spin = back * one.bodies[b].tail<3>();
    const Vec3 others_spin = back * other.bodies[b].tail<3>();
    sum += one.bodies[b].head<3>().dot(other.bodies[b].head<3>()) / body.inverse_mass / 2;
    sum += spin.dot(body.inertia * others_spin) / 2;
  }
  return sum;
}

/// The motion after the impact that balance() has found.
ContactMotion::Motion ContactMotion::after_impact() const {
  Motion after{free_, body_free_};
  for (std::size_t p = 0; p < free_.size(); ++p) after.points[p] += added_[p];
  for (std::size_t b = 0; b < body_free_.size(); ++b) after.bodies[b] += body_added_[b];
  return after;
}

/// Where the impact that balance() has found would make energy, it goes with the share of what is
/// thrown back that makes none, see share_thrown_back().
void ContactMotion::lower_bounces(const State& state) {
  const Motion before{free_, body_free_}, thrown = after_impact();
  ImpactEnergies energy{.before = energy_of(state, before, before),
                        .thrown = energy_of(state, thrown, thrown)};
  if (!gains_energy(energy.before, energy.thrown)) return;
  for (Bead& bead : beads_) bead.touch.least = bead.touch.normal.dot(bead.touch.surface);
  for (BodyTouch& at : body_touches_) {
    at.touch.least = at.touch.normal.dot(at.touch.surface);
    at.given.setZero();
  }
  std::ranges::fill(tension_, 0.0);
  balance(start_);
  const Motion stopped = after_impact();
  energy.stopped = energy_of(state, stopped, stopped);
  energy.mixed = energy_of(state, stopped, thrown);
  const double share = share_thrown_back(energy);
  for (std::size_t p = 0; p < added_.size(); ++p) {
    added_[p] += share * (thrown.points[p] - stopped.points[p]);
  }
  for (std::size_t b = 0; b < body_added_.size(); ++b) {
    body_added_[b] += share * (thrown.bodies[b] - stopped.bodies[b]);
  }
}

}  // namespace taut::contact
