#include "threads/work_thread.h"

#include <pthread.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <future>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "support/no_threads.h"
#include "threads/background_task.h"

using rviz_mesh_plugin::BackgroundTask;
using rviz_mesh_plugin::Canceled;
using rviz_mesh_plugin::Cancellation;
using rviz_mesh_plugin::WorkThread;

TEST(WorkThread, does_tasks_one_after_the_other_beside_other_threads)
{
  std::vector<int> order;
  std::promise<void> gate;
  std::promise<std::vector<int>> done;
  WorkThread a("a");
  WorkThread b("b");
  a.add([&](const Cancellation&) { gate.get_future().wait(); });
  for (int i = 0; i < 100; ++i) {
    a.add([&, i](const Cancellation&) { order.push_back(i); });
  }
  a.add([&](const Cancellation&) { done.set_value(order); });
  b.add([&](const Cancellation&) { gate.set_value(); });
  const std::vector<int> found = done.get_future().get();
  ASSERT_EQ(found.size(), 100u);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(found[i], i);
  }
}

TEST(WorkThread, waits_for_nothing_when_it_ends_and_drops_what_has_not_begun)
{
  const auto begun = std::make_shared<std::promise<void>>();
  const auto gate = std::make_shared<std::promise<void>>();
  const auto ended = std::make_shared<std::promise<void>>();
  const auto dropped = std::make_shared<int>(0);
  {
    WorkThread thread("a");
    thread.add([=](const Cancellation&) {
      begun->set_value();
      gate->get_future().wait();
      ended->set_value();
    });
    thread.add([=](const Cancellation&) { ++*dropped; });
    begun->get_future().wait();
  }
  EXPECT_EQ(dropped.use_count(), 1) << "the task is gone";
  EXPECT_EQ(*dropped, 0);
  gate->set_value();
  ended->get_future().wait();
}

TEST(WorkThread, says_where_no_thread_can_be_started_and_begins_later)
{
  const auto done = std::make_shared<std::promise<void>>();
  {
    WorkThread thread("a");
    {
      const NoThreads none;
      EXPECT_THROW(thread.add([](const Cancellation&) { ADD_FAILURE() << "it has been refused"; }),
                   std::system_error);
    }
    thread.add([done](const Cancellation&) { done->set_value(); });
    done->get_future().wait();
  }
  WorkThread unused("unused");
  const NoThreads none;
  EXPECT_THROW(unused.add([](const Cancellation&) {}), std::system_error);
}

TEST(WorkThread, is_waited_for_where_that_is_asked_but_not_by_itself)
{
  std::atomic<bool> begun{false}, ended{false};
  WorkThread thread("joined");
  thread.join();  // there is none yet
  thread.add([&](const rviz_mesh_plugin::Cancellation& cancellation) {
    begun = true;
    while (!cancellation.flag()) {
      std::this_thread::yield();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    ended = true;
  });
  while (!begun) {
    std::this_thread::yield();
  }
  thread.join();
  EXPECT_TRUE(ended);

  std::promise<bool> own;
  thread.add([&](const rviz_mesh_plugin::Cancellation& cancellation) {
    thread.join();
    own.set_value(cancellation.flag());
  });
  EXPECT_TRUE(own.get_future().get());
}

TEST(WorkThread, of_all_is_joined_also_where_one_starts_another)
{
  std::atomic<bool> begun{false};
  std::atomic<int> ended{0};
  WorkThread first("first"), second("second");
  const auto wait = [&](const Cancellation& cancellation) {
    while (!cancellation.flag()) {
      std::this_thread::yield();
    }
    ++ended;
  };
  first.add([&](const Cancellation& cancellation) {
    begun = true;
    wait(cancellation);
    second.add(wait);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  });
  while (!begun) {
    std::this_thread::yield();
  }
  WorkThread::joinAll();
  EXPECT_GE(ended, 1);  // the second task may not have begun
  const int then = ended;
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(ended, then);
}

TEST(WorkThread, goes_on_after_a_task_that_throws)
{
  WorkThread thread("throws");
  std::promise<void> later;
  thread.add([](const Cancellation&) { throw std::bad_alloc(); });
  thread.add([&](const Cancellation&) { later.set_value(); });
  later.get_future().wait();
}

TEST(WorkThread, has_its_name)
{
  std::promise<std::string> name;
  WorkThread thread("map layer names");
  thread.add([&](const Cancellation&) {
    std::array<char, 16> found{};
    pthread_getname_np(pthread_self(), found.data(), found.size());
    name.set_value(found.data());
  });
  EXPECT_EQ(name.get_future().get(), "map layer names");
}

TEST(WorkThread, is_cancelled_while_it_waits_and_goes_on_with_what_comes_later)
{
  std::promise<void> begun;
  std::promise<void> canceled;
  std::promise<void> later;
  WorkThread thread("a");
  thread.add([&](const Cancellation& cancellation) {
    begun.set_value();
    try {
      cancellation.wait(-1, 0, -1);
    } catch (const Canceled&) {
      canceled.set_value();
    }
  });
  begun.get_future().wait();
  thread.cancel();
  thread.add([&](const Cancellation&) { later.set_value(); });
  canceled.get_future().wait();
  later.get_future().wait();
}

namespace {

/// Ends the process while threads work that nobody has canceled.
[[noreturn]] void endWithThreads()
{
  ::alarm(60);  // seconds; where it waits for the thread that hangs, it waits forever
  static std::atomic<bool> ended{false};
  std::atexit([] {
    if (!ended) {
      std::abort();
    }
  });
  std::promise<void> working;
  std::promise<void> hanging;
  static auto* const works = new WorkThread("works");
  works->add([&](const Cancellation& cancellation) {
    working.set_value();
    while (!cancellation.flag()) {
      std::this_thread::yield();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    ended = true;
  });
  static auto* const hangs = new WorkThread("hangs", std::chrono::milliseconds(10));
  hangs->add([&](const Cancellation&) {
    hanging.set_value();
    std::promise<void>().get_future().wait_for(std::chrono::hours(1));
  });
  working.get_future().wait();
  hanging.get_future().wait();
  std::exit(0);
}

}  // namespace

TEST(WorkThread, is_cancelled_and_joined_at_the_end_of_the_process_unless_it_hangs)
{
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(endWithThreads(), testing::ExitedWithCode(0), "");
}

TEST(BackgroundTask, brings_a_result_or_says_why_there_is_none)
{
  BackgroundTask<int> task("a");
  const auto outcome = [&] {
    auto taken = task.take();
    while (!taken) {
      std::this_thread::yield();
      taken = task.take();
    }
    return *taken;
  };
  EXPECT_FALSE(task.take());
  task.start([](const Cancellation&) { return 7; });
  EXPECT_TRUE(task.isRunning());
  EXPECT_EQ(outcome().result, 7);
  EXPECT_FALSE(task.isRunning());
  task.start([](const Cancellation&) -> int { throw std::runtime_error("no"); });
  EXPECT_EQ(outcome().error, "no");
  task.start([](const Cancellation&) -> int { throw std::bad_alloc(); });
  EXPECT_EQ(outcome().error, "there is not enough memory");
}

TEST(BackgroundTask, that_is_dropped_is_cancelled_and_its_outcome_lost)
{
  BackgroundTask<int> task("a");
  std::promise<void> begun;
  std::promise<void> canceled;
  task.start([&](const Cancellation& cancellation) {
    begun.set_value();
    while (!cancellation.flag()) {
      std::this_thread::yield();
    }
    canceled.set_value();
    return 1;
  });
  begun.get_future().wait();
  task.drop();
  EXPECT_FALSE(task.isRunning());
  canceled.get_future().wait();
  EXPECT_FALSE(task.take());
}
