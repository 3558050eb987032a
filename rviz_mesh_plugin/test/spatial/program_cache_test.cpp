#include "spatial/program_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <thread>

#include "query_fixture.h"

using query_test::TemporaryFolder;
using rviz_mesh_plugin::ProgramCache;

namespace {

const ProgramCache::Binary BINARY = {1, 2, 0, 255, 7};
const std::string KEY = "device\ndriver\nkernels";

mode_t modeOf(const std::string& path)
{
  struct stat status = {};
  EXPECT_EQ(::lstat(path.c_str(), &status), 0) << path;
  return status.st_mode & 07777;
}

std::string contents(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write(const std::string& path, const std::string& text)
{
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

/// A variable of the environment, which gets its value back for the tests to come.
class Variable
{
 public:
  explicit Variable(const char* name) : name_(name)
  {
    if (const char* const value = std::getenv(name)) {
      value_ = value;
    }
  }
  ~Variable()
  {
    if (value_) {
      ::setenv(name_, value_->c_str(), 1);
    } else {
      ::unsetenv(name_);
    }
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> value_;
};

class ProgramCacheTest : public testing::Test
{
 protected:
  const TemporaryFolder temporary_;
  const std::string folder_ = temporary_.path() + "/a/b";
  const ProgramCache cache_{folder_};
};

}  // namespace

TEST_F(ProgramCacheTest, gives_back_what_it_was_given_to_the_user_alone)
{
  EXPECT_FALSE(cache_.load(KEY));
  ASSERT_TRUE(cache_.store(KEY, BINARY));
  EXPECT_EQ(cache_.load(KEY), BINARY);
  EXPECT_FALSE(cache_.load(KEY + "2"));
  EXPECT_EQ(modeOf(cache_.path(KEY)), 0600u);
  EXPECT_EQ(modeOf(folder_), 0700u);
  EXPECT_EQ(modeOf(temporary_.path() + "/a"), 0700u);
  ASSERT_TRUE(cache_.store(KEY, {9}));
  EXPECT_EQ(cache_.load(KEY), ProgramCache::Binary{9});
  EXPECT_EQ(temporary_.files().size(), 1u) << "nothing else is left";
}

TEST_F(ProgramCacheTest, ignores_a_file_with_any_byte_changed_lost_or_added_and_replaces_it)
{
  ASSERT_TRUE(cache_.store(KEY, BINARY));
  const std::string path = cache_.path(KEY), good = contents(path);
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ (1 << i % 8));
    write(path, bad);
    EXPECT_FALSE(cache_.load(KEY)) << "byte " << i;
    write(path, good.substr(0, i));
    EXPECT_FALSE(cache_.load(KEY)) << "cut at " << i;
  }
  write(path, good + "x");
  EXPECT_FALSE(cache_.load(KEY));
  write(path, good);
  EXPECT_EQ(cache_.load(KEY), BINARY) << "or the test would pass anyway";
  write(path, "");
  ASSERT_TRUE(cache_.store(KEY, BINARY));
  EXPECT_EQ(cache_.load(KEY), BINARY);
}

TEST_F(ProgramCacheTest, ignores_what_others_could_have_written_and_what_is_no_file)
{
  ASSERT_TRUE(cache_.store(KEY, BINARY));
  const std::string path = cache_.path(KEY);
  for (const mode_t mode : {0620u, 0602u, 0666u}) {
    ASSERT_EQ(::chmod(path.c_str(), mode), 0);
    EXPECT_FALSE(cache_.load(KEY)) << mode;
  }
  ASSERT_EQ(::chmod(path.c_str(), 0600), 0);
  if (::geteuid() == 0) {
    ASSERT_EQ(::chown(path.c_str(), 12345, 12345), 0);
    EXPECT_FALSE(cache_.load(KEY)) << "of another user";
    ASSERT_EQ(::chown(path.c_str(), 0, 0), 0);
  }
  ASSERT_EQ(::rename(path.c_str(), (path + "2").c_str()), 0);
  ASSERT_EQ(::symlink((path + "2").c_str(), path.c_str()), 0);
  EXPECT_FALSE(cache_.load(KEY)) << "a link";
  ASSERT_TRUE(cache_.store(KEY, {3})) << "replaces the link";
  EXPECT_EQ(cache_.load(KEY), ProgramCache::Binary{3});
  ASSERT_EQ(::unlink(path.c_str()), 0);
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  EXPECT_FALSE(cache_.load(KEY)) << "a pipe that nobody writes to";
  ASSERT_EQ(::unlink(path.c_str()), 0);
  ASSERT_EQ(::mkdir(path.c_str(), 0700), 0);
  EXPECT_FALSE(cache_.load(KEY));
  EXPECT_FALSE(cache_.store(KEY, BINARY)) << "a folder is in the way";
  EXPECT_EQ(temporary_.files().size(), 1u) << "nothing but the one renamed above";
}

TEST_F(ProgramCacheTest, does_without_a_folder_it_cannot_write)
{
  write(temporary_.path() + "/file", "x");
  for (const std::string& folder :
       {std::string(), temporary_.path() + "/file", temporary_.path() + "/file/below",
        std::string("/proc/mesh_tools"), std::string("/dev/full/x")}) {
    const ProgramCache cache(folder);
    EXPECT_FALSE(cache.store(KEY, BINARY)) << folder;
    EXPECT_FALSE(cache.load(KEY)) << folder;
  }
  EXPECT_FALSE(cache_.store(KEY, {})) << "nothing to keep";
}

TEST_F(ProgramCacheTest, is_whole_at_any_time)
{
  const ProgramCache::Binary a(100000, 'a'), b(100000, 'b');
  ASSERT_TRUE(cache_.store(KEY, a));
  std::thread writers[] = {std::thread([&] {
                             for (int i = 0; i < 30; ++i) {
                               cache_.store(KEY, b);
                             }
                           }),
                           std::thread([&] {
                             for (int i = 0; i < 30; ++i) {
                               cache_.store(KEY, a);
                             }
                           })};
  for (int i = 0; i < 200; ++i) {
    const auto loaded = cache_.load(KEY);
    EXPECT_TRUE(loaded == a || loaded == b);
  }
  for (std::thread& writer : writers) {
    writer.join();
  }
  EXPECT_EQ(temporary_.files().size(), 1u);
}

TEST(ProgramCache, is_where_the_desktop_says)
{
  const Variable home("HOME"), caches("XDG_CACHE_HOME");
  ::setenv("HOME", "/home/somebody", 1);
  ::setenv("XDG_CACHE_HOME", "/caches", 1);
  EXPECT_EQ(ProgramCache::defaultFolder(), "/caches/mesh_tools/opencl");
  for (const char* const unusable : {"", "relative/path"}) {
    ::setenv("XDG_CACHE_HOME", unusable, 1);
    EXPECT_EQ(ProgramCache::defaultFolder(), "/home/somebody/.cache/mesh_tools/opencl");
  }
  ::unsetenv("XDG_CACHE_HOME");
  ::unsetenv("HOME");
  EXPECT_EQ(ProgramCache::defaultFolder(), "");
}
