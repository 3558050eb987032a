#include "map_server/file_watch.h"

#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

using rviz_mesh_plugin::FileState;
using rviz_mesh_plugin::lookAtFile;
using rviz_mesh_plugin::nameOfFile;
using rviz_mesh_plugin::resolvedPath;
using State = rviz_mesh_plugin::FileState::State;

namespace {

class AFolder : public testing::Test
{
 protected:
  void SetUp() override
  {
    char pattern[] = "/tmp/map_file_test_XXXXXX";
    ASSERT_NE(::mkdtemp(pattern), nullptr);
    folder = pattern;
  }

  void TearDown() override
  {
    ::unlink((folder + "/map.h5").c_str());
    ::unlink((folder + "/pipe").c_str());
    ::unlink((folder + "/a:=b.h5").c_str());
    ::rmdir(folder.c_str());
  }

  void write(const std::string& name, const std::string& text) const
  {
    std::ofstream(folder + "/" + name) << text;
  }

  std::string folder;
};

}  // namespace

TEST(ResolvedPath, is_absolute)
{
  char here[4096];
  ASSERT_NE(::getcwd(here, sizeof(here)), nullptr);
  const std::string home = std::getenv("HOME") ? std::getenv("HOME") : "";
  EXPECT_EQ(resolvedPath("/a/b.h5"), "/a/b.h5");
  EXPECT_EQ(resolvedPath("  /a/b c.h5 \n"), "/a/b c.h5");
  EXPECT_EQ(resolvedPath("file:///a/b.h5"), "/a/b.h5");
  EXPECT_EQ(resolvedPath("b.h5"), std::string(here) + "/b.h5");
  EXPECT_EQ(resolvedPath("~/b.h5"), home + "/b.h5");
  EXPECT_EQ(resolvedPath("~b.h5"), std::string(here) + "/~b.h5");
  EXPECT_EQ(resolvedPath(" \t"), "");
  EXPECT_EQ(resolvedPath("file://"), "");
}

TEST(NameOfFile, tells_what_needs_no_look)
{
  EXPECT_EQ(nameOfFile(" ").state, State::NOT_CHOSEN);
  EXPECT_EQ(nameOfFile("/path/to/map.h5").state, State::NOT_CHOSEN);
  EXPECT_EQ(nameOfFile("/a:=b.h5").state, State::BAD_NAME);
  EXPECT_EQ(nameOfFile(std::string("/a\0b.h5", 8)).state, State::BAD_NAME);
  EXPECT_EQ(nameOfFile("/dev/null").state, State::UNKNOWN);
  EXPECT_EQ(nameOfFile("file:///a/b.h5").path, "/a/b.h5");
}

TEST_F(AFolder, is_looked_at)
{
  EXPECT_EQ(lookAtFile("").state, State::NOT_CHOSEN);
  EXPECT_EQ(lookAtFile("/path/to/map.h5").state, State::NOT_CHOSEN);
  EXPECT_EQ(lookAtFile(folder).state, State::DIRECTORY);
  EXPECT_EQ(lookAtFile(folder + "/map.h5").state, State::MISSING);
  EXPECT_EQ(lookAtFile(folder + "/map.h5/more").state, State::MISSING);
  EXPECT_EQ(lookAtFile("/dev/zero").state, State::NOT_REGULAR);
  ASSERT_EQ(::mkfifo((folder + "/pipe").c_str(), 0600), 0);
  EXPECT_EQ(lookAtFile(folder + "/pipe").state, State::NOT_REGULAR);  // and it does not wait
  write("a:=b.h5", "x");
  EXPECT_EQ(lookAtFile(folder + "/a:=b.h5").state, State::BAD_NAME);
  write("map.h5", "12345");
  const FileState file = lookAtFile(folder + "/map.h5");
  EXPECT_EQ(file.state, State::PRESENT);
  EXPECT_EQ(file.size(), 5u);
  EXPECT_EQ(file.path, folder + "/map.h5");
}

TEST_F(AFolder, tells_changes_of_a_file)
{
  write("map.h5", "12345");
  const FileState before = lookAtFile(folder + "/map.h5");
  EXPECT_EQ(lookAtFile(folder + "/map.h5").stamp, before.stamp);
  write("map.h5", "123456");
  const FileState longer = lookAtFile(folder + "/map.h5");
  EXPECT_NE(longer.stamp, before.stamp);
  write("pipe", "123456");  // another file of the same size
  ASSERT_EQ(std::rename((folder + "/pipe").c_str(), (folder + "/map.h5").c_str()), 0);
  EXPECT_NE(lookAtFile(folder + "/map.h5").stamp, longer.stamp);
}

TEST_F(AFolder, tells_what_may_not_be_read)
{
  if (::geteuid() == 0) {
    GTEST_SKIP() << "the superuser may read everything";
  }
  write("map.h5", "12345");
  ASSERT_EQ(::chmod((folder + "/map.h5").c_str(), 0), 0);
  EXPECT_EQ(lookAtFile(folder + "/map.h5").state, State::UNREADABLE);
}
