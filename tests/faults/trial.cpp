#include "tests/faults/trial.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <new>
#include <stdexcept>

#include "tests/support/folder.h"

namespace taut::faults {
namespace {

namespace fs = std::filesystem;

/// The page in a file that the program can find.
class SharedPage {
 public:
  SharedPage() {
    const int file = open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (file < 0 || ftruncate(file, sizeof(Page)) != 0) throw std::runtime_error("no page");
    void* memory = mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (memory == MAP_FAILED) throw std::runtime_error("no page");
    page_ = new (memory) Page;
  }
  ~SharedPage() { munmap(page_, sizeof(Page)); }
  SharedPage(const SharedPage&) = delete;
  SharedPage& operator=(const SharedPage&) = delete;

  Page* operator->() const { return page_; }
  const fs::path& name() const { return name_; }

 private:
  Folder folder_;
  fs::path name_ = folder_.path() / "page";
  Page* page_;
};

}  // namespace

Trial run_with(const Fault& fault, const Subject& subject, const fs::path& folder) {
  const SharedPage page;
  page->kind = fault.kind;
  page->how = fault.how;
  page->at = fault.at;
  page->in_children = fault.in_children;
  Trial trial;
  trial.outcome = run_taut(subject.arguments, folder, [&page] {
    setenv("LD_PRELOAD", TAUT_FAULT_LIBRARY, 1);
    setenv(kPageVariable, page.name().c_str(), 1);
  });
  for (int kind = 0; kind < kKinds; ++kind) trial.calls[kind] = page->calls[kind];
  trial.place = page->place;
  return trial;
}

ProgramResult run_undisturbed(const Subject& subject, const fs::path& folder) {
  return run_taut(subject.arguments, folder);
}

Files files_in(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = entry.path().lexically_relative(folder).string();
    files[name] = lasting(name, read_file(entry.path()));
  }
  return files;
}

}  // namespace taut::faults
