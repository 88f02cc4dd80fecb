#include "tests/faults/preload/trigger.h"

#include <fcntl.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <unwind.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace taut::faults {
namespace {

/// Libraries that do for the program what it would do itself. A graphics driver is not among them:
/// what it makes of a failure is not the program's.
constexpr const char* kOurs[] = {"libtaut_faults", "libstdc++", "libfmt",     "libc.",
                                 "libpng",         "libjpeg",   "libdeflate", "libfreetype"};

struct Range {
  std::uintptr_t begin, end, base;
  bool program;
};
constexpr int kMostRanges = 64;
Range ranges[kMostRanges];
int range_count = 0;
Page* page = nullptr;
thread_local bool busy __attribute__((tls_model("initial-exec"))) = false;

int note_ranges(dl_phdr_info* info, std::size_t, void*) {
  const char* slash = std::strrchr(info->dlpi_name, '/');
  const char* name = slash ? slash + 1 : info->dlpi_name;
  const bool program = *name == '\0';
  bool ours = program;
  for (const char* start : kOurs) ours |= std::strncmp(name, start, std::strlen(start)) == 0;
  for (int i = 0; ours && i < info->dlpi_phnum && range_count < kMostRanges; ++i) {
    const ElfW(Phdr)& part = info->dlpi_phdr[i];
    if (part.p_type != PT_LOAD || !(part.p_flags & PF_X)) continue;
    const std::uintptr_t begin = info->dlpi_addr + part.p_vaddr;
    ranges[range_count++] = {begin, begin + part.p_memsz, info->dlpi_addr, program};
  }
  return 0;
}

__attribute__((constructor)) void start() {
  const char* file = std::getenv(kPageVariable);
  // The library's own open() counts.
  const int descriptor = file ? static_cast<int>(syscall(SYS_openat, AT_FDCWD, file, O_RDWR)) : -1;
  if (descriptor < 0) return;
  void* shared = mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  close(descriptor);
  if (shared == MAP_FAILED) return;
  dl_iterate_phdr(note_ranges, nullptr);
  int nobody = 0;
  static_cast<Page*>(shared)->owner.compare_exchange_strong(nobody, getpid());
  page = static_cast<Page*>(shared);
}

/// The program's part of the stack, from the call outwards.
struct Stack {
  std::uintptr_t from = 0;  // where the program makes the call; 0: it does not
  int callers = 0;          // of that place, looked at
};

/// A driver that uses the C++ library may meet a copy of a template that lies in the program: so
/// what calls that must not be a driver, either.
constexpr int kMostCallers = 6;

_Unwind_Reason_Code look(_Unwind_Context* context, void* data) {
  auto& stack = *static_cast<Stack*>(data);
  const std::uintptr_t address = _Unwind_GetIP(context);
  for (int i = 0; i < range_count; ++i) {
    if (address < ranges[i].begin || address >= ranges[i].end) continue;
    if (stack.from == 0 && ranges[i].program) stack.from = address - ranges[i].base;
    const bool enough = stack.from != 0 && ++stack.callers > kMostCallers;
    return enough ? _URC_END_OF_STACK : _URC_NO_REASON;
  }
  if (address != 0) stack.from = 0;
  return _URC_END_OF_STACK;
}

/// Where in the program the call comes from; 0: it does not count.
std::uintptr_t caller() {
  if (page->owner != getpid()) return page->in_children ? 1 : 0;
  if (page->in_children) return 0;
  Stack stack;
  _Unwind_Backtrace(look, &stack);
  return stack.from;
}

}  // namespace

bool fails(Kind kind, const char* call, const char* what) {
  if (!page || busy || (page->how != How::count && page->kind != kind)) return false;
  busy = true;
  const std::uintptr_t from = caller();
  busy = false;
  if (from == 0) return false;
  const std::uint64_t number = ++page->calls[kind];
  if (page->how == How::count || number < page->at) return false;
  if (number > page->at && page->how != How::fail_from_there_on) return false;
  if (number == page->at) {
    busy = true;
    if (kind == kMemory) {
      std::snprintf(page->place, sizeof page->place, "%s at 0x%zx", call, std::size_t(from));
    } else {
      std::snprintf(page->place, sizeof page->place, "%s %s", call, what);
    }
    busy = false;
  }
  if (page->how == How::kill) kill(getpid(), SIGKILL);
  errno = kErrors[kind];
  return true;
}

bool write_fails(int descriptor) {
  if (!page || busy) return false;
  if (descriptor == STDOUT_FILENO) return fails(kSay, "write", "standard output");
  if (descriptor == STDERR_FILENO) return fails(kSay, "write", "standard error");
  return fails(kWrite, "write", descriptor);
}

bool fails(Kind kind, const char* call, int descriptor) {
  if (!page || busy) return false;
  const bool own = page->owner == getpid();
  if (!own && !page->in_children) return false;
  char link[64], name[200] = "a child's file";  // a child in the sandbox may not ask for its name
  if (own) {
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    const ssize_t length = readlink(link, name, sizeof name - 1);
    name[length < 0 ? 0 : length] = '\0';
  }
  return fails(kind, call, name);
}

}  // namespace taut::faults
