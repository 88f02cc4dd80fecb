// The array script under Slurm itself: controller and node on the loopback of this machine.
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

// Of the node that is this machine, with its own ports, files and keys.
constexpr const char* kStart = R"(set -e
umask 022
chmod 755 .
d=$PWD
mkdir state spool
head -c 128 /dev/urandom > munge.key
chmod 600 munge.key
munged --force --key-file=$d/munge.key --socket=$d/munge.sock --pid-file=$d/munged.pid \
  --log-file=$d/munged.log --seed-file=$d/munge.seed
cat > slurm.conf <<END
ClusterName=loopback
SlurmctldHost=$(hostname)(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket=$d/munge.sock
SlurmUser=root
SlurmdUser=root
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation=$d/state
SlurmdSpoolDir=$d/spool
SlurmctldPidFile=$d/slurmctld.pid
SlurmdPidFile=$d/slurmd.pid
SlurmctldLogFile=$d/slurmctld.log
SlurmdLogFile=$d/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MailProg=/bin/true
ReturnToService=2
NodeName=$(hostname) NodeAddr=127.0.0.1 CPUs=$(nproc)
PartitionName=all Nodes=ALL Default=YES State=UP
END
export SLURM_CONF=$d/slurm.conf
slurmctld
slurmd
)";

class LongSlurm : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* program : {"slurmctld", "slurmd", "sbatch", "munged"}) {
      if (sh(std::string("command -v ") + program).code != 0) {
        GTEST_SKIP() << program << " is not installed (Debian: slurm-wlm munge)";
      }
    }
    if (geteuid() != 0) GTEST_SKIP() << "a controller and a node of Slurm need root";
    const ProgramResult started = sh(kStart);
    ASSERT_EQ(started.code, 0) << started.messages;
  }
  void TearDown() override {
    for (const char* daemon : {"slurmd", "slurmctld", "munged"}) {
      std::ifstream file(folder_.path() / (std::string(daemon) + ".pid"));
      if (pid_t id = 0; file >> id) kill(id, SIGTERM);
    }
    std::this_thread::sleep_for(std::chrono::seconds(2));
  }
  ProgramResult sh(const std::string& script) const {
    return Child({"sh", "-c", script}, folder_.path()).wait();
  }
  pid_t process_of(const std::string& task) const {
    std::ifstream file(folder_.path() / ("task." + task));
    pid_t id = 0;
    return file >> id ? id : 0;
  }

  Folder folder_;
};

TEST_F(LongSlurm, PartsOfAnArrayThatAreKilledAreDoneAgainAndMerged) {
  const fs::path here = folder_.path();
  folder_.write("swing.toml", swing_scene(1));
  // Says which process a task is, and becomes taut.
  folder_.write("tasked",
                "#!/bin/sh\necho $$ > task.$SLURM_ARRAY_TASK_ID\nexec " TAUT_PROGRAM " \"$@\"\n");
  fs::permissions(here / "tasked", fs::perms::owner_all);
  ASSERT_EQ(run_taut({"render", "swing.toml", "--out", "whole", "-q"}, here).code, 0);

  const ProgramResult queued = sh("SLURM_CONF=$PWD/slurm.conf TAUT=$PWD/tasked " TAUT_SOURCE_DIR
                                  "/render/cluster/slurm.sh 4 render swing.toml --out parts");
  ASSERT_EQ(queued.code, 0) << queued.messages;
  for (const std::string task : {"1", "3"}) {
    const fs::path journal = here / ("parts/parts/frames." + task + "-of-4/journal");
    std::error_code none;
    ASSERT_TRUE(
        comes_true([&] { return fs::exists(journal, none) && fs::file_size(journal, none); }));
    EXPECT_FALSE(fs::exists(journal.parent_path() / "clip.json")) << "it is done already";
    kill(process_of(task), SIGKILL);
  }
  // Slurm lets a task that is queued again wait, some two minutes.
  ASSERT_TRUE(comes_true([&] { return fs::exists(here / "parts/swing.mp4"); }))
      << sh("SLURM_CONF=$PWD/slurm.conf squeue; cat out/slurm/*").output;
  EXPECT_NE(sh("cat out/slurm/*").output.find("queued again"), std::string::npos);
  std::size_t frames = 0;
  for (const auto& entry : fs::directory_iterator(here / "whole/frames")) {
    const fs::path name = entry.path().filename();
    if (name.extension() != ".png") continue;
    ++frames;
    EXPECT_TRUE(read_file(entry.path()) == read_file(here / "parts/frames" / name)) << name;
  }
  EXPECT_EQ(frames, 50u);
  EXPECT_TRUE(read_file(here / "whole/swing.mp4") == read_file(here / "parts/swing.mp4"));
}

}  // namespace
}  // namespace taut
