#include "map_server/map_server_process.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <thread>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <QCoreApplication>

using rviz_mesh_plugin::MapServerProcess;
using Lines = std::vector<std::string>;

namespace {

constexpr int WAIT_SECONDS = 30;  // only reached when something is broken

bool isThere(pid_t pid)
{
  return ::kill(pid, 0) == 0;
}

class AProcess : public testing::Test
{
 protected:
  static void SetUpTestSuite()
  {
    static int argc = 1;
    static char name[] = "test";
    static char* argv[] = {name, nullptr};
    static QCoreApplication application(argc, argv);
  }

  static bool waitUntil(const std::function<bool()>& done)
  {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(WAIT_SECONDS);
    while (!done()) {
      if (std::chrono::steady_clock::now() > end) {
        return false;
      }
      QCoreApplication::processEvents(QEventLoop::AllEvents, 10);
      QCoreApplication::sendPostedEvents(nullptr, QEvent::DeferredDelete);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
  }

  void start(const std::string& script, const QStringList& environment = {},
             std::chrono::milliseconds grace = std::chrono::seconds(15))
  {
    const QStringList arguments{"-c", QString::fromStdString(script)};
    process.reset(new MapServerProcess("/bin/sh", arguments, environment, grace));
  }

  /// Starts it and waits for its first line.
  Lines startAndWait(const std::string& script,
                     std::chrono::milliseconds grace = std::chrono::seconds(15))
  {
    start(script, {}, grace);
    EXPECT_TRUE(waitUntil([this] { return !process->lastLines().empty(); }));
    return process->takeLines();
  }

  std::string ending()
  {
    EXPECT_TRUE(waitUntil([this] { return process->ended(); }));
    EXPECT_EQ(process->processId(), 0);
    return process->ending();
  }

  MapServerProcess::Owner process;
};

/// Not a test of its own: what parent_is_killed starts.
class Parent : public AProcess
{
};

}  // namespace

TEST_F(AProcess, tells_its_lines_and_its_end)
{
  start("echo one; echo two >&2; printf '\\033[31m[ERROR] [1.5]: three\\033[0m'; exit 3");
  EXPECT_EQ(ending(), "exit code 3");
  EXPECT_EQ(process->takeLines(), (Lines{"one", "two", "three"}));
  EXPECT_EQ(process->takeLines(), Lines());
  EXPECT_EQ(process->lastLines(), (Lines{"one", "two", "three"}));
  start("kill -9 $$");
  EXPECT_EQ(ending(), "signal 9 (Killed)");
}

TEST_F(AProcess, that_cannot_be_started_says_so)
{
  process.reset(new MapServerProcess("/nowhere/hdf5_map_server", {}, {}));
  EXPECT_NE(ending().find("it cannot be started"), std::string::npos) << process->ending();
}

TEST_F(AProcess, keeps_only_the_newest_of_many_lines)
{
  start(
      "i=0; while [ $i -lt 3000 ]; do i=$((i+1)); echo line $i; done;"
      "head -c 100000 /dev/zero | tr '\\0' x");
  EXPECT_EQ(ending(), "exit code 0");
  EXPECT_LE(process->takeLines().size(), 1000u);
  ASSERT_LE(process->lastLines().size(), 20u);
  for (const std::string& line : process->lastLines()) {
    EXPECT_LE(line.size(), 2000u);
  }
}

TEST_F(AProcess, gets_its_environment_but_no_files_and_no_blocked_signals)
{
  char file[] = "/tmp/map_server_process_test_XXXXXX";
  const int leak = ::mkstemp(file);  // without O_CLOEXEC
  ASSERT_GE(leak, 3);
  sigset_t set, before;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  ::sigprocmask(SIG_BLOCK, &set, &before);
  start("echo $FROM_TEST; grep SigBlk /proc/self/status; ls -l /proc/self/fd", {"FROM_TEST=a = b"});
  ::sigprocmask(SIG_SETMASK, &before, nullptr);
  EXPECT_EQ(ending(), "exit code 0");
  const Lines lines = process->takeLines();
  ASSERT_GE(lines.size(), 5u);
  EXPECT_EQ(lines[0], "a = b");
  EXPECT_EQ(lines[1], "SigBlk:0000000000000000");
  for (const std::string& line : lines) {
    EXPECT_EQ(line.find(file), std::string::npos) << line;
  }
  ::unlink(file);
  ::close(leak);
}

TEST_F(AProcess, is_asked_to_end_and_may_tidy_up)
{
  char file[] = "/tmp/map_server_process_test_XXXXXX";
  ::close(::mkstemp(file));
  startAndWait("trap 'rm " + std::string(file) +
               "; exit 0' TERM; echo there; "
               "while true; do sleep 0.05; done");
  const pid_t pid = process->processId();
  process.reset();
  EXPECT_TRUE(waitUntil([&] { return !isThere(pid); }));
  EXPECT_NE(::access(file, F_OK), 0);
}

TEST_F(AProcess, is_killed_if_it_does_not_end)
{
  startAndWait("trap '' TERM; echo there; while true; do sleep 0.05; done",
               std::chrono::milliseconds(300));
  const pid_t pid = process->processId();
  process.reset();
  EXPECT_TRUE(waitUntil([&] { return !isThere(pid); }));
}

TEST_F(AProcess, ends_at_once_after_its_start)
{
  for (int i = 0; i < 20; ++i) {
    start("sleep 1000");
    const pid_t pid = process->processId();
    process.reset();
    if (pid > 0) {
      EXPECT_TRUE(waitUntil([&] { return !isThere(pid); }));
    }
  }
}

TEST_F(Parent, DISABLED_waits_to_be_killed)
{
  start("exec sleep 1000");
  ASSERT_TRUE(waitUntil([this] { return process->processId() > 0; }));
  std::printf("pid %d\n", static_cast<int>(process->processId()));
  std::fflush(stdout);
  waitUntil([] { return false; });
}

TEST_F(AProcess, ends_with_its_parent)
{
  char self[4096] = {};
  ASSERT_GT(::readlink("/proc/self/exe", self, sizeof(self) - 1), 0);
  process.reset(new MapServerProcess(
      self,
      {"--gtest_filter=Parent.DISABLED_waits_to_be_killed", "--gtest_also_run_disabled_tests"},
      {"GTEST_OUTPUT="}));
  pid_t grandchild = 0;
  const auto found = [&] {
    for (const std::string& line : process->takeLines()) {
      if (line.rfind("pid ", 0) == 0) {
        grandchild = std::atoi(line.c_str() + 4);
      }
    }
    return grandchild != 0;
  };
  ASSERT_TRUE(waitUntil(found));
  ASSERT_TRUE(isThere(grandchild));
  ::kill(process->processId(), SIGKILL);
  EXPECT_TRUE(waitUntil([&] { return !isThere(grandchild); }));
  EXPECT_EQ(ending(), "signal 9 (Killed)");
}
