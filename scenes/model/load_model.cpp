#include "scenes/model/load_model.h"

#include <fmt/format.h>

#include <functional>
#include <new>
#include <system_error>
#include <variant>

#include "scenes/files/files.h"
#include "scenes/model/import.h"
#include "scenes/model/model.h"
#include "scenes/model/model_bytes.h"
#include "scenes/model/sandbox.h"
#include "sim/motion/printable.h"

namespace taut::scenes {

namespace fs = std::filesystem;

namespace {

constexpr int kRounds = 5;  // a model names its files, an OBJ's library of materials its own

constexpr char kModel = 'm', kWanted = 'w', kRefused = 'r', kFailed = 'f';  // a reply's start

/// The importers do some 10 MB a second; a small file gets 5 s.
SandboxLimits limits_for(std::size_t bytes) {
  const double cpu_time = 5 + static_cast<double>(bytes >> 20);
  return {model_limits::memory, model_limits::reply, cpu_time, 20 * cpu_time};
}

std::string reply_to(const fs::path& file, const std::string& content, NamedFiles& files) {
  try {
    const std::optional<Model> model = import_model(file, content, files);
    return model ? kModel + to_bytes(*model) : kWanted + to_bytes(files.wanted());
  } catch (const BadAsset& error) {
    return kRefused + std::string(error.what());
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return kFailed + std::string(error.what());
  }
}

/// Why there is no model, where the process that should read it gave no answer.
std::string cause_of(const SandboxResult& result, const SandboxLimits& limits) {
  using End = SandboxResult::End;
  switch (result.end) {
    case End::no_memory:
      return fmt::format("takes more than {} MiB of memory to be read", limits.memory >> 20);
    case End::too_long:
      return fmt::format("its meshes take more than {} MiB", limits.reply >> 20);
    case End::no_time:
      return fmt::format("takes longer than {} s to be read", limits.cpu_time);
    case End::forbidden:
      return "its reader asked the system for more than memory, and was stopped";
    default:
      return result.status > 128
                 ? fmt::format("its reader was ended by signal {}", result.status - 128)
                 : fmt::format("its reader ended with status {}", result.status);
  }
}

/// A model, or the files that it takes to read it.
using Found = std::variant<Model, std::vector<NamedFile>>;
using Read = std::function<Found(const std::string& content, NamedFiles& files)>;

/// Reads a model as often as it names files that were not known before.
Model load_with(const fs::path& file, const fs::path& within, const Read& read) {
  std::error_code error;
  const fs::path real = fs::weakly_canonical(file, error);
  throw_if_out_of_memory(error);
  const fs::path project = within.empty() ? real.parent_path() : within;
  const std::optional<std::string> content = read_beneath(
      project, real.lexically_relative(project), model_limits::bytes, "a model", file.string());
  if (!content) throw bad_asset(file, "cannot be opened: No such file or directory");
  NamedFiles files;
  for (int round = 0; round < kRounds; ++round) {
    auto found = read(*content, files);
    if (Model* model = std::get_if<Model>(&found)) return std::move(*model);
    files.read(file, project, std::get<std::vector<NamedFile>>(found));
  }
  throw bad_asset(file, "its reader asks for ever more files");
}

}  // namespace

Model load_model(const fs::path& file, const fs::path& within) {
  return load_with(file, within, [&](const std::string& content, NamedFiles& files) {
    const SandboxLimits limits = limits_for(content.size() + files.size());
    SandboxResult result;
    try {
      result = run_in_sandbox(limits, [&] { return reply_to(file, content, files); });
    } catch (const std::system_error& error) {
      throw_if_out_of_memory(error.code());
      throw bad_asset(file, fmt::format("cannot be read: {}", error.what()));
    }
    if (result.end == SandboxResult::End::out_of_memory) throw std::bad_alloc();
    if (result.end != SandboxResult::End::replied) throw bad_asset(file, cause_of(result, limits));
    const std::string_view reply = result.reply;
    if (reply.starts_with(kRefused)) throw BadAsset(printable(reply.substr(1)));
    if (reply.starts_with(kModel)) {
      if (auto model = model_of_bytes(reply.substr(1))) return Found(std::move(*model));
    }
    if (reply.starts_with(kWanted)) {
      if (auto wanted = named_files_of_bytes(reply.substr(1))) return Found(std::move(*wanted));
    }
    throw bad_asset(file, reply.starts_with(kFailed)
                              ? fmt::format("its reader failed: {}", reply.substr(1))
                              : std::string("its reader gave no model"));
  });
}

Model load_model_here(const fs::path& file, const fs::path& within) {
  return load_with(file, within, [&](const std::string& content, NamedFiles& files) {
    if (auto model = import_model(file, content, files)) return Found(std::move(*model));
    return Found(files.wanted());
  });
}

}  // namespace taut::scenes
