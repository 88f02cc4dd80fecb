#include "scenes/files/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <new>
#include <sstream>
#include <utility>
#include <vector>

#include "scenes/files/error.h"
#include "sim/motion/printable.h"
#include "sim/motion/stop.h"

namespace taut::scenes {
namespace {

/// The kind of a file that is not regular, in words.
const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

/// The bytes of an open file that messages call `name`.
std::string read_all(int file, const std::filesystem::path& name, std::size_t limit,
                     std::string_view expected) {
  const auto fail = [&](const std::string& cause) { throw bad_asset(name, cause); };
  std::string bytes;
  struct stat status {};
  if (fstat(file, &status) == 0 && static_cast<std::size_t>(status.st_size) <= limit) {
    bytes.reserve(static_cast<std::size_t>(status.st_size));
  }
  char block[1 << 16];
  ssize_t count = 0;
  while (bytes.size() <= limit && (count = read(file, block, sizeof block)) != 0) {
    if (count < 0 && errno == EINTR) {
      check_stop();
      continue;
    }
    if (count < 0) fail(fmt::format("cannot be read: {}", std::strerror(errno)));
    bytes.append(block, static_cast<std::size_t>(count));
  }
  if (bytes.size() > limit) {
    fail(fmt::format("is larger than {} MiB, expected {}", limit >> 20, expected));
  }
  return bytes;
}

/// An open file, closed at its end.
class Handle {
 public:
  explicit Handle(int number) : number_(number) {}
  Handle(Handle&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (number_ >= 0) close(number_);
  }
  int number() const { return number_; }

 private:
  int number_;
};

constexpr int kReading = O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK;  // a pipe's would wait

[[noreturn]] void fail_to_open(const std::filesystem::path& shown) {
  if (errno == ENOMEM) throw std::bad_alloc();
  throw bad_asset(shown, fmt::format("cannot be opened: {}", std::strerror(errno)));
}

/// The bytes of what is open, if it is a regular file.
std::string read_regular(const Handle& handle, const std::filesystem::path& shown,
                         std::size_t limit, std::string_view expected) {
  if (handle.number() < 0) fail_to_open(shown);
  struct stat status {};
  if (fstat(handle.number(), &status) != 0) {
    throw bad_asset(shown, fmt::format("cannot be read: {}", std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode)) {
    throw bad_asset(shown, fmt::format("is {}, expected {}", kind_of(status.st_mode), expected));
  }
  return read_all(handle.number(), shown, limit, expected);
}

/// A way from a folder down, followed part by part without ever leaving it.
class WayBeneath {
 public:
  WayBeneath(const std::filesystem::path& root, const std::filesystem::path& name,
             const std::filesystem::path& shown)
      : root_(root), shown_(shown) {
    folders_.emplace_back(open(root.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    if (folders_[0].number() < 0) fail_to_open(shown_);
    add(name);
  }

  /// The file at its end, open; nothing where there is none.
  std::optional<Handle> open_file(std::string_view expected) {
    while (!left_.empty()) {
      const std::string part = std::move(left_.back());
      left_.pop_back();
      if (part == "..") {
        if (folders_.size() == 1) fail_outside();
        folders_.pop_back();
        continue;
      }
      struct stat status {};
      if (fstatat(folder(), part.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) {
        if (errno == ENOENT || errno == ENOTDIR) return {};
        fail_to_open(shown_);
      }
      if (S_ISLNK(status.st_mode)) {
        follow(part);
      } else if (S_ISDIR(status.st_mode)) {
        enter(part);
      } else if (!left_.empty()) {
        return {};
      } else {
        if (!S_ISREG(status.st_mode)) fail_as(status.st_mode, expected);
        return Handle(openat(folder(), part.c_str(), kReading | O_NOFOLLOW));
      }
    }
    fail_as(S_IFDIR, expected);
  }

 private:
  static constexpr int kLinks = 40;  // as many as the system follows
  static constexpr std::size_t kDepth = 128;

  int folder() const { return folders_.back().number(); }
  [[noreturn]] void fail(const std::string& cause) const { throw bad_asset(shown_, cause); }
  [[noreturn]] void fail_as(mode_t mode, std::string_view expected) const {
    fail(fmt::format("is {}, expected {}", kind_of(mode), expected));
  }
  [[noreturn]] void fail_outside() const {
    fail(fmt::format("{}leads out of {}", links_ > 0 ? "is a link that " : "", root_.string()));
  }

  /// Goes `name` from here, then what is left.
  void add(const std::filesystem::path& name) {
    std::vector<std::string> parts;
    for (const std::filesystem::path& part : name.relative_path()) {
      if (!part.empty() && part != ".") parts.push_back(part.string());
    }
    if (name.is_absolute()) {
      std::size_t known = 0;
      for (const std::filesystem::path& part : root_.relative_path()) {
        if (part.empty()) continue;
        if (known == parts.size() || part != parts[known]) fail_outside();
        ++known;
      }
      parts.erase(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(known));
      while (folders_.size() > 1) folders_.pop_back();
    }
    left_.insert(left_.end(), parts.rbegin(), parts.rend());
  }

  void follow(const std::string& link) {
    if (++links_ > kLinks) fail(fmt::format("is a chain of more than {} links", kLinks));
    std::string target(PATH_MAX, '\0');
    const ssize_t size = readlinkat(folder(), link.c_str(), target.data(), target.size());
    if (size < 0) fail_to_open(shown_);
    target.resize(static_cast<std::size_t>(size));
    add(target);
  }

  void enter(const std::string& name) {
    if (folders_.size() > kDepth) fail(fmt::format("lies more than {} folders deep", kDepth));
    folders_.emplace_back(
        openat(folder(), name.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (folder() < 0) fail_to_open(shown_);
  }

  const std::filesystem::path& root_;
  const std::filesystem::path& shown_;
  std::vector<Handle> folders_;    // from the root down to here
  std::vector<std::string> left_;  // parts of the way, the next one last
  int links_ = 0;
};

}  // namespace

BadAsset bad_asset(const std::filesystem::path& file, const std::string& cause) {
  return BadAsset(fmt::format("{}: {}", printable(file.string()), printable(cause)));
}

std::string read_regular_file(const std::filesystem::path& file, std::size_t limit,
                              std::string_view expected) {
  return read_regular(Handle(open(file.c_str(), kReading)), file, limit, expected);
}

std::optional<std::string> read_beneath(const std::filesystem::path& root,
                                        const std::filesystem::path& name, std::size_t limit,
                                        std::string_view expected, const std::string& shown) {
  const std::filesystem::path called(shown);
  const std::optional<Handle> file = WayBeneath(root, name, called).open_file(expected);
  if (!file) return {};
  return read_regular(*file, called, limit, expected);
}

std::string read_standard_input(std::size_t limit, std::string_view expected) {
  return read_all(STDIN_FILENO, "standard input", limit, expected);
}

std::string read_bytes(const std::filesystem::path& file) {
  return read_regular_file(file, std::size_t{1} << 30, "a regular file");
}

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
