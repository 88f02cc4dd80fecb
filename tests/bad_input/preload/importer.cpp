// Stands in front of the importer's library and does what the environment asks for: what a fault in
// it could do.
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <assimp/Importer.hpp>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <vector>

namespace {

void misbehave(const char* how) {
  const auto is = [&](const char* name) { return std::strcmp(how, name) == 0; };
  if (is("crash")) std::raise(SIGSEGV);
  if (is("abort")) std::abort();
  if (is("throw")) throw std::logic_error("a list has no end");
  if (is("exit")) std::exit(0);
  if (is("socket")) socket(AF_INET, SOCK_STREAM, 0);
  if (is("read")) open("/etc/passwd", O_RDONLY);
  if (is("file")) open("planted", O_WRONLY | O_CREAT, 0600);
  if (is("remove")) unlink("scene.toml");
  if (is("memory")) {
    constexpr std::size_t kBlock = 64u << 20;  // bytes; not touched, so that it takes no time
    for (std::vector<std::unique_ptr<char[]>> all;;)
      all.push_back(std::make_unique_for_overwrite<char[]>(kBlock));
  }
  for (volatile bool goes_on = is("loop"); goes_on;) {
  }
}

}  // namespace

const aiScene* Assimp::Importer::ReadFileFromMemory(const void*, std::size_t, unsigned,
                                                    const char*) {
  misbehave(std::getenv("TAUT_IMPORTER_FAULT"));
  return nullptr;
}
