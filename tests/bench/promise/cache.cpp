// Files of references: numbers of 8 bytes, as the machine has them.
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "tests/bench/promise/reference.h"

namespace taut::promise {
namespace {

template <typename T>
void put(std::ostream& out, T value) {
  static_assert(sizeof value == 8);
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

template <typename T>
T get(std::istream& in) {
  static_assert(sizeof(T) == 8);
  T value{};
  in.read(reinterpret_cast<char*>(&value), sizeof value);
  return value;
}

/// Whether the reference starts where the scene does, but for what a projection moves.
bool starts_there(const Reference& reference, const World& world, double length) {
  if (reference.frames.empty()) return true;
  const Snapshot& first = reference.frames[0];
  for (std::size_t c = 0; c < first.connectors.size(); ++c) {
    for (std::size_t i = 0; i < first.connectors[c].size(); ++i) {
      const Vec3 off = first.connectors[c][i] - world.connectors[c].position[i];
      if (!(off.norm() < kNudge * length)) return false;
    }
  }
  return true;
}

}  // namespace

Cache::Cache(std::string folder) : folder_(std::move(folder)) {
  std::filesystem::create_directories(folder_);
}

std::string Cache::path(const Drawn& drawn) const {
  return folder_ + "/v" + std::to_string(kVersion) + "_" + std::to_string(drawn.seed) + ".truth";
}

std::optional<Reference> Cache::find(const Drawn& drawn) const {
  std::ifstream in(path(drawn), std::ios::binary);
  if (!in) return std::nullopt;
  Reference reference;
  reference.end = static_cast<Reference::End>(get<std::int64_t>(in));
  reference.growth = get<double>(in);
  reference.cpu = get<double>(in);
  reference.frames.resize(get<std::uint64_t>(in));
  for (Snapshot& frame : reference.frames) {
    frame.time = get<double>(in);
    for (const Connector& connector : drawn.world.connectors) {
      std::vector<Vec3>& particles = frame.connectors.emplace_back(connector.particles());
      for (Vec3& particle : particles) {
        for (double& c : particle) c = get<double>(in);
      }
    }
  }
  if (!in || in.get() != EOF || !starts_there(reference, drawn.world, drawn.length)) {
    throw std::runtime_error(path(drawn) + ": not the reference of this scene");
  }
  return reference;
}

void Cache::keep(const Drawn& drawn, const Reference& reference) const {
  const std::string draft = path(drawn) + "." + std::to_string(getpid());
  std::ofstream out(draft, std::ios::binary);
  put(out, static_cast<std::int64_t>(reference.end));
  put(out, reference.growth);
  put(out, reference.cpu);
  put(out, static_cast<std::uint64_t>(reference.frames.size()));
  for (const Snapshot& frame : reference.frames) {
    put(out, frame.time);
    for (const std::vector<Vec3>& particles : frame.connectors) {
      for (const Vec3& particle : particles) {
        for (const double c : particle) put(out, c);
      }
    }
  }
  out.close();
  if (!out) throw std::runtime_error(draft + ": cannot be written");
  std::filesystem::rename(draft, path(drawn));
}

}  // namespace taut::promise
