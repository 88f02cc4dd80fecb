#include "render/chart/gnuplot.h"

#include <fmt/format.h>

#include <system_error>

#include "render/base/error.h"

namespace taut::chart {

render::ChildResult run_gnuplot(const std::vector<std::string>& command, const std::string& input) {
  render::ChildResult result;
  try {
    result = render::run_child(command, input);
  } catch (const std::system_error& error) {
    throw render::CannotWrite(
        fmt::format("{}; charts are drawn by gnuplot (Debian: gnuplot-nox)", error.what()));
  }
  if (result.status != 0 || result.output.empty()) {
    throw render::CannotWrite(
        fmt::format("gnuplot failed with status {}: {}", result.status, result.errors));
  }
  return result;
}

void require_gnuplot() {
  run_gnuplot({"gnuplot", "--version"}, "");
}

}  // namespace taut::chart
