#include "render/profile.h"

#include <algorithm>
#include <chrono>
#include <ctime>

namespace taut {
namespace {

double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

void Profile::start() {
  cpu_ = cpu_seconds();
  wall_ = wall_seconds();
}

void Profile::lap(const Gl& gl, const char* stage) {
  gl.Finish();
  const double cpu = cpu_seconds(), wall = wall_seconds();
  auto found = std::ranges::find(stages_, stage, &Stage::name);
  if (found == stages_.end()) found = stages_.insert(stages_.end(), Stage{stage});
  found->cpu += cpu - cpu_;
  found->wall += wall - wall_;
  cpu_ = cpu;
  wall_ = wall;
}

}  // namespace taut
