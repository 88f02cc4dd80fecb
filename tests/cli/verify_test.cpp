// taut verify, and the known answers of tests/answers: that they are what their programs compute,
// that the methods give them, and that faults are seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut::verify_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAnswers = TAUT_SOURCE_DIR "/tests/answers";

/// answers.py with these words.
ProgramResult compute(std::vector<std::string> words) {
  words.insert(words.begin(), {"/usr/bin/python3", "-B", std::string(kAnswers) + "/answers.py"});
  return Child(std::move(words), TAUT_SOURCE_DIR).wait();
}

/// A body that falls for a second, and what is known of it.
constexpr const char* kScene = R"(# Free fall.
duration = 1.0
[bodies.ball]
mass = 1.0
shape = { sphere = { diameter = 0.1 } }
position = [0, 0, 0]
)";
constexpr const char* kAnswer = "# known\ntime,quantity,value,tolerance\n1,ball.y,-4.905,1e-9\n";

fs::path write_case(const Folder& folder, const std::string& scene, const std::string& answer) {
  folder.write("case/scene.toml", scene);
  folder.write("case/answer.csv", answer);
  return folder.path() / "case";
}

/// Whether every `apart`-th case has the answers that its program computes.
void expect_computed(std::size_t apart) {
  std::vector<std::string> cases;
  for (const auto& entry : fs::directory_iterator(kAnswers)) {
    if (fs::exists(entry.path() / "answer.py")) cases.push_back(entry.path().filename());
  }
  std::ranges::sort(cases);
  ASSERT_GE(cases.size(), 110u);
  std::vector<std::string> words{"--check"};
  for (std::size_t i = 0; i < cases.size(); i += apart) words.push_back(cases[i]);
  const ProgramResult outcome = compute(words);
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
}

TEST(Answers, OfEveryEighthCaseAreWhatItsProgramComputes) {
  expect_computed(8);
}
TEST(LongAnswers, AreWhatTheirProgramsCompute) {
  expect_computed(1);
}

// By the method and by the truth, which shares neither equations of motion nor solvers with it.
// What neither follows is named here.
TEST(Answers, AreThoseOfTheMethodAndOfTheTruth) {
  const ProgramResult outcome =
      run_taut({"verify", kAnswers, "--methods", "direct,truth", "--json", "-q"});
  EXPECT_EQ(outcome.code, 0) << run_taut({"verify", kAnswers, "--failures"}).output;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_GE(json.at("cases").size(), 110u);
  EXPECT_EQ(json.at("not_run"), 0);
  EXPECT_EQ(json.at("failures"), 0);
}

/// Verifies some cases, or all, as answers.py writes them with `words` and a folder.
void expect_right(std::vector<std::string> words, const std::vector<std::string>& cases) {
  const Folder folder;
  words.push_back(folder.path());
  words.insert(words.end(), cases.begin(), cases.end());
  const ProgramResult outcome = compute(words);
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  const ProgramResult verified =
      run_taut({"verify", folder.path(), "--methods", "direct,truth", "--failures", "-q"});
  EXPECT_EQ(verified.code, 0) << verified.output;
}

// The middle of a chain of straight links approaches the catenary with the square of their length.
TEST(Answers, OfTheContinuumAreApproachedByLinks) {
  const Folder folder;
  ASSERT_EQ(compute({"--links", folder.path(), "catenary"}).code, 0);
  std::vector<double> errors;
  for (const char* name : {"catenary_8", "catenary_32"}) {
    const ProgramResult outcome =
        run_taut({"verify", folder.path() / name, "--converge", "--json", "-q"});
    errors.push_back(nlohmann::json::parse(outcome.output)
                         .at("cases")
                         .at(0)
                         .at("methods")
                         .at(0)
                         .at("least_error"));
  }
  EXPECT_NEAR(errors[0] / errors[1], 16, 0.5);
}

TEST(LongAnswers, AllAreRightAtOtherParameters) {
  expect_right({"--vary"}, {});
}

TEST(Answers, AreRightAtDrawnParameters) {
  expect_right({"--random", "7", "2"},
               {"helical_rod", "oblique_bounce", "twisted_ring", "winch_over_pulleys"});
}

TEST(LongAnswers, AllAreRightAtDrawnParameters) {
  expect_right({"--random", "11", "5"}, {});
}

// A program whose forces, contacts, materials or schemes were off by so much would be seen: the
// scene has the fault, the answer does not.
TEST(Answers, SeeFaultsOfOneInAHundred) {
  struct Fault {
    const char *of, *right, *wrong;
  };
  const Folder folder;
  for (const Fault& fault : {
           Fault{"pendulum", "title", "gravity = [0.0, -9.82, 0.0]\ntitle"},          // weight
           Fault{"sliding_stick", "friction = 0.2", "friction = 0.202"},              // friction
           Fault{"bouncing_ball", "restitution = 0.6", "restitution = 0.606"},        // impacts
           Fault{"head_on", "restitution = 0.7", "restitution = 0.707"},              // of bodies
           Fault{"spring_mass", "axial_stiffness = 20.0", "axial_stiffness = 20.2"},  // stretch
           Fault{"damped_spring", "axial_damping = 0.5", "axial_damping = 0.505"},    // damping
           Fault{"clamped_rod_swings", "bending_stiffness = 0.05", "bending_stiffness = 0.0505"},
           Fault{"twisted_rod", "twisting_stiffness = 0.015", "twisting_stiffness = 0.01515"},
           Fault{"damped_rod", "bending_damping = 0.006", "bending_damping = 0.00606"},
           Fault{"atwood_bearing", "bearing = 0.1", "bearing = 0.101"},
           Fault{"balls_rub", "\nfriction = 0.15", "\nfriction = 0.1515"},
           Fault{"bar_slides_on_beam", "friction = 0.3", "friction = 0.303"},
           Fault{"pendulum_in_wind", "across = 1.1", "across = 1.111"},     // air
           Fault{"atwood_friction", "friction = 0.2", "friction = 0.202"},  // pulleys
           Fault{"winch_lift", "paid_out = -1.1", "paid_out = -1.111"},     // winches
           Fault{"heavy_top", "diameter = 0.16", "diameter = 0.1616"},      // inertia
           Fault{"chain_swing", "mass = 0.35", "mass = 0.3535"},            // masses
       }) {
    std::string scene = read_file(fs::path(kAnswers) / fault.of / "scene.toml");
    const std::size_t at = scene.find(fault.right);
    ASSERT_NE(at, std::string::npos) << fault.of << ": " << fault.right;
    scene.replace(at, std::string(fault.right).size(), fault.wrong);
    const fs::path made =
        write_case(folder, scene, read_file(fs::path(kAnswers) / fault.of / "answer.csv"));
    const ProgramResult outcome = run_taut({"verify", made, "-q"});
    EXPECT_EQ(outcome.code, 1) << fault.of << "\n" << outcome.output << outcome.messages;
  }
  // A scheme that is not accurate enough.
  EXPECT_EQ(
      run_taut({"verify", std::string(kAnswers) + "/chain_swing", "--set", "step=0.1", "-q"}).code,
      1);
}

TEST(Verify, TellsErrorToleranceVerdictAndCost) {
  const Folder folder;
  const fs::path made = write_case(folder, kScene, kAnswer);
  const ProgramResult outcome =
      run_taut({"verify", "case", "--csv", "all.csv", "--page", "all.html"}, folder.path());
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_NE(outcome.output.find("passes"), std::string::npos);
  EXPECT_NE(outcome.output.find("1 pass, 0 fail, 0 not run"), std::string::npos);
  EXPECT_EQ(read_file(folder.path() / "all.csv").find("case,method,t,quantity,answer"), 0u);
  const std::string page = read_file(folder.path() / "all.html");
  EXPECT_NE(page.find("Free fall."), std::string::npos);
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(run_taut({"verify", folder.path(), "-q"}).code, 0);  // the folder of cases
}

TEST(Verify, AWrongAnswerIsOne) {
  const Folder folder;
  const fs::path made =
      write_case(folder, kScene, "time,quantity,value,tolerance\n1,ball.y,-4.9,1e-3\n");
  const ProgramResult outcome = run_taut({"verify", made, "-q"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.output.find("fails"), std::string::npos);
  EXPECT_NE(outcome.output.find("0.005"), std::string::npos) << outcome.output;
}

TEST(Verify, AMethodThatDoesNotFollowIsNotRun) {
  const ProgramResult outcome =
      run_taut({"verify", std::string(kAnswers) + "/atwood", "--methods", "xpbd", "-q"});
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_NE(outcome.output.find("does not follow"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("1 not run"), std::string::npos);
}

TEST(Verify, AFaultOfACaseHasItsPlace) {
  const Folder folder;
  const std::string columns = "time,quantity,value,tolerance\n";
  for (const auto& [answer, told] : std::vector<std::pair<std::string, std::string>>{
           {"t,y\n", "answer.csv:1: expected the columns time,quantity,value,tolerance"},
           {columns + "1,ball.y,1\n", "answer.csv:2: 3 cells"},
           {columns + "1,ball.y,1,1\n2,ball.y,1,1\n", "answer.csv:3: time: \"2\""},
           {columns + "-1,ball.y,1,1\n", "answer.csv:2: time: \"-1\""},
           {columns + "1,ball.y,nan,1\n", "answer.csv:2: value: \"nan\""},
           {columns + "1,ball.y,1,0\n", "answer.csv:2: tolerance: \"0\""},
           {columns + "1,ball.0.y,1,1\n", "answer.csv:2: quantity: the scene has no \"ball.0.y\""},
           {columns + "1,,1,1\n", "answer.csv:2: quantity"},
           {columns, "answer.csv: no rows"},
           {"", "answer.csv: no rows"}}) {
    const fs::path made = write_case(folder, kScene, answer);
    const ProgramResult outcome = run_taut({"verify", made, "-q"});
    EXPECT_EQ(outcome.code, 3) << answer;
    EXPECT_NE(outcome.messages.find(told), std::string::npos) << outcome.messages;
  }
  EXPECT_EQ(run_taut({"verify", folder.path() / "none"}).code, 3);
  write_case(folder, "duration = 1\nropes = 1\n", kAnswer);
  EXPECT_EQ(run_taut({"verify", folder.path() / "case"}).code, 3);
}

/// An engine that is a shell script.
std::string engine_of(const Folder& folder, const std::string& script) {
  return "mine=sh " + folder.write("engine.sh", script).string();
}

/// What became of the one engine or method of the one case.
nlohmann::json verdict_of(const ProgramResult& outcome) {
  return nlohmann::json::parse(outcome.output).at("cases").at(0).at("methods").at(0);
}

// The engine errs by its step: it is refined until it passes, and its order is seen.
TEST(Engine, StepIsHalvedUntilItPasses) {
  const Folder folder;
  const fs::path made =
      write_case(folder, kScene, "time,quantity,value,tolerance\n1,ball.y,-4.905,1e-3\n");
  const std::string engine = engine_of(folder, R"(
awk -F, -v step="$2" 'NR == 1 { print "time,quantity,value" }
  NR > 1 { printf "%s,%s,%.9g\n", $1, $2, -4.905 - step } END { print "cpu_s,0.001" }'
)");
  const ProgramResult outcome = run_taut({"verify", made, "--engine", engine, "--json", "-q"});
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  const auto verdict = verdict_of(outcome);
  EXPECT_EQ(verdict.at("method"), "mine");
  EXPECT_EQ(verdict.at("verdict"), "passes");
  EXPECT_EQ(verdict.at("runs").size(), 6u);  // 1/32 to 1/1024 s
  EXPECT_NEAR(verdict.at("worst").at("value"), -4.905 - 1.0 / 1024, 1e-8);
  EXPECT_EQ(verdict.at("cpu_s"), 0.001);
}

TEST(Engine, StandsBesideMethods) {
  const Folder folder;
  const fs::path made = write_case(folder, kScene, kAnswer);
  const std::string engine = engine_of(folder, "echo 'cannot express: gravity'");
  const ProgramResult outcome =
      run_taut({"verify", "case", "--methods", "direct", "--engine", engine, "--page", "all.html"},
               folder.path());
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_NE(outcome.output.find("cannot express: gravity"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("1 pass, 0 fail, 1 not run"), std::string::npos);
  EXPECT_NE(read_file(folder.path() / "all.html").find("<b>mine</b>: not run"), std::string::npos);
}

TEST(Engine, FaultsAreToldByName) {
  const Folder folder;
  const fs::path made = write_case(folder, kScene, kAnswer);
  for (const auto& [script, told] : std::vector<std::pair<std::string, std::string>>{
           {"echo no licence >&2; exit 3", "exit code 3: no licence"},
           {"kill -SEGV $$", "exit code 139"},
           {"", "output: 0 rows, expected 1"},
           {"echo t,q,v", "line 1: \"t,q,v\", expected the columns time,quantity,value"},
           {"echo time,quantity,value; echo 1,ball.y",
            "line 2: \"1,ball.y\", expected 1,ball.y,VALUE"},
           {"echo time,quantity,value; echo 1,ball.x,0", "expected 1,ball.y,VALUE"},
           {"echo time,quantity,value; echo 2,ball.y,0", "expected 1,ball.y,VALUE"},
           {"echo time,quantity,value; echo 1,ball.y,fast", "expected a number"},
           {"echo time,quantity,value; echo 1,ball.y,0; echo 1,ball.y,0", "expected no more rows"},
           {"echo cpu_s,-1", "expected cpu_s and a number of seconds"},
           {"head -c 20000000 /dev/zero", "output"}}) {
    const ProgramResult outcome =
        run_taut({"verify", made, "--engine", engine_of(folder, script), "--json", "-q"});
    EXPECT_EQ(outcome.code, 1) << script;
    const auto verdict = verdict_of(outcome);
    EXPECT_EQ(verdict.at("verdict"), "broken") << script;
    EXPECT_NE(verdict.at("reason").get<std::string>().find(told), std::string::npos) << verdict;
  }
  // A value that is no number is a wrong answer; an engine that does not end is stopped.
  const ProgramResult none =
      run_taut({"verify", made, "--engine",
                engine_of(folder, "echo time,quantity,value; echo 1,ball.y,nan; echo cpu_s,1"),
                "--cap", "1", "--json", "-q"});
  EXPECT_EQ(verdict_of(none).at("verdict"), "fails");
  const ProgramResult endless =
      run_taut({"verify", made, "--engine", engine_of(folder, "while :; do :; done"), "--cap",
                "0.1", "--json", "-q"});
  EXPECT_EQ(endless.code, 1);
  EXPECT_EQ(verdict_of(endless).at("verdict"), "over the cap");
}

/// That an adapter in the repository gives a case's places within a hundredth of the length.
void expect_adapter(const std::string& adapter, const std::string& of) {
  const ProgramResult outcome =
      run_taut({"verify", std::string(kAnswers) + "/" + of, "--engine",
                "it=/usr/bin/python3 -B " + std::string(kAnswers) + "/engines/" + adapter, "--cap",
                "0.02", "--json", "-q"});
  const auto verdict = verdict_of(outcome);
  ASSERT_TRUE(verdict.at("least_error").is_number()) << verdict;
  EXPECT_LT(verdict.at("least_error"), 0.01) << verdict;
}

TEST(Engine, TheExampleIsAnAdapter) {
  expect_adapter("example.py", "elastic_pendulum");
}

// ODE is always there. Rods in a loop, contacts of a stick with friction.
TEST(Engine, RigidBodiesHaveAnAdapter) {
  const std::string program =
      (std::filesystem::path(TAUT_PROGRAM).parent_path() / "taut_rigid").string();
  for (const char* of : {"four_bar", "stick_slips_on_floor"}) {
    expect_adapter("rigid_adapter.py ode " + program, of);
  }
}

// xpbd is of first order in its step, dynamic-constraints of its fourth; errors cost the more the
// smaller they are.
TEST(Converge, TellsOrderAndCost) {
  const Folder folder;
  const ProgramResult outcome =
      run_taut({"verify", std::string(kAnswers) + "/chain_swing", "--methods",
                "xpbd,dynamic-constraints,direct,truth", "--converge", "--cap", "0.3", "--chart",
                folder.path() / "costs", "--json", "-q"});
  EXPECT_EQ(outcome.code, 1);  // xpbd does not pass
  const auto methods = nlohmann::json::parse(outcome.output).at("cases").at(0).at("methods");
  EXPECT_NEAR(methods.at(0).at("order"), 1, 0.2);
  EXPECT_NEAR(methods.at(1).at("order"), 4, 0.6);
  EXPECT_EQ(methods.at(2).at("verdict"), "passes");
  EXPECT_EQ(methods.at(3).at("runs").size(), 1u);  // has neither step nor tolerance
  for (const auto& method : methods) {
    const auto& costs = method.at("costs");
    EXPECT_LE(costs.at(0).at("cpu_s"), costs.at(1).at("cpu_s"));
    EXPECT_LE(costs.at(1).at("cpu_s"), costs.at(2).at("cpu_s"));
    EXPECT_LT(method.at("least_error"), 1e-3);
  }
  EXPECT_NE(read_file(folder.path() / "costs.svg").find("<svg"), std::string::npos);
}

TEST(Verify, MisuseIsTwo) {
  const std::string pendulum = std::string(kAnswers) + "/pendulum";
  for (const std::vector<std::string>& rest :
       std::vector<std::vector<std::string>>{{"--methods", "directly"},
                                             {"--set", "stiffness=1"},
                                             {"--set", "tolerance=-1"},
                                             {"--cap", "0"},
                                             {"--chart", "costs"},
                                             {"--engine", "ode"},
                                             {"--engine", "=true"},
                                             {"--engine", "a b=true"},
                                             {"--engine", "none=/nonexistent/engine"},
                                             {"--methods", "direct", "--engine", "direct=true"}}) {
    std::vector<std::string> words{"verify", pendulum};
    words.insert(words.end(), rest.begin(), rest.end());
    const ProgramResult outcome = run_taut(words);
    EXPECT_EQ(outcome.code, 2) << rest.back() << outcome.messages;
    EXPECT_NE(outcome.messages, "");
  }
}

}  // namespace
}  // namespace taut::verify_test
