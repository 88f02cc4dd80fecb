// The calls that can be made to fail, in front of the C library's.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "tests/faults/preload/trigger.h"

using namespace taut::faults;

namespace {

/// The function of this name that this library stands in front of.
template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
#define NEXT(name) static const auto real = next<decltype(name)>(#name)

bool writes(int flags) {
  return (flags & O_ACCMODE) != O_RDONLY || (flags & O_CREAT);
}

bool writes(const char* mode) {
  return std::strpbrk(mode, "wa+") != nullptr;
}

/// The mode that an open() with these flags is given.
#define MODE_OF(flags)                   \
  mode_t mode = 0;                       \
  if ((flags) & (O_CREAT | O_TMPFILE)) { \
    va_list more;                        \
    va_start(more, flags);               \
    mode = va_arg(more, mode_t);         \
    va_end(more);                        \
  }

}  // namespace

extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) noexcept {
  return fails(kMemory, "malloc", "") ? nullptr : __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) noexcept {
  return fails(kMemory, "calloc", "") ? nullptr : __libc_calloc(count, size);
}

void* realloc(void* block, std::size_t size) noexcept {
  return fails(kMemory, "realloc", "") ? nullptr : __libc_realloc(block, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return fails(kMemory, "aligned_alloc", "") ? nullptr : __libc_memalign(alignment, size);
}

int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  if (fails(kMemory, "posix_memalign", "")) return errno;
  *block = __libc_memalign(alignment, size);
  return *block ? 0 : ENOMEM;
}

int open(const char* file, int flags, ...) {
  NEXT(open);
  MODE_OF(flags)
  return writes(flags) && fails(kOpen, "open", file) ? -1 : real(file, flags, mode);
}

int open64(const char* file, int flags, ...) {
  NEXT(open64);
  MODE_OF(flags)
  return writes(flags) && fails(kOpen, "open", file) ? -1 : real(file, flags, mode);
}

int openat(int folder, const char* file, int flags, ...) {
  NEXT(openat);
  MODE_OF(flags)
  return writes(flags) && fails(kOpen, "open", file) ? -1 : real(folder, file, flags, mode);
}

int openat64(int folder, const char* file, int flags, ...) {
  NEXT(openat64);
  MODE_OF(flags)
  return writes(flags) && fails(kOpen, "open", file) ? -1 : real(folder, file, flags, mode);
}

FILE* fopen(const char* file, const char* mode) {
  NEXT(fopen);
  return writes(mode) && fails(kOpen, "open", file) ? nullptr : real(file, mode);
}

FILE* fopen64(const char* file, const char* mode) {
  NEXT(fopen64);
  return writes(mode) && fails(kOpen, "open", file) ? nullptr : real(file, mode);
}

ssize_t write(int file, const void* bytes, std::size_t count) {
  NEXT(write);
  return write_fails(file) ? -1 : real(file, bytes, count);
}

ssize_t pwrite(int file, const void* bytes, std::size_t count, off_t at) {
  NEXT(pwrite);
  return write_fails(file) ? -1 : real(file, bytes, count, at);
}

ssize_t writev(int file, const iovec* parts, int count) {
  NEXT(writev);
  return write_fails(file) ? -1 : real(file, parts, count);
}

std::size_t fwrite(const void* bytes, std::size_t size, std::size_t count, FILE* file) {
  NEXT(fwrite);
  return write_fails(fileno(file)) ? 0 : real(bytes, size, count, file);
}

int fputs(const char* text, FILE* file) {
  NEXT(fputs);
  return write_fails(fileno(file)) ? EOF : real(text, file);
}

int fsync(int file) {
  NEXT(fsync);
  return fails(kSync, "fsync", file) ? -1 : real(file);
}

int fdatasync(int file) {
  NEXT(fdatasync);
  return fails(kSync, "fsync", file) ? -1 : real(file);
}

int rename(const char* from, const char* to) noexcept {
  NEXT(rename);
  return fails(kRename, "rename to", to) ? -1 : real(from, to);
}

int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept {
  NEXT(renameat);
  return fails(kRename, "rename to", to) ? -1 : real(from_folder, from, to_folder, to);
}

int unlink(const char* file) noexcept {
  NEXT(unlink);
  return fails(kUnlink, "unlink", file) ? -1 : real(file);
}

int unlinkat(int folder, const char* file, int flags) noexcept {
  NEXT(unlinkat);
  return fails(kUnlink, "unlink", file) ? -1 : real(folder, file, flags);
}

int remove(const char* file) noexcept {
  NEXT(remove);
  return fails(kUnlink, "unlink", file) ? -1 : real(file);
}

int mkdir(const char* folder, mode_t mode) noexcept {
  NEXT(mkdir);
  return fails(kMkdir, "mkdir", folder) ? -1 : real(folder, mode);
}

int fchmod(int file, mode_t mode) noexcept {
  NEXT(fchmod);
  return fails(kMode, "chmod", file) ? -1 : real(file, mode);
}

int fchmodat(int folder, const char* file, mode_t mode, int flags) noexcept {
  NEXT(fchmodat);
  return fails(kMode, "chmod", file) ? -1 : real(folder, file, mode, flags);
}

int flock(int file, int action) noexcept {
  NEXT(flock);
  return fails(kLock, "flock", file) ? -1 : real(file, action);
}

int ftruncate(int file, off_t size) noexcept {
  NEXT(ftruncate);
  return fails(kCut, "ftruncate", file) ? -1 : real(file, size);
}

pid_t fork() noexcept {
  NEXT(fork);
  return fails(kSpawn, "start", "a copy") ? -1 : real();
}

pid_t vfork() noexcept {
  return fork();  // a function around vfork() cannot return twice
}

int posix_spawn(pid_t* id, const char* file, const posix_spawn_file_actions_t* actions,
                const posix_spawnattr_t* attributes, char* const arguments[],
                char* const environment[]) {
  NEXT(posix_spawn);
  if (fails(kSpawn, "start", arguments[0])) return errno;
  return real(id, file, actions, attributes, arguments, environment);
}

int posix_spawnp(pid_t* id, const char* file, const posix_spawn_file_actions_t* actions,
                 const posix_spawnattr_t* attributes, char* const arguments[],
                 char* const environment[]) {
  NEXT(posix_spawnp);
  if (fails(kSpawn, "start", arguments[0])) return errno;
  return real(id, file, actions, attributes, arguments, environment);
}

int pipe(int ends[2]) noexcept {
  NEXT(pipe);
  return fails(kPipe, "pipe", "") ? -1 : real(ends);
}

int pipe2(int ends[2], int flags) noexcept {
  NEXT(pipe2);
  return fails(kPipe, "pipe", "") ? -1 : real(ends, flags);
}

int memfd_create(const char* name, unsigned flags) noexcept {
  NEXT(memfd_create);
  return fails(kPipe, "memory file", name) ? -1 : real(name, flags);
}

int pthread_create(pthread_t* id, const pthread_attr_t* attributes, void* (*work)(void*),
                   void* argument) noexcept {
  NEXT(pthread_create);
  return fails(kThread, "thread", "") ? errno : real(id, attributes, work, argument);
}

}  // extern "C"
