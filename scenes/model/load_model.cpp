#include "scenes/model/load_model.h"

#include <fmt/format.h>

#include <new>
#include <system_error>

#include "scenes/files/regular_file.h"
#include "scenes/model/import.h"
#include "scenes/model/limits.h"
#include "scenes/model/model_bytes.h"
#include "scenes/model/sandbox.h"

namespace taut::scenes {
namespace {

constexpr char kModel = 'm', kRefused = 'r', kFailed = 'f';  // what a reply starts with

/// The importers do some 10 MB a second; a small file gets 5 s.
SandboxLimits limits_for(std::size_t bytes) {
  const double cpu_time = 5 + static_cast<double>(bytes >> 20);
  return {model_limits::memory, model_limits::reply, cpu_time, 4 * cpu_time};
}

std::string reply_to(const std::filesystem::path& file, const std::string& content) {
  try {
    return kModel + to_bytes(import_model(file, content));
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
    case End::no_time:
      return fmt::format("takes longer than {} s to be read", limits.cpu_time);
    case End::forbidden:
      return "its reader asked the system for more than to read files, and was stopped";
    default:
      return result.status > 128
                 ? fmt::format("its reader was ended by signal {}", result.status - 128)
                 : fmt::format("its reader ended with status {}", result.status);
  }
}

}  // namespace

Model load_model(const std::filesystem::path& file) {
  const std::string content = read_regular_file(file, model_limits::bytes, "a model");
  const SandboxLimits limits = limits_for(content.size());
  SandboxResult result;
  try {
    result = run_in_sandbox(limits, [&] { return reply_to(file, content); });
  } catch (const std::system_error& error) {
    throw bad_asset(file, fmt::format("cannot be read: {}", error.what()));
  }
  if (result.end != SandboxResult::End::replied) throw bad_asset(file, cause_of(result, limits));
  const std::string_view reply = result.reply;
  if (reply.starts_with(kRefused)) throw BadAsset(result.reply.substr(1));
  if (reply.starts_with(kModel)) {
    if (std::optional<Model> model = model_of_bytes(reply.substr(1))) return std::move(*model);
  }
  throw bad_asset(file, reply.starts_with(kFailed)
                            ? fmt::format("its reader failed: {}", reply.substr(1))
                            : std::string("its reader gave no model"));
}

}  // namespace taut::scenes
