#include "sim/run/shown_velocities.h"

#include <utility>

#include "sim/world/places.h"

namespace taut {

ShownVelocities::ShownVelocities(const World& start, const Timeline& timeline)
    : start_(start.connectors), cuts_(in_order_of_time(timeline.cuts)) {
  for (const Connector& connector : start_) {
    bool shifted = false;
    for (const Hold& hold : connector.holds)
      shifted |= hold.particle == 0 && hold.to.kind == Attachment::Kind::body &&
                 start.bodies[hold.to.body].model == BodyModel::link;
    shifted_.push_back(shifted);
  }
  Parts parts(start_);
  for (const TimedCut& cut : cuts_) parts.cut(cut.connector, cut.along, parts.all().size());
  const World end = divided(start, timeline);
  for (const Parts::Part& part : parts.all()) {
    Shown shown{part.whole, {part.start}};
    for (const double rest : end.connectors.at(part.connector).rest)
      shown.along.push_back(shown.along.back() + rest);
    shown_.push_back(std::move(shown));
  }
  shown_row_ = parts.in_a_row();
}

std::vector<std::vector<Vec3>> ShownVelocities::of(const Simulation& simulation) const {
  const std::vector<Connector>& now = simulation.world().connectors;
  Parts parts(start_);
  for (std::size_t made = start_.size(); made < now.size(); ++made) {
    const TimedCut& cut = cuts_[made - start_.size()];
    parts.cut(cut.connector, cut.along, made);
  }
  std::vector<std::vector<Vec3>> result(shown_.size());
  Walk walk;
  std::size_t last = 0;
  for (const std::size_t row : shown_row_) {
    const Shown& shown = shown_[row];
    const double middle = (shown.along.front() + shown.along.back()) / 2;
    const auto [connector, along] = parts.at(shown.whole, middle);
    const double before = shifted_[shown.whole] ? now[connector].rest.front() : 0;
    if (connector != std::exchange(last, connector)) walk = {};
    if (now[connector].winch) {
      result[row] = now[connector].velocity;
      continue;
    }
    result[row] = velocities(now[connector], middle - along - before, shown.along, walk);
  }
  return result;
}

}  // namespace taut
