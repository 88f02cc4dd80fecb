#include "render/gl/profile.h"

#include <algorithm>
#include <chrono>
#include <ctime>

namespace taut::gl {
namespace {

Profile::Times now() {
  timespec cpu{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
  const auto wall = std::chrono::steady_clock::now().time_since_epoch();
  return {double(cpu.tv_sec) + 1e-9 * double(cpu.tv_nsec),
          std::chrono::duration<double>(wall).count()};
}

double median(const std::vector<Profile::Times>& frames, double Profile::Times::*time) {
  std::vector<double> times;
  for (const Profile::Times& frame : frames) times.push_back(frame.*time);
  const auto middle = times.begin() + std::ptrdiff_t(times.size() / 2);
  std::ranges::nth_element(times, middle);
  return times.empty() ? 0 : *middle;
}

}  // namespace

void Profile::start() {
  last_ = now();
}

void Profile::lap(const char* stage) {
  const Times time = now();
  auto found = std::ranges::find(stages_, stage, &Stage::name);
  if (found == stages_.end()) found = stages_.insert(stages_.end(), Stage{stage, {}});
  found->frames.push_back({time.cpu - last_.cpu, time.wall - last_.wall});
  last_ = time;
}

Profile::Times median(const Profile::Stage& stage) {
  return {median(stage.frames, &Profile::Times::cpu), median(stage.frames, &Profile::Times::wall)};
}

}  // namespace taut::gl
