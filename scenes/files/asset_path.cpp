#include "scenes/files/asset_path.h"

#include <fmt/format.h>

#include <cstdlib>
#include <new>
#include <sstream>

#include "scenes/files/error.h"

namespace taut::scenes {

namespace fs = std::filesystem;

namespace {

fs::path& chosen_folder() {
  static fs::path folder;
  return folder;
}

fs::path resolved(const fs::path& path) {
  std::error_code error;
  const fs::path real = fs::weakly_canonical(path, error);
  throw_if_out_of_memory(error);
  return error ? path : real;
}

/// The running program; empty if the system does not tell.
fs::path running_program() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  throw_if_out_of_memory(error);
  return error ? fs::path() : program;
}

/// The nearest folder above that is a project's. If there is none: `folder` itself, or the folder
/// above a golden suite, whose scenes are beside it.
fs::path project_of(const fs::path& folder) {
  std::error_code error;
  for (fs::path at = folder;; at = at.parent_path()) {
    if (fs::exists(at / "CMakePresets.json", error) || fs::exists(at / ".git", error)) return at;
    if (at == at.parent_path())
      return fs::exists(folder / "golden.toml", error) ? folder.parent_path() : folder;
  }
}

}  // namespace

void set_asset_folder(const fs::path& folder) {
  chosen_folder() = folder;
}

fs::path installed_share() {
  std::error_code error;
  const fs::path program = running_program();
  if (program.parent_path().filename() != "bin") return {};
  const fs::path share = program.parent_path().parent_path() / "share/taut";
  return fs::is_directory(share, error) ? share : fs::path();
}

void throw_if_out_of_memory(const std::error_code& error) {
  if (error == std::errc::not_enough_memory) throw std::bad_alloc();
}

std::vector<AssetFolder> asset_folders(const fs::path& folder) {
  std::vector<AssetFolder> folders;
  const auto add = [&](const char* what, const fs::path& path, const fs::path& within) {
    for (const AssetFolder& known : folders) {
      if (known.folder == path) return;
    }
    folders.push_back({what, path, within});
  };
  const auto add_tree = [&](const char* what, const fs::path& path) {
    if (!path.empty()) add(what, resolved(path), resolved(path));
  };
  add_tree("--assets", chosen_folder());
  if (const char* variable = std::getenv("TAUT_ASSETS")) {
    std::istringstream list(variable);
    for (std::string path; std::getline(list, path, ':');) add_tree("TAUT_ASSETS", path);
  }
  const fs::path scene = resolved(folder), project = project_of(scene);
  add("beside the scene", scene, project);
  add("the scene's project", project, project);
  add_tree("installed", installed_share());
  const fs::path built = running_program().parent_path(), source = project_of(built);
  if (source != built) add_tree("the program's project", source);
  return folders;
}

fs::path shipped_file(const fs::path& path) {
  const auto folders = asset_folders(fs::current_path());
  std::error_code error;
  for (const AssetFolder& place : folders) {
    if (fs::exists(place.folder / path, error)) return place.folder / path;
  }
  throw BadScene(
      fmt::format("there is no file \"{}\"; looked: {}", path.string(), places(folders)));
}

std::string places(const std::vector<AssetFolder>& folders) {
  std::string list;
  for (const AssetFolder& place : folders) {
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", place.what, place.folder.string());
  }
  return list;
}

}  // namespace taut::scenes
