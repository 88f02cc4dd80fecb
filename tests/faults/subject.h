// The commands that are made to fail at every place, on scenes as small as they come.
#pragma once

#include <cstdint>
#include <map>
#include <ostream>
#include <set>
#include <string>
#include <vector>

namespace taut::faults {

using Files = std::map<std::string, std::string>;  // bytes by name, within a folder

struct Subject {
  std::string name;
  std::vector<std::string> arguments;
  Files before;               // what lies in the folder when it starts
  std::set<std::string> own;  // journals and locks: only for the program's next run
  int child_code = 0;         // exit code where a child process fails
  bool own_child = false;     // which is a copy of the program: memory fails there, too
  std::uint64_t allocations;  // how many of them fail, evenly chosen; there are thousands
  std::size_t apart;          // the default tests take every so-manieth place, by what a run costs
};

/// Names it in messages of the tests.
inline void PrintTo(const Subject& subject, std::ostream* out) {
  *out << subject.name;
}

const std::vector<Subject>& subjects();

/// The part of a file that is the same in every run: its bytes without times.
std::string lasting(const std::string& name, const std::string& bytes);

}  // namespace taut::faults
