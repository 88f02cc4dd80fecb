// The program as scripts meet it: exit codes, standard output and error, files that are whole or
// not there.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/run/method.h"
#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

// Hours of simulation, to be interrupted.
const std::string kLong = [] {
  std::string scene = kPushedStick;
  return scene.replace(scene.find("0.1"), 3, "36000");
}();

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> list;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) list.push_back(line);
  return list;
}

TEST(Program, HelpTeaches) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"--help"}, {"simulate", "--help"}, {"check", "--help"}}) {
    const ProgramResult outcome = run_taut(command);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.output.find("Examples:\n  taut "), std::string::npos);
    EXPECT_EQ(outcome.messages, "");
  }
}

TEST(Program, MisuseIsTwo) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  for (const std::vector<std::string>& command : {
           std::vector<std::string>{},
           {"simulate"},
           {"simulat", "scene.toml"},
           {"simulate", "scene.toml", "--frobnicate"},
           {"simulate", "scene.toml", "--csv", "--out"},
           {"simulate", "scene.toml", "--forces", "-"},
           {"simulate", "scene.toml", "--csv", "t.csv", "--forces", "t.csv"},
           {"simulate", "scene.toml", "--score", "1e-3", "--forces", "f.csv"},
           {"simulate", "scene.toml", "--fps", "0"},
           {"simulate", "scene.toml", "--fps", "many"},
           {"simulate", "scene.toml", "--step", "-1"},
           {"simulate", "scene.toml", "--step", "1e-30"},
           {"simulate", "scene.toml", "--step", "1e-13"},
           {"simulate", "scene.toml", "--step", "nan"},
           {"simulate", "scene.toml", "--step", "0.007"},  // does not divide a frame of 20 ms
           {"simulate", "scene.toml", "--step", "0.001", "--tolerance", "0.001"},
           {"simulate", "scene.toml", "--method", "impulsive"},
           {"simulate", "scene.toml", "--set", "h"},
           {"simulate", "scene.toml", "--set", "h=high"},
           {"simulate", "scene.toml", "--set", "stiffness=5"},
           {"simulate", "scene.toml", "--threads", "-1"},
           {"check"},
       }) {
    const ProgramResult outcome = run_taut(command, folder.path());
    EXPECT_EQ(outcome.code, 2) << fmt::format("{}", fmt::join(command, " "));
    EXPECT_EQ(outcome.output, "");
    EXPECT_NE(outcome.messages, "");
  }
}

TEST(Simulate, WritesOneRowPerFrameToOutput) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  const ProgramResult outcome = run_taut({"simulate", "scene.toml"}, folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto rows = lines(outcome.output);
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(rows[0],
            "t,cord.0.x,cord.0.y,cord.0.z,cord.1.x,cord.1.y,cord.1.z,cord.2.x,cord.2.y,cord.2.z,"
            "free.x,free.y,free.z,free.qw,free.qx,free.qy,free.qz,"
            "held.x,held.y,held.z,held.qw,held.qx,held.qy,held.qz")
      << "impulse has no estimate";
  // At the start the cord stands below the hand, and the free body below the cord.
  EXPECT_EQ(rows[1].rfind(fmt::format("0,0,{:.17g},0,0,", 1 - 0.15), 0), 0u) << rows[1];
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ(rows[k + 1].rfind(fmt::format("{:.17g},", static_cast<double>(k) / 50), 0), 0u);
    EXPECT_EQ(std::ranges::count(rows[k + 1], ','), 23);
  }
}

TEST(Simulate, SameBitsTwiceAndInAFile) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  const ProgramResult first = run_taut({"simulate", "scene.toml"}, folder.path());
  const ProgramResult second =
      run_taut({"simulate", "scene.toml", "--csv", "new/folder/t.csv", "--quiet"}, folder.path());
  EXPECT_EQ(second.code, 0);
  EXPECT_EQ(second.output, "");
  EXPECT_EQ(second.messages, "");
  EXPECT_EQ(read_file(folder.path() / "new/folder/t.csv"), first.output);
  EXPECT_FALSE(fs::exists(folder.path() / "new/folder/t.csv.part"));
}

TEST(Simulate, JsonSaysWhatWasDone) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  const ProgramResult outcome =
      run_taut({"simulate", "scene.toml", "--json", "--step", "0.002", "--set", "as_printed=true"},
               folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("method"), "impulse");
  EXPECT_EQ(json.at("settings").at("step"), 0.002);
  EXPECT_EQ(json.at("settings").at("as_printed"), true);
  EXPECT_EQ(json.at("frames"), 5);
  EXPECT_EQ(json.at("steps"), 40);  // 4 intervals of 20 ms
  EXPECT_GT(json.at("stepping_ms_per_second"), 0);
  EXPECT_GE(json.at("stretch_max"), 0);
  EXPECT_TRUE(json.at("energy_drift").is_null()) << "the hand does work";
}

TEST(Simulate, SweepsAKeyOfTheScene) {
  const Folder folder;
  folder.write("swing.toml", kShortSwing);
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"simulate", "swing.toml", "--no-estimate", "-q"});
    return run_taut(arguments, folder.path());
  };
  const ProgramResult swept =
      run({"--sweep", "connectors.rope.length=0.1:0.3:3", "--csv", "lengths", "--json"});
  ASSERT_EQ(swept.code, 0) << swept.messages;
  const nlohmann::json list = nlohmann::json::parse(swept.output);
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[1]["swept"], (nlohmann::json{{"key", "connectors.rope.length"}, {"value", 0.2}}));
  EXPECT_NE(list[0]["state_hash"], list[1]["state_hash"]);
  for (const char* value : {"0.1", "0.2", "0.3"}) {
    const auto file = "lengths/connectors.rope.length=" + std::string(value) + ".csv";
    const ProgramResult alone = run({"--set", "connectors.rope.length=" + std::string(value)});
    EXPECT_EQ(read_file(folder.path() / file), alone.output) << value;
  }
  const ProgramResult whole = run({"--sweep", "connectors.rope.particles=3:5:3", "--json"});
  EXPECT_EQ(whole.code, 0) << whole.messages;

  const auto says = [&](const char* sweep, const char* message) {
    const ProgramResult outcome = run({"--sweep", sweep, "--json"});
    EXPECT_EQ(outcome.code, 2) << sweep;
    EXPECT_NE(outcome.messages.find(message), std::string::npos) << outcome.messages;
  };
  for (const char* wrong : {"length", "=1:2:3", "a=1:2", "a=1:2:0", "a=1:2:1.5", "a=1:2:3:4",
                            "a=x:2:3", "a=1:2:1e9", "a=nan:1:2", "a=:1:2"})
    says(wrong, "expected KEY=FROM:UNTIL:COUNT");
  EXPECT_EQ(run({"--sweep", "duration=0.1:0.2:2"}).code, 2);  // nowhere to write
  EXPECT_EQ(run({"--sweep", "duration=0.1:0.2:2", "--csv", "a.csv"}).code, 2);
  EXPECT_EQ(run({"--sweep", "duration=0.1:0.2:2", "--json", "--forces", "a.csv"}).code, 2);
}

TEST(Simulate, JsonSaysHowConnectorsThatTouchWind) {
  const Folder folder;
  folder.write("scene.toml", R"(duration = 0.1
fps = 50
[connectors.low]
length = 1.0
mass = 0.1
particles = 6
radius = 0.01
from = { fixed = [-0.5, 0, 0] }
to = { free = true }
start = { direction = [1, 0, 0] }
touches_itself = true
[connectors.high]
length = 1.0
mass = 0.1
particles = 6
radius = 0.01
from = { free = true }
to = { free = true }
start = { points = [[0, 0.03, -0.5], [0, 0.03, 0.6]] }
[touching.both]
connectors = ["low", "high"]
)");
  const ProgramResult outcome = run_taut({"simulate", "scene.toml", "--json"}, folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_LT(json.at("penetration_max_m"), 1e-6);
  const auto& windings = json.at("windings");
  ASSERT_EQ(windings.size(), 2u);
  EXPECT_EQ(windings[0].at("connector"), "low");
  EXPECT_NEAR(windings[0].at("writhe"), 0, 1e-6);
  EXPECT_EQ(windings[1].at("other_connector"), "high");
  EXPECT_EQ(windings[1].at("linking_number"), windings[1].at("linking_number_at_start"));
}

// Mass moves to where a connector is cut, and with it potential energy, which is no error.
TEST(Simulate, ACutChangesEnergyThatIsNoDrift) {
  const Folder folder;
  folder.write("scene.toml", R"(duration = 0.5
fps = 50
[method]
name = "direct"
tolerance = 1e-9
[connectors.rope]
length = 4.5e-6
mass = 1.1
particles = 3
from = { fixed = [0.3, 1.0, 0.2] }
to = { free = true }
start = { direction = [1.0, 0.3, 0.2] }
[[cuts]]
connector = "rope"
at = 2e-6
t = 0.2
[[cuts]]
connector = "rope"
at = 3.3e-6
t = 0.31
)");
  const ProgramResult outcome = run_taut({"simulate", "scene.toml", "--json"}, folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_LT(nlohmann::json::parse(outcome.output).at("energy_drift"), 1e-4);
}

/// The fields of the last column, without its name.
std::vector<std::string> last_column(const std::string& csv) {
  std::vector<std::string> fields;
  for (const std::string& row : lines(csv)) fields.push_back(row.substr(row.rfind(',') + 1));
  fields.erase(fields.begin());
  return fields;
}

// A rope that hangs still pulls at its drum with its weight, but for the half of a particle there.
TEST(Simulate, HasTheTensionAtEveryWinch) {
  const Folder folder;
  folder.write("scene.toml", R"(
duration = 0.1
[method]
name = "direct"
[connectors.rope]
length = 1.0
mass = 0.5
particles = 6
from = { fixed = [0, 2, 0], winch = [{ t = 1, paid_out = 0 }, { t = 2, paid_out = 1 }] }
to = { free = true }
)");
  const ProgramResult outcome =
      run_taut({"simulate", "scene.toml", "--no-estimate"}, folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto rows = lines(outcome.output);
  EXPECT_TRUE(rows[0].ends_with("rope.5.z,rope.from.tension")) << rows[0];
  const double weight = 9.81 * 0.5 * (1 - 0.5 / 6);
  EXPECT_NEAR(std::stod(last_column(outcome.output).back()), weight, 1e-12);
}

// A weight at rest on a rope: its links carry what is below.
TEST(Simulate, HasTheForcesInAFileOfTheirOwn) {
  const Folder folder;
  folder.write("scene.toml", R"(schema_version = 1
duration = 0.1
fps = 20
[connectors.rope]
length = 1
mass = 0.3
particles = 3
from = { fixed = [0, 1, 0] }
to = { point_mass = 2 }
start = { direction = [0, -1, 0] }
look = "cord"
[obstacles.floor]
shape = { plane = {} }
position = [0, -5, 0]
)");
  const ProgramResult outcome =
      run_taut({"simulate", "scene.toml", "--forces", "forces.csv", "--json", "-q"}, folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto rows = lines(read_file(folder.path() / "forces.csv"));
  ASSERT_EQ(rows.size(), 1 + 2 * 3u);  // of each frame two links and a hold
  EXPECT_EQ(rows[0], "t,what,of,part,with,with_part,x,y,z,fx,fy,fz,size");
  EXPECT_EQ(rows[1].rfind("0,tension,rope,0-1,,,0,0.75,0,", 0), 0u) << rows[1];
  EXPECT_EQ(rows[3].rfind("0,hold,rope,0,fixed,,0,1,0,", 0), 0u) << rows[3];
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_NEAR(json["largest_tension"]["N"].get<double>(), 2.2 * 9.81, 1e-4);
  EXPECT_NEAR(json["largest_hold_force"]["N"].get<double>(), 2.3 * 9.81, 1e-4);
  EXPECT_EQ(json["largest_hold_force"]["part"], "0");
  EXPECT_TRUE(json["largest_contact_force"].is_null());
  EXPECT_EQ(json["frames_without_forces"], 0);
  EXPECT_EQ(
      run_taut({"simulate", "scene.toml", "scene.toml", "--forces", "forces.csv"}, folder.path())
          .code,
      2);
}

// The same rows as arrays of numpy and as JSON.
TEST(Simulate, HasTheForcesByTheFilesSuffix) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  for (const char* file : {"forces.csv", "forces.json", "forces.npz"}) {
    const ProgramResult outcome =
        run_taut({"simulate", "scene.toml", "--forces", file, "--json", "-q"}, folder.path());
    ASSERT_EQ(outcome.code, 0) << outcome.messages;
  }
  const auto rows = lines(read_file(folder.path() / "forces.csv"));
  const auto json = nlohmann::json::parse(read_file(folder.path() / "forces.json"));
  ASSERT_EQ(json.size(), rows.size() - 1);
  EXPECT_EQ(rows[1].rfind(
                fmt::format("{:.17g},tension,{},{},", json[0]["t"].get<double>(),
                            json[0]["of"].get<std::string>(), json[0]["part"].get<std::string>()),
                0),
            0u)
      << rows[1];
  EXPECT_NE(rows[1].find(fmt::format(",{:.17g}", json[0]["size"].get<double>())),
            std::string::npos);
  const std::string npz = read_file(folder.path() / "forces.npz");
  EXPECT_NE(npz.find(fmt::format("'<f8', 'fortran_order': False, 'shape': ({}, 3)", json.size())),
            std::string::npos);
  EXPECT_NE(npz.find(fmt::format("'<U7', 'fortran_order': False, 'shape': ({},)", json.size())),
            std::string::npos);  // "tension"
}

// A weight on a cord that is released level: it breaks 30 degrees below, where the tension is half
// of that at the bottom. Both parts are there from the first frame.
TEST(Simulate, TellsWhereAConnectorBreaks) {
  const Folder folder;
  folder.write("scene.toml", R"(schema_version = 1
duration = 0.5
[method]
name = "direct"
tolerance = 1e-5
[connectors.cord]
length = 1
mass = 1e-6
particles = 2
breaks_at = 2.943
from = { fixed = [0, 0, 0] }
to = { point_mass = 0.2 }
start = { direction = [1, 0, 0] }
)");
  const ProgramResult outcome = run_taut(
      {"simulate", "scene.toml", "--json", "--csv", "t.csv", "--no-estimate"}, folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto json = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(json["breaks"].size(), 1u);
  const auto& found = json["breaks"][0];
  EXPECT_EQ(found["connector"], "cord");
  EXPECT_EQ(found["link"], 0);
  EXPECT_NEAR(found["tension_N"].get<double>(), 2.943, 1e-4);
  EXPECT_EQ(lines(read_file(folder.path() / "t.csv"))[0],
            "t,cord.0.x,cord.0.y,cord.0.z,cord.1.x,cord.1.y,cord.1.z,cord'.0.x,cord'.0.y,"
            "cord'.0.z,cord'.1.x,cord'.1.y,cord'.1.z");
  const ProgramResult refused = run_taut(
      {"simulate", "scene.toml", "--set", "connectors.cord.from.winch=[{t=0, paid_out=0}]"},
      folder.path());
  EXPECT_EQ(refused.code, 3);
  EXPECT_NE(refused.messages.find("breaks_at"), std::string::npos) << refused.messages;
}

TEST(Simulate, GoesOnFromAState) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  const auto simulate = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"simulate", "scene.toml", "--method", "springs", "--step", "0.0001",
                               "--no-estimate"});
    return run_taut(more, folder.path());
  };
  ASSERT_EQ(simulate({"--csv", "whole.csv"}).code, 0);
  const ProgramResult first =
      simulate({"--until", "0.05", "--save-state", "s", "--csv", "first.csv"});
  ASSERT_EQ(first.code, 0) << first.messages;
  const ProgramResult second = simulate({"--from-state", "s", "--csv", "rest.csv"});
  ASSERT_EQ(second.code, 0) << second.messages;
  const std::string rest = read_file(folder.path() / "rest.csv");
  EXPECT_EQ(read_file(folder.path() / "whole.csv"),
            read_file(folder.path() / "first.csv") + rest.substr(rest.find('\n') + 1));
  EXPECT_EQ(simulate({"--from-state", "s", "--until", "0.01"}).code, 2);
  EXPECT_EQ(simulate({"--until", "100"}).code, 2);
  EXPECT_EQ(simulate({"--from-state", "none"}).code, 3);
  const ProgramResult other = simulate({"--from-state", "s", "--set", "gravity=[0, -9, 0]"});
  EXPECT_EQ(other.code, 3);
  EXPECT_NE(other.messages.find("s: the state is of another scene"), std::string::npos)
      << other.messages;
  folder.write("s", read_file(folder.path() / "s").replace(50, 1, "\xff"));
  const ProgramResult damaged = simulate({"--from-state", "s"});
  EXPECT_EQ(damaged.code, 3);
  EXPECT_NE(damaged.messages.find("the state is damaged"), std::string::npos) << damaged.messages;
}

TEST(Simulate, EstimatesItsOwnError) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  const auto simulate = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"simulate", "scene.toml", "--method", "xpbd", "--json", "--csv",
                               "t.csv", "--step", "0.0005"});
    const ProgramResult outcome = run_taut(more, folder.path());
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    if (more.back() != "--quiet") {
      EXPECT_NE(outcome.messages.find("error estimate: "), std::string::npos) << outcome.messages;
    }
    return nlohmann::json::parse(outcome.output);
  };
  const auto json = simulate({});
  const std::string csv = read_file(folder.path() / "t.csv");
  double largest = 0;
  for (const std::string& field : last_column(csv)) largest = std::max(largest, std::stod(field));
  EXPECT_GT(largest, 0);
  EXPECT_EQ(json.at("error_estimate_m").at("largest"), largest);
  EXPECT_EQ(json.at("error_estimate_m").at("final"), std::stod(last_column(csv).back()));
  EXPECT_TRUE(json.at("error_estimate_reason").is_null());
  EXPECT_TRUE(json.at("predictable_until_s").is_null()) << "errs by less than a millimetre";
  EXPECT_NE(json.at("predictable_until_is").get<std::string>().find("0.001 m"), std::string::npos);
  EXPECT_GT(json.at("estimate_ms_per_second"), 0);

  const auto without = simulate({"--no-estimate", "--quiet"});
  EXPECT_EQ(without.at("state_hash"), json.at("state_hash"));
  EXPECT_FALSE(without.contains("error_estimate_m"));
  const auto bare = lines(read_file(folder.path() / "t.csv")), rows = lines(csv);
  ASSERT_EQ(bare.size(), rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    EXPECT_EQ(bare[k], rows[k].substr(0, rows[k].rfind(',')));
  }
}

TEST(Simulate, SaysWhyThereIsNoEstimate) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  const ProgramResult outcome = run_taut({"simulate", "scene.toml", "--json"}, folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_TRUE(json.at("error_estimate_m").at("largest").is_null());
  EXPECT_TRUE(json.at("error_estimate_m").at("final").is_null());
  EXPECT_EQ(json.at("error_estimate_reason").get<std::string>().rfind("impulse does not ", 0), 0u);
}

TEST(Simulate, TheEstimateIsInfiniteOnceTheCoarserRunDiverges) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  // The lightest particle, 0.01 kg / 3, between two links of 1e4 N/m: stable up to 2 / w = 0.82 ms.
  const ProgramResult outcome =
      run_taut({"simulate", "scene.toml", "--method", "springs", "--step", "0.0005", "--set",
                "damping=0", "--csv", "t.csv", "--json"},
               folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_TRUE(json.at("error_estimate_m").at("final").is_null());
  EXPECT_NE(json.at("error_estimate_reason").get<std::string>().find("springs: diverged"),
            std::string::npos);
  EXPECT_GT(json.at("predictable_until_s"), 0);
  EXPECT_EQ(json.at("foretold_until_s"), json.at("predictable_until_s")) << "its former name";
  EXPECT_EQ(last_column(read_file(folder.path() / "t.csv")).back(), "inf");
}

TEST(Simulate, OutputsThatCannotBeWritten) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  folder.write("file", "kept");
  fs::create_directory(folder.path() / "there");
  for (const char* csv : {"file/t.csv", "there", "/dev/full/t.csv"}) {
    const ProgramResult outcome = run_taut({"simulate", "scene.toml", "--csv", csv}, folder.path());
    EXPECT_EQ(outcome.code, 6) << csv;
    EXPECT_NE(outcome.messages.find(csv), std::string::npos) << outcome.messages;
  }
  EXPECT_EQ(read_file(folder.path() / "file"), "kept");
  const ProgramResult full =
      Child({"sh", "-c", TAUT_PROGRAM " simulate scene.toml > /dev/full"}, folder.path()).wait();
  EXPECT_EQ(full.code, 6);
  EXPECT_NE(full.messages.find("No space left"), std::string::npos);
}

TEST(Simulate, StandardOutputHasNamesOfItsOwn) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  const std::string rows = run_taut({"simulate", "scene.toml"}, folder.path()).output;
  for (const std::string name : {"-", "/dev/stdout"}) {
    const std::vector<std::string> command = {"simulate", "scene.toml", "--csv", name};
    const ProgramResult piped = run_taut(command, folder.path());
    EXPECT_EQ(piped.code, 0) << piped.messages;
    EXPECT_TRUE(piped.output == rows) << name;
    EXPECT_EQ(Child({"sh", "-c", TAUT_PROGRAM " simulate scene.toml --csv " + name + " > t.csv"},
                    folder.path())
                  .wait()
                  .code,
              0);
    EXPECT_TRUE(read_file(folder.path() / "t.csv") == rows) << name;
    EXPECT_TRUE(fs::is_symlink("/dev/stdout"));
    EXPECT_EQ(run_taut({"simulate", "scene.toml", "--json", "--csv", name}, folder.path()).code, 2);
  }
  EXPECT_EQ(run_taut({"simulate", "scene.toml", "--csv", "/dev/null"}, folder.path()).code, 0);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(Simulate, FileSizeLimitLeavesTheOldFile) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  folder.write("t.csv", "old");
  const ProgramResult outcome =
      run_taut({"simulate", "scene.toml", "--csv", "t.csv"}, folder.path(), [] {
        const rlimit limit{1000, 1000};
        setrlimit(RLIMIT_FSIZE, &limit);
      });
  EXPECT_EQ(outcome.code, 6);
  EXPECT_NE(outcome.messages.find("File too large"), std::string::npos) << outcome.messages;
  EXPECT_EQ(read_file(folder.path() / "t.csv"), "old");
  EXPECT_FALSE(fs::exists(folder.path() / "t.csv.part"));
}

TEST(Simulate, SignalsLeaveNothingHalfWritten) {
  for (const auto& [signal, code] : {std::pair(SIGINT, 130), {SIGTERM, 143}, {SIGKILL, 137}}) {
    const Folder folder;
    folder.write("scene.toml", kLong);
    Child child({TAUT_PROGRAM, "simulate", "scene.toml", "--csv", "t.csv"}, folder.path());
    const auto part = folder.path() / "t.csv.part";
    ASSERT_TRUE(child.runs_until([&] { return fs::exists(part) && fs::file_size(part) > 0; }));
    kill(child.id(), signal);
    const ProgramResult stopped = child.wait();
    EXPECT_EQ(stopped.code, code);
    EXPECT_EQ(stopped.messages.find("; simulating: ") != std::string::npos, signal != SIGKILL)
        << stopped.messages;
    EXPECT_FALSE(fs::exists(folder.path() / "t.csv"));
    EXPECT_EQ(fs::exists(part), signal == SIGKILL);
    if (signal != SIGKILL) continue;
    // Files left behind are no obstacle to the next run.
    folder.write("scene.toml", kPushedStick);
    EXPECT_EQ(run_taut({"simulate", "scene.toml", "--csv", "t.csv"}, folder.path()).code, 0);
    EXPECT_EQ(lines(read_file(folder.path() / "t.csv")).size(), 6u);
  }
}

TEST(Simulate, TwoRunsDoNotShareAFile) {
  const Folder folder;
  folder.write("long.toml", kLong);
  folder.write("scene.toml", kPushedStick);
  Child first({TAUT_PROGRAM, "simulate", "long.toml", "--csv", "t.csv"}, folder.path());
  const auto part = folder.path() / "t.csv.part";
  ASSERT_TRUE(first.runs_until([&] { return fs::exists(part) && fs::file_size(part) > 0; }));
  const ProgramResult second =
      run_taut({"simulate", "scene.toml", "--csv", "t.csv"}, folder.path());
  EXPECT_EQ(second.code, 6);
  EXPECT_NE(second.messages.find("another run"), std::string::npos) << second.messages;
}

TEST(Simulate, EveryMethodFollowsTheSwingAtItsOwnSettings) {
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty()) continue;
    const ProgramResult outcome =
        run_taut({"simulate", "scenes/rope_swing.toml", "--method", std::string(method.name)});
    EXPECT_EQ(outcome.code, 0) << method.name << ": " << outcome.messages;
    EXPECT_EQ(lines(outcome.output).size(), 91u) << method.name;
  }
}

TEST(Simulate, DivergenceIsSevenAndLeavesTheRowsUntilThen) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  const ProgramResult outcome = run_taut({"simulate", "scene.toml", "--method", "springs", "--step",
                                          "0.02", "--set", "stiffness=1e9", "--csv", "t.csv"},
                                         folder.path());
  EXPECT_EQ(outcome.code, 7) << outcome.messages;
  EXPECT_NE(outcome.messages.find("springs"), std::string::npos) << outcome.messages;
  EXPECT_NE(outcome.messages.find("cord"), std::string::npos) << outcome.messages;
  const auto rows = lines(read_file(folder.path() / "t.csv"));
  ASSERT_GE(rows.size(), 2u);
  EXPECT_LT(rows.size(), 6u);
  EXPECT_EQ(rows[0].rfind("t,cord.0.x", 0), 0u);
  EXPECT_EQ(rows[1].rfind("0,0,", 0), 0u);
}

}  // namespace
}  // namespace taut
