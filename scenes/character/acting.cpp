#include "scenes/character/acting.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/character/track.h"
#include "sim/run/simulation.h"

namespace taut::scenes {
namespace {

constexpr double moves = 0.02;                    // m/s: a hand that is slower rests
constexpr double stance = 0.9, stance_by = 0.25;  // s, that it takes, and before the hand moves
constexpr double comes_to_rest = 0.35;            // s
constexpr double long_rest = 1.9;                 // s
constexpr double bow_after = 0.75, bow_takes = 0.32, bow_stays = 0.08, rise_takes = 0.38;  // s
constexpr double rises_after = 0.30, stands_in = 0.45;                                     // s
constexpr double past_by = 0.42, past_until = 0.15, ducks = 0.28;  // s, before and after all rests
constexpr double last_stroke = 0.62, stroke_takes = 0.48;          // s, before all rests
// Speeds of the stick (m/s) from which he braces himself, and at which he does entirely.
constexpr double brisk = 1.9, fast = 3.0;
constexpr double braced_by = 0.25, bracing = 0.22;  // s, before it is fast; and how smoothly
constexpr double windup = 0.26;                     // s, before the hand is fast
constexpr double stroke = 0.35, strong = 0.8;  // m/s, by which it then is faster, and much faster
constexpr double foreseen_within = 0.01;       // m, the method's tolerance

/// The stick's centre over the duration: the chain is one link, which nothing but its ends holds.
Track swing(const Path& hand, const FreeStick& stick, double duration) {
  const auto path = std::make_shared<const Path>(hand);
  World world;
  Body body;
  body.mass_properties = solid_cylinder(stick.mass, stick.length, stick.diameter);
  const Vec3 from = path->at(0).pose().to_world(stick.from);
  body.position = from - (stick.chain + stick.length / 2) * Vec3::UnitY();
  world.bodies.push_back(body);
  Connector chain =
      straight_connector("chain", stick.chain, stick.chain_mass, 2, from, -Vec3::UnitY());
  Hold first, last;
  first.to.kind = Attachment::Kind::path;
  first.to.path = path;
  first.to.point = stick.from;
  last.particle = 1;
  last.to.kind = Attachment::Kind::body;
  last.to.point = Vec3(0, stick.length / 2, 0);
  chain.holds = {first, last};
  world.connectors.push_back(std::move(chain));
  finish(world);
  Simulation simulation(world, make_method("direct", {{"tolerance", foreseen_within}}));
  return Track::sample(duration, acting_rate, [&](double time) {
    simulation.advance_to(time);
    return Eigen::VectorXd(std::as_const(simulation).world().bodies[0].frame().position);
  });
}

Track norms(Track rates) {
  rates.samples() = rates.samples().colwise().norm().eval();
  return rates;
}

}  // namespace

double Cues::ready(double time) const {
  return smoothstep((time - (begins - stance_by - stance)) / stance);
}

double Cues::plays(double time) const {
  if (!(rests > begins)) return 0;
  return smoothstep((time - begins + stance_by) / stance_by) *
         smoothstep((rests + comes_to_rest - time) / comes_to_rest);
}

double Cues::struck(double time) const {
  return rests > begins ? smoothstep((time - rests + last_stroke) / stroke_takes) : 0;
}

double Cues::passes(double time) const {
  if (!swings || !(rests > begins)) return 0;
  return smoothstep((time - rests + past_by) / ducks) -
         smoothstep((time - rests - past_until) / ducks);
}

double Cues::rises(double time) const {
  return greets() ? smoothstep((time - rests - rises_after) / stands_in) : 0;
}

bool Cues::greets() const {
  return rests > begins && ends - rests > long_rest;
}

double Cues::nod(double time) const {
  const double since = time - rests - bow_after;
  return greets() ? smoothstep(since / bow_takes) -
                        smoothstep((since - bow_takes - bow_stays) / rise_takes)
                  : 0;
}

Cues foresee(const Path& hand, const std::optional<FreeStick>& stick, double duration) {
  Cues cues;
  cues.begins = cues.rests = cues.ends = duration;
  if (stick) {
    cues.swings = true;
    cues.stick = swing(hand, *stick, duration);
  }
  bool moved = false;
  for (double time = 0; time <= duration; time += 1 / acting_rate) {
    if (!(hand.at(time).velocity.norm() > moves)) continue;
    if (!moved) cues.begins = time;
    moved = true;
    cues.rests = time;
  }
  if (!stick) return cues;

  cues.off = cues.stick;
  for (Eigen::Index i = 0; i < cues.off.count(); ++i)
    cues.off.samples().col(i) = cues.plays(cues.off.time(i)) * (cues.stick[i] - cues.stick[0]);
  Track speed = norms(cues.stick.rates()).smoothed(0.25);
  for (double& v : speed.samples().reshaped()) v = smoothstep((v - brisk) / (fast - brisk));
  cues.braced = speed.smoothed(bracing).ahead(braced_by);
  const Track haste =
      norms(Track::sample(duration, acting_rate,
                          [&](double time) { return Eigen::VectorXd(hand.at(time).position); })
                .rates())
          .smoothed(0.10);
  cues.winds_up = haste.ahead(windup);
  // A stroke that comes, but not what goes on at one speed.
  for (Eigen::Index i = 0; i < haste.count(); ++i) {
    const double faster = cues.winds_up[i][0] - haste[i][0] - stroke;
    cues.winds_up.samples()(0, i) = soft(std::max(0.0, faster) / strong, 1.0);
  }
  return cues;
}

namespace {

// The stance at rest, and where the right hand is at ease; m and rad, for a figure of 1.78 m.
const Vec3 pelvis_at_ease(0.01, -0.080, 0.01);
const Vec3 hand_at_ease(-0.26, 1.06, 0.46);
constexpr double pelvis_turned = 0.55, spine_turned = -0.08;

constexpr double body_lag = 0.110, shoulder_lag = 0.120;  // s, mean delays
constexpr double foresight = 0.22;                        // s, of anticipation
constexpr double breath = 0.27;                           // Hz

}  // namespace

Track act(const Figure& figure, const Path& path, double duration, const Cues& cues) {
  const double scale = figure.scale();
  const Track hand = Track::sample(duration, acting_rate, [&](double time) {
    return Eigen::VectorXd((path.at(time).position - scale * hand_at_ease) / scale);
  });
  const Track velocity = hand.rates();
  const Track body = hand.lagged(body_lag);
  const Track late = hand.lagged(shoulder_lag);
  const Track coming = velocity.smoothed(0.09).ahead(foresight);
  Track speed = velocity;
  speed.samples() = velocity.samples().colwise().norm();
  const Track haste = speed.smoothed(0.3);
  const Track steps = take_steps(hand);

  Eigen::MatrixXd rows(Eigen::Index{control_count}, hand.count());
  for (Eigen::Index i = 0; i < hand.count(); ++i) {
    const Vec3 h = body[i], s = late[i], next = coming[i];
    const Vec3 right = steps[i].head<3>(), left = steps[i].tail<3>();
    const double still = std::exp(-std::pow(haste[i][0] / 0.5, 2));
    const double chest_rise = std::sin(2 * M_PI * breath * hand.time(i)) * (0.35 + 0.65 * still);

    Controls c = Controls::Zero();
    // The weight follows the hand, and sinks before the hand rises; it is between the feet, and
    // while one is up, on the other.
    const Vec3 between = (right + left) / 2;
    Vec3 pelvis = pelvis_at_ease;
    pelvis.x() += soft(0.16 * h.x() - 0.020 * next.x(), 0.07);
    pelvis.x() += 0.6 * between.x() + 0.6 * (right.y() - left.y());
    pelvis.y() += soft(0.10 * h.y() - 0.022 * std::abs(next.y()), 0.06) + 0.003 * chest_rise;
    pelvis.z() += soft(0.20 * h.z() - 0.014 * next.z(), 0.07) + 0.6 * between.z();
    c.segment<3>(root_x) = scale * pelvis;

    // A hand that reaches to the left or forward draws its shoulder along; before it goes there,
    // the torso winds up the other way.
    const double twist =
        soft(0.90 * h.x() + 0.55 * h.z(), 0.45) - soft(0.08 * next.x() + 0.05 * next.z(), 0.14);
    c[pelvis_yaw] = pelvis_turned + 0.35 * twist;
    c[pelvis_lean] = 0.03 + soft(0.06 * h.z(), 0.04);
    c[spine_yaw] = spine_turned + 0.65 * twist;
    c[spine_lean] =
        0.06 + soft(0.30 * h.z() - 0.22 * h.y() + 0.03 * next.y(), 0.18) - 0.018 * chest_rise;
    c[spine_tilt] = soft(-0.30 * h.x() - 0.22 * h.y(), 0.14);

    c[right_shoulder_forward] = soft(0.45 * s.z() + 0.35 * s.x(), 0.25);
    c[right_shoulder_up] = soft(0.55 * s.y(), 0.28) + 0.022 * chest_rise;
    c[left_shoulder_forward] = -0.04 - soft(0.25 * twist, 0.12);
    c[left_shoulder_up] = 0.020 * chest_rise;

    c.segment<3>(right_step_x) = scale * right;
    c.segment<3>(left_step_x) = scale * left;
    rows.col(i) = c;
  }
  Track controls(std::move(rows), acting_rate);
  answer_stick(figure, cues, controls);
  keep_guard(figure, path, cues, controls);
  begin_and_end(figure, cues, controls);
  return controls;
}

// How the trunk and the legs answer the free stick and the strokes of the hand.

namespace {

constexpr double inertia = 0.11;  // s: what is faster the trunk does not follow
constexpr double weight_ahead = 0.12, hips_ahead = 0.05;  // s, of the stick
constexpr double chest_behind = 0.10;                     // s, mean delay
/// Before the hand comes to rest for good the body is again where the path alone has it: what a
/// stick is thrown at must be there.
constexpr double done = 0.45, calms_down = 0.35;  // s

}  // namespace

void answer_stick(const Figure& figure, const Cues& cues, Track& controls) {
  if (!cues.swings) return;
  const double scale = figure.scale();
  const Track slow = cues.off.smoothed(inertia);
  const Track weight = slow.ahead(weight_ahead), hips = slow.ahead(hips_ahead);
  const Track chest = slow.lagged(chest_behind);

  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const double time = controls.time(i);
    const double share = smoothstep((cues.rests - done - time) / calms_down);
    const double plays = share * cues.plays(time), brace = share * cues.braced.at(time)[0];
    const double follows = share * (1 - 0.3 * brace) / scale;
    const Vec3 w = follows * weight.at(time), h = follows * hips.at(time);
    const Vec3 c = follows * chest.at(time);
    const double before = share * cues.winds_up.at(time)[0];
    auto u = controls.samples().col(i);
    // The feet stand one before the other: the weight goes aside and forward to the right one,
    // whose hip rises; the knees give on the way.
    const double right = soft(-0.50 * w.x(), 0.10) - 0.040 * brace - 0.08 * before;  // m
    u[root_x] += scale * -0.60 * right;
    u[root_z] += scale * 0.80 * right;
    u[root_y] += scale * (soft(0.13 * h.y(), 0.035) - 0.030 * plays - 0.02 * brace - 0.03 * before);
    u[pelvis_tilt] += -1.2 * right;
    u[pelvis_lean] += 0.5 * right;
    u[right_shoulder_forward] += 0.10 * brace;
    // Hips turn against the rib cage, which comes later and leans to the stick's side; from a fast
    // stick he leans away.
    u[pelvis_yaw] += soft(-0.85 * h.x(), 0.28) - 0.28 * before + 0.05 * brace;
    u[spine_yaw] += soft(0.85 * h.x(), 0.28) + soft(0.60 * c.x(), 0.24) + 0.08 * before;
    u[spine_tilt] += soft(-0.80 * c.x(), 0.22) - 0.16 * brace + 0.06 * before;
    u[spine_lean] += soft(-0.12 * h.y(), 0.05) - 0.6 * right + 0.10 * (plays - brace);
  }
}

// How he waits before he plays, and how he greets when he has.

namespace {

// While he waits he stands higher, on the foot behind; m and rad, as differences from his stance,
// for a figure of 1.78 m.
const Vec3 pelvis_waits(0.030, 0.030, -0.045);
constexpr double bows = 0.15, nods = 0.32;  // rad, of the back, and of the head beyond that

}  // namespace

void begin_and_end(const Figure& figure, const Cues& cues, Track& controls) {
  const double scale = figure.scale();
  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const double time = controls.time(i), waits = 1 - cues.ready(time);
    auto u = controls.samples().col(i);
    u.segment<3>(root_x) += scale * waits * pelvis_waits;
    u[pelvis_yaw] -= 0.10 * waits;
    u[spine_lean] += 0.03 * waits;
    const double rises = cues.rises(time), nod = cues.nod(time);
    u[spine_yaw] += 0.055 * rises;
    u[spine_lean] += bows * nod;
    u[head_lean] += nods * nod;
  }
}

// What the face shows.

namespace {

// The hand's speed (m/s) and acceleration (m/s^2) that make half of an expression.
constexpr double half_speed = 0.2, half_acceleration = 8;
constexpr double attack = 0.10, release = 0.3;  // s, mean delays of a face that tightens, and eases
constexpr double anticipation = 0.08;           // s, by which the face is ahead of the hand
constexpr double calm_lids = 0.12;              // how far down they are without any effort
constexpr double lids_rise = 0.85;              // by this much per rad that the eyes look up
constexpr double least_rest = 0.2;              // s, after which the hand has come to rest

/// From 0 to 1, a half at `half`.
double share(double x, double half) {
  return x * x / (x * x + half * half);
}

}  // namespace

void play_face(const Figure& figure, const Path& path, Track& controls, const Cues& cues) {
  const Track hand = Track::sample(
      controls.time(controls.count() - 1), acting_rate,
      [&](double time) { return Eigen::VectorXd(path.at(time).position / figure.scale()); });
  Track speed = hand.rates(), acceleration = speed.smoothed(0.02).rates();
  speed.samples() = speed.samples().colwise().norm().eval();
  acceleration.samples() = acceleration.samples().colwise().norm().eval();
  const auto each = [](const Track& track, double half) {
    Track out = track;
    out.samples() = track.samples().unaryExpr([half](double x) { return share(x, half); });
    return out;
  };
  const Track moving = each(speed.smoothed(0.15), half_speed);
  const Track effort =
      each(acceleration.smoothed(0.04), half_acceleration).ahead(anticipation).lagged(attack / 2);
  const Track concentration = moving.smoothed(release).ahead(anticipation).lagged(attack);

  // Rest counts once the hand has moved, and only where it lasts.
  Track ease = moving;
  const auto lasts = static_cast<Eigen::Index>(least_rest * moving.rate());
  bool moved = false;
  Eigen::Index since = 0;  // the last sample at which the hand moved
  for (Eigen::Index i = 0; i < moving.count(); ++i) {
    const double now = moving[i][0];
    moved = moved || now > 0.5;
    if (now > 0.3) since = i;
    ease.samples()(0, i) = moved && i - since > lasts ? 1 : 0;
  }
  const Track calmed = ease.lagged(release);

  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const double strain = effort[i][0], calm = calmed[i][0];
    const double attention = concentration[i][0] * (1 - calm);
    auto c = controls.samples().col(i);
    c[brows] = -0.55 * calm - 0.2 * attention - 0.9 * strain;
    c[frown] = std::min(1.0, 0.35 * calm + 0.2 * attention + 0.9 * strain);
    c[smile] = calm - 0.25 * attention;
    c[jaw] = std::max(0.8 * strain - 0.2, 0.0) + 0.1 * calm;
    // Narrowed eyes blink all the same, and open for what is above them and what flies past.
    const double narrowed = (calm_lids + 0.02 * attention + 0.14 * strain + 0.02 * calm) *
                            (1 - cues.passes(controls.time(i)));
    c[lids] = std::max(c[lids], narrowed + lids_rise * std::min(c[eye_lean], 0.0));
  }
}

// Where head and eyes look.

namespace {

// m, for a figure of 1.78 m
const Vec3 opponent(0.35, 1.55, 3.0);
const Vec3 audience(-1.35, 1.42, 2.1);  // whom he greets
constexpr double stick_end = 0.15;      // m along the stick from the grip
constexpr double lowest_gaze = 1.10,
                 highest_gaze = 1.40;  // m, of the hand: how much of the gaze it draws
constexpr double least_drawn = 0.25, most_drawn = 0.8;
const Vec3 before_him(0.2, 0.55, 1.9);                   // m, where he looks at first
constexpr double looks_up = 0.25, takes_to_look = 0.40;  // s
// Before all rests (s) the stick goes behind him; after it he still looks there, over the shoulder.
constexpr double behind_by = 0.13, goes_behind = 0.14, looks_after = 0.18;
constexpr double over_shoulder = 0.05;  // m, of what he looks at there over the chain's end
constexpr double followed_smoothly = 0.05, lead = 0.12;  // s: 0.08 s ahead once the eyes are there
constexpr double head_share = 0.78;  // of the way from the chest's front to the target
constexpr double level = 0.85;       // the share of the trunk's tilt that the head makes up for
constexpr double leans_away = 0.16;  // rad, of the head from a stick that flies past it
constexpr double head_lag = 0.088, eye_lag = 0.040;  // s
constexpr double most_yaw = 0.60;                    // rad, of an eye
constexpr double most_lean = 0.42;  // rad: farther down the lower lid hides the iris
constexpr double most_nod = 0.80;   // rad, of the head
constexpr double blink_every = 2.9, blink_lasts = 0.20;  // s
constexpr double first_blink = 2.3;                      // s

/// Yaw to the left and lean forward (rad) of a direction.
Eigen::Vector2d angles(const Vec3& direction) {
  return {std::atan2(direction.x(), direction.z()),
          std::atan2(-direction.y(), std::hypot(direction.x(), direction.z()))};
}

/// How far the lids are down: they fall faster than they rise, at uneven intervals.
double blink(double time) {
  const double k = std::floor((time - first_blink) / blink_every);
  constexpr double golden = 0.6180339887;
  const double start = blink_every * k + first_blink + 0.6 * std::fmod(k * golden, 1.0);
  const double t = (time - start) / blink_lasts;
  return t < 0.4 ? smoothstep(t / 0.33) * (t > 0 ? 1 : 0) : smoothstep((1 - t) / 0.6);
}

}  // namespace

void look_about(const Figure& figure, const Path& path, Track& controls, const Cues& cues) {
  const double scale = figure.scale();
  const auto gaze = [&](double t) -> Vec3 {
    const Pose held = path.at(t).pose();
    const double drawn = least_drawn + (most_drawn - least_drawn) *
                                           smoothstep((held.position.y() / scale - lowest_gaze) /
                                                      (highest_gaze - lowest_gaze));
    const Vec3 end = held.position + held.rotation * Vec3(0, stick_end, 0);
    const Vec3 front = scale * opponent;
    if (!cues.swings) return front + drawn * (end - front);
    // He looks up from the floor to the opponent, then to the stick, and over his shoulder once
    // it is behind him; in the end to whom he greets, and lets no bow take his eyes off them.
    const Vec3 floor = scale * before_him;
    Vec3 waits = floor + smoothstep((t - looks_up) / takes_to_look) * (front - floor);
    if (cues.greets() && t > cues.rests) waits = scale * audience;
    const double follows =
        smoothstep((t - cues.begins + takes_to_look) / takes_to_look) *
        smoothstep((cues.rests + looks_after + takes_to_look - t) / takes_to_look);
    const Vec3 stick = cues.stick.at(t);
    const double behind = smoothstep((t - cues.rests + behind_by) / goes_behind);
    const Vec3 shoulder = end + scale * over_shoulder * Vec3::UnitY();
    return waits + follows * (stick + behind * (shoulder - stick) - waits);
  };
  const Track target = Track::sample(controls.time(controls.count() - 1), acting_rate,
                                     [&](double t) { return Eigen::VectorXd(gaze(t)); })
                           .smoothed(cues.swings ? followed_smoothly : 0.001)
                           .ahead(cues.swings ? lead : 0);
  const Track seen_late = target.lagged(head_lag), seen = target.lagged(eye_lag);
  const auto eyes_at = [&](const Placement& p) -> Vec3 {
    return p.position[figure.head_bone()] + p.turn[figure.head_bone()] * figure.between_eyes();
  };
  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    Controls c = controls[i];
    const Placement torso = figure.skeleton().place(figure.torso(c));
    const Quat& chest = figure.chest_turn(torso);
    const Eigen::Vector2d head =
        head_share * angles(chest.conjugate() * (seen_late[i] - eyes_at(torso)));
    c[head_yaw] += soft(head[0], 1.1);
    c[head_lean] += soft(head[1], most_nod);
    const double passes = cues.passes(controls.time(i)), away = leans_away * passes;
    c[head_tilt] = -level * (c[spine_tilt] + c[pelvis_tilt]) - away;
    c[head_lean] -= away;
    const Placement turned = figure.skeleton().place(figure.torso(c));
    const Quat& front = turned.turn[figure.head_bone()];
    const Eigen::Vector2d eye = angles(front.conjugate() * (seen[i] - eyes_at(turned)));
    c[eye_yaw] = soft(eye[0], most_yaw);
    // He looks over what flies past: eyes that look down take their lids along.
    c[eye_lean] = soft(eye[1] - passes * std::max(eye[1], 0.0), most_lean);
    // Nobody blinks at whom he greets.
    const bool greets = cues.greets() && controls.time(i) > cues.rests;
    c[lids] = greets ? 0 : blink(controls.time(i));
    controls.samples().col(i) = c;
  }
}

// The left arm: its guard while the right hand plays, from pose to pose.

namespace {

/// Where the left wrist is about the chest's joint: how far round to the left of its front (rad),
/// how far off and how high (m, for a figure of 1.78 m); and the sides to which elbow and thumb
/// are.
struct Guard {
  double round, off, height;
  Vec3 elbow, thumb;
};
const Guard at_ease{0.36, 0.28, -0.12, {0.8, -1.0, -0.5}, {-0.2, 1.0, 0.0}};
const Guard at_the_belt{0.08, 0.31, -0.17, {1.0, -0.6, -0.5}, {-0.1, 1.0, 0.0}};
const Guard open{0.02, 0.34, 0.03, {1.0, -0.9, -0.2}, {0.2, 1.0, 0.0}};
const Guard balancing{1.30, 0.60, 0.20, {0.3, -1.0, -0.2}, {0.0, 0.45, 1.0}};
const Guard across{-0.30, 0.30, 0.02, {1.0, -0.6, 0.2}, {-0.9, 0.5, 0.0}};
const Guard chambered{1.40, 0.26, -0.14, {0.35, -0.4, -1.0}, {1.0, 0.25, 0.2}};
const Guard greeting{-0.55, 0.30, 0.04, {0.5, -1.0, 0.1}, {0.75, 0.7, 0.1}};

constexpr Eigen::Index rows = 9;
using Row = Eigen::Matrix<double, rows, 1>;
Row row(const Guard& guard) {
  Row r;
  r << guard.round, guard.off, guard.height, guard.elbow.normalized(), guard.thumb.normalized();
  return r;
}

constexpr double elbow_ahead = 0.04, hand_behind = 0.11, thumb_behind = 0.15;  // s
/// The hand overshoots by this share of what it is ahead of itself so much later (s), and settles.
constexpr double overshoot = 0.25, settles = 0.22;
constexpr double stroke_behind = 0.14, stick_behind = 0.06;  // s, mean delays
constexpr double greets_after = 0.25, greets_within = 0.50;  // s, after all rests

}  // namespace

void keep_guard(const Figure& figure, const Path& path, const Cues& cues, Track& controls) {
  const double scale = figure.scale();
  const double until = controls.time(controls.count() - 1);
  const Track pose = Track::sample(until, acting_rate, [&](double time) {
    Row now = row(at_ease);
    const auto mix = [&](const Guard& guard, double share) { now += share * (row(guard) - now); };
    if (!cues.swings) return Eigen::VectorXd(now);
    now = row(at_the_belt);
    mix(open, cues.ready(time));
    mix(balancing, cues.braced.at(time)[0]);
    mix(across, cues.winds_up.at(time)[0]);
    mix(chambered, cues.struck(time));
    if (cues.greets())
      mix(greeting, smoothstep((time - cues.rests - greets_after) / greets_within));
    return Eigen::VectorXd(now);
  });
  const Track hand = pose.lagged(hand_behind), later = pose.lagged(settles);
  const Track elbow = pose.ahead(elbow_ahead), thumb = pose.lagged(thumb_behind);
  const Track stroke = Track::sample(until, acting_rate, [&](double time) {
                         return Eigen::VectorXd(path.at(time).position - path.at(0).position);
                       }).lagged(stroke_behind);
  const Track stick = cues.off.smoothed(0.05).lagged(stick_behind);
  const Row ease = row(at_ease);

  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const Row g = hand[i] + overshoot * (hand[i] - later[i]);
    Vec3 wrist(g[1] * std::sin(g[0]), g[2], g[1] * std::cos(g[0]));
    // It balances the right hand, and goes against the free stick.
    const Vec3 f = stroke[i] / scale, s = stick.at(controls.time(i)) / scale;
    wrist += Vec3(soft(-0.22 * f.x(), 0.05), soft(-0.20 * f.y(), 0.07), soft(-0.30 * f.z(), 0.08));
    wrist += Vec3(soft(-0.30 * s.x(), 0.10), soft(-0.20 * s.y(), 0.06), soft(0.30 * s.x(), 0.09));
    auto u = controls.samples().col(i);
    u.segment<3>(guard_x) = scale * wrist;
    u.segment<3>(guard_elbow_x) = elbow[i].segment<3>(3);
    u.segment<3>(guard_thumb_x) = thumb[i].segment<3>(6);
    // The shoulder goes along.
    u[left_shoulder_up] += soft(0.7 * (g[2] - ease[2]), 0.28);
    u[left_shoulder_forward] += soft(0.6 * (wrist.z() - ease[1] * std::cos(ease[0])), 0.22);
  }
}

// Steps: the foot in front goes where the hand goes, the foot behind is drawn up after it.

namespace {

constexpr double settling = 0.33;        // s, over which the hand's place is averaged
constexpr double step_foresight = 0.28;  // s: the foot is down again before the hand is there
constexpr double stays = 0.25;           // s: and stands where the hand will be so much later
constexpr double share_ahead = 1.5, share_aside = 0.3;  // of the hand's way
constexpr double farthest_step = 0.2;                   // m: the farthest that a foot goes
constexpr double drawn_up = 0.9;                        // of the way of the foot in front
constexpr double worth = 0.05;                          // m off, for which a foot takes a step
constexpr double lasts = 0.34;                          // s
constexpr double lift = 0.035;                          // m

constexpr double knees_give = 0.18;  // s, before and after a leg would be too short

/// A foot that stands, or goes from where it stood to where it will.
struct Foot {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  double start = -lasts;

  bool stands(double time) const { return time >= start + lasts; }
  bool is_off(const Vec3& there) const { return (there - to).norm() > worth; }
  void go(const Vec3& there, double time) {
    from = to;
    to = there;
    start = time;
  }
  Vec3 at(double time) const {
    if (stands(time)) return to;
    const double t = (time - start) / lasts;
    return from + t * t * (3 - 2 * t) * (to - from) + lift * std::sin(M_PI * t) * Vec3::UnitY();
  }
};

}  // namespace

Track take_steps(const Track& hand) {
  const Track settled = hand.smoothed(settling).ahead(step_foresight + lasts);
  const auto wanted = [&](double time) -> Vec3 {
    const Vec3 way = settled.at(time) - settled[0];
    const Vec3 there(share_aside * way.x(), 0, share_ahead * way.z());
    return farthest_step / std::max(farthest_step, there.norm()) * there;
  };
  Track steps(Eigen::MatrixXd::Zero(6, hand.count()), hand.rate());
  Foot right, left;
  for (Eigen::Index i = 0; i < hand.count(); ++i) {
    const double time = hand.time(i);
    // Never both at a time; the one in front goes first.
    if (right.stands(time) && left.stands(time)) {
      const Vec3 behind = drawn_up * right.to;
      if (right.is_off(wanted(time))) {
        right.go(wanted(time + stays), time);
      } else if (left.is_off(behind)) {
        left.go(behind, time);
      }
    }
    steps.samples().col(i) << right.at(time), left.at(time);
  }
  return steps;
}

void sink_to_the_feet(const Figure& figure, Track& controls) {
  Track above(Eigen::MatrixXd(1, controls.count()), acting_rate);
  for (Eigen::Index i = 0; i < controls.count(); ++i)
    above.samples()(0, i) = figure.above_its_feet(controls[i]);
  // Smooth, and nowhere less than it has to be.
  Track widened = above;
  const auto reach = static_cast<Eigen::Index>(knees_give * acting_rate);
  for (Eigen::Index i = 0; i < above.count(); ++i) {
    const Eigen::Index from = std::max<Eigen::Index>(0, i - reach);
    const Eigen::Index until = std::min(above.count() - 1, i + reach);
    widened.samples()(0, i) = above.samples().row(0).segment(from, until - from + 1).maxCoeff();
  }
  controls.samples().row(root_y) -= widened.smoothed(knees_give / 4).samples().row(0);
}

}  // namespace taut::scenes
