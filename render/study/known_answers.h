// Known answers: a folder with a scene, and the values that theory gives for it. A run of a method
// is compared with them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "render/options/study_options.h"
#include "scenes/scene/scene.h"
#include "sim/run/trajectory.h"

namespace taut::studies {

/// A row of answer.csv.
struct Answer {
  double time = 0;       // s
  std::string quantity;  // see kQuantitiesHelp
  double value = 0;      // SI
  double tolerance = 0;  // the largest error that passes
  std::size_t line = 0;  // of the file
};

/// A folder with scene.toml and answer.csv.
struct AnswerCase {
  std::string name;  // of the folder
  std::filesystem::path folder;
  std::string heading;  // the comment at the top of the scene: law, source, what is compared
  scenes::Scene scene;
  std::vector<Answer> answers;  // by rising time
};

/// The names of quantities, for --help.
extern const std::string_view kQuantitiesHelp;

/// The cases of each path: the folder itself, or the folders in it by their names. Throws BadAsset
/// where there is none.
std::vector<std::filesystem::path> answer_folders(const std::vector<std::filesystem::path>& paths);

/// The number that is all of `text`; none where it is not finite.
std::optional<double> finite_number(std::string_view text);
/// What stands between the commas of a line.
std::vector<std::string_view> row_cells(std::string_view line);

/// Reads a case. Throws BadScene, and BadAsset for a fault of answer.csv, also where a quantity is
/// none of the scene's.
AnswerCase read_answer_case(const std::filesystem::path& folder);

/// A method on a case, or another program.
struct Verdict {
  enum class Kind { passes, fails, diverged, over_cap, broken, not_followed };
  Kind kind = Kind::passes;
  std::string reason;                 // of an end before the last answer; why the method is not run
  std::vector<double> values;         // of the answers, as far as the run came
  std::size_t worst = 0;              // index of the answer with the largest share
  double share = 0;                   // of the tolerance: the largest error
  double cpu = 0;                     // s, of stepping
  std::vector<Snapshot> states = {};  // at the start and at the times of answers

  /// A run at one step, or at one tolerance of a method that chooses its steps.
  struct Run {
    bool is_of_step = true;
    double value = 0;  // s of the step, m of the tolerance
    Kind kind = Kind::passes;
    double error = 0;  // the largest of any place, as a share of the length; NaN: no place is asked
    double cpu = 0;    // s
  };
  std::vector<Run> runs = {};  // of a refinement, see answer_costs.h; this verdict is on the best

  bool is_failure() const { return kind != Kind::passes && kind != Kind::not_followed; }
};

/// The verdict in a word: passes, fails, diverged ...
std::string text_of(Verdict::Kind kind);

/// Adds the value of the next answer to a verdict; more than the tolerance off, it fails.
void judge(Verdict& verdict, const AnswerCase& of, double value);

/// Runs a method on a case, for at most `cpu_cap` (s). The scene's own method has the settings of
/// the scene, others their defaults; `set` (KEY=VALUE) is put over them. Throws Misuse.
Verdict verify(const AnswerCase& of, const options::Contender& contender,
               const std::vector<std::string>& set, double cpu_cap);

/// A case with the verdict on each method, by its label.
struct Verified {
  AnswerCase of;
  std::vector<std::pair<std::string, Verdict>> verdicts;
};

/// A page of one file: for each case its heading, a drawing of its states, and every answer beside
/// the value of each method.
std::string answers_page(const std::vector<Verified>& all);

}  // namespace taut::studies
