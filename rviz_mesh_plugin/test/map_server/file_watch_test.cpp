#include "map_server/file_watch.h"

#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>

using rviz_mesh_plugin::FileStamp;
using rviz_mesh_plugin::FileState;
using rviz_mesh_plugin::FileWatch;
using std::chrono::milliseconds;
using State = rviz_mesh_plugin::FileState::State;

namespace {

/// What a watch sees; shared with its threads.
class Disk
{
 public:
  void put(const std::string& path, std::uint64_t size)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    sizes_[path] = size;
  }
  /// Looks there never end, until the gate is opened.
  void hang(const std::string& path, std::shared_future<void> gate)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    gates_[path] = std::move(gate);
  }
  int looks() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return looks_;
  }

  FileState look(const std::string& path)
  {
    std::unique_lock<std::mutex> lock(mutex_);
    ++looks_;
    const auto gate = gates_.find(path);
    if (gate != gates_.end()) {
      const std::shared_future<void> opened = gate->second;
      lock.unlock();
      opened.wait();
      lock.lock();
    }
    FileState file;
    file.path = path;
    const auto size = sizes_.find(path);
    if (size == sizes_.end()) {
      throw std::runtime_error("bad disk");
    }
    file.state = State::PRESENT;
    std::get<2>(file.stamp) = size->second;
    return file;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::uint64_t> sizes_;
  std::map<std::string, std::shared_future<void>> gates_;
  int looks_ = 0;
};

class Watch : public testing::Test
{
 protected:
  /// Starts a look that is due now, and waits until it has ended; whether it has brought an answer.
  bool lookAt(FileWatch::Clock::time_point now)
  {
    const int before = disk->looks();
    EXPECT_FALSE(watch->update(now));
    return before < reached(before + 1) && ended(now);
  }

  /// Whether one that has been started ends with an answer rather than a problem.
  bool ended(FileWatch::Clock::time_point now)
  {
    const std::string before = watch->problem();
    while (!watch->update(now)) {
      if (watch->problem() != before) {
        return false;
      }
      std::this_thread::yield();
    }
    return true;
  }

  int reached(int looks)
  {
    while (disk->looks() < looks) {
      std::this_thread::yield();
    }
    return disk->looks();
  }

  const std::shared_ptr<Disk> disk = std::make_shared<Disk>();
  std::unique_ptr<FileWatch> watch = std::make_unique<FileWatch>(
      [disk = disk](const std::string& path) { return disk->look(path); });
  const FileWatch::Clock::time_point start = FileWatch::Clock::now();
};

}  // namespace

TEST_F(Watch, looks_twice_soon_and_then_every_second)
{
  disk->put("/a.h5", 7);
  EXPECT_FALSE(watch->update(start));
  EXPECT_EQ(watch->file().state, State::NOT_CHOSEN);
  watch->setPath("/a.h5");
  EXPECT_EQ(watch->file().state, State::UNKNOWN);
  EXPECT_EQ(watch->file().path, "/a.h5");
  ASSERT_TRUE(lookAt(start));
  EXPECT_EQ(watch->file().state, State::PRESENT);
  EXPECT_EQ(watch->file().size(), 7u);
  EXPECT_FALSE(watch->settled()) << "somebody may be writing";
  EXPECT_FALSE(watch->update(start + milliseconds(299)));
  ASSERT_TRUE(lookAt(start + milliseconds(300)));
  EXPECT_TRUE(watch->settled());
  EXPECT_FALSE(watch->update(start + milliseconds(1299)));
  EXPECT_EQ(disk->looks(), 2);
  disk->put("/a.h5", 8);
  ASSERT_TRUE(lookAt(start + milliseconds(1300)));
  EXPECT_EQ(watch->file().size(), 8u);
  EXPECT_FALSE(watch->settled());
  ASSERT_TRUE(lookAt(start + milliseconds(2300)));
  EXPECT_TRUE(watch->settled());
  EXPECT_EQ(watch->problem(), "");
}

TEST_F(Watch, does_not_look_where_no_file_can_be)
{
  for (const char* path : {"", "/path/to/map.h5", "/a:=b.h5"}) {
    watch->setPath(path);
    EXPECT_FALSE(watch->update(start));
    EXPECT_FALSE(watch->update(start + milliseconds(5000)));
  }
  EXPECT_EQ(watch->file().state, State::BAD_NAME);
  EXPECT_EQ(disk->looks(), 0);
}

TEST_F(Watch, waits_for_no_look_that_hangs)
{
  std::promise<void> gate;
  const std::shared_future<void> opened = gate.get_future().share();
  disk->put("/share/a.h5", 7);
  disk->put("/b.h5", 9);
  watch->setPath("/share/a.h5");
  ASSERT_TRUE(lookAt(start));
  disk->hang("/share/a.h5", opened);
  EXPECT_FALSE(watch->update(start + milliseconds(300)));
  reached(2);
  EXPECT_FALSE(watch->update(start + milliseconds(3299)));
  EXPECT_EQ(watch->problem(), "");
  EXPECT_FALSE(watch->update(start + milliseconds(3300)));
  EXPECT_NE(watch->problem().find("looking at /share/a.h5 takes long (3 s"), std::string::npos)
      << watch->problem();
  EXPECT_FALSE(watch->update(start + milliseconds(60300)));
  EXPECT_NE(watch->problem().find("(60 s"), std::string::npos) << watch->problem();
  EXPECT_EQ(watch->file().size(), 7u) << "the answer before stands";
  EXPECT_EQ(disk->looks(), 2) << "there is one look at a time";

  // Another file is looked at nevertheless, and then one that hangs is left behind for good.
  watch->setPath("/b.h5");
  EXPECT_EQ(watch->problem(), "");
  ASSERT_TRUE(lookAt(start + milliseconds(60300)));
  EXPECT_EQ(watch->file().size(), 9u);
  watch->setPath("/share/a.h5");
  EXPECT_FALSE(watch->update(start + milliseconds(61300)));
  reached(4);
  EXPECT_EQ(watch->file().state, State::UNKNOWN);
  watch.reset();
  gate.set_value();
}

TEST_F(Watch, goes_on_when_a_look_ends_after_all)
{
  std::promise<void> gate;
  disk->hang("/share/a.h5", gate.get_future().share());
  disk->put("/share/a.h5", 7);
  watch->setPath("/share/a.h5");
  EXPECT_FALSE(watch->update(start));
  EXPECT_FALSE(watch->update(start + milliseconds(4000)));
  EXPECT_NE(watch->problem(), "");
  gate.set_value();
  ASSERT_TRUE(ended(start + milliseconds(4000)));
  EXPECT_EQ(watch->problem(), "");
  EXPECT_EQ(watch->file().size(), 7u);
}

TEST_F(Watch, says_why_a_look_fails_and_tries_again)
{
  watch->setPath("/a.h5");
  EXPECT_FALSE(lookAt(start));
  EXPECT_EQ(watch->problem(), "/a.h5 cannot be looked at: bad disk");
  EXPECT_EQ(watch->file().state, State::UNKNOWN);
  disk->put("/a.h5", 7);
  ASSERT_TRUE(lookAt(start + milliseconds(300)));
  EXPECT_EQ(watch->problem(), "");
  EXPECT_EQ(watch->file().size(), 7u);
}
