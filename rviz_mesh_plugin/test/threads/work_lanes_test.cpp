#include "threads/work_lanes.h"

#include <future>
#include <memory>
#include <system_error>
#include <vector>

#include <gtest/gtest.h>

#include "support/no_threads.h"

using rviz_mesh_plugin::WorkLanes;

TEST(WorkLanes, do_the_tasks_of_a_lane_one_after_the_other_and_lanes_side_by_side)
{
  std::vector<int> order;
  std::promise<void> gate;
  std::promise<std::vector<int>> done;
  WorkLanes lanes;
  lanes.add("a", [&] { gate.get_future().wait(); });
  for (int i = 0; i < 100; ++i) {
    lanes.add("a", [&, i] { order.push_back(i); });
  }
  lanes.add("a", [&] { done.set_value(order); });
  lanes.add("b", [&] { gate.set_value(); });
  const std::vector<int> found = done.get_future().get();
  ASSERT_EQ(found.size(), 100u);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(found[i], i);
  }
}

TEST(WorkLanes, wait_for_nothing_when_they_end_and_drop_what_has_not_begun)
{
  const auto begun = std::make_shared<std::promise<void>>();
  const auto gate = std::make_shared<std::promise<void>>();
  const auto ended = std::make_shared<std::promise<void>>();
  const auto dropped = std::make_shared<int>(0);
  {
    WorkLanes lanes;
    lanes.add("a", [=] {
      begun->set_value();
      gate->get_future().wait();
      ended->set_value();
    });
    lanes.add("a", [=] { ++*dropped; });
    begun->get_future().wait();
  }
  EXPECT_EQ(dropped.use_count(), 1) << "the task is gone";
  EXPECT_EQ(*dropped, 0);
  gate->set_value();
  ended->get_future().wait();
}

TEST(WorkLanes, say_where_no_thread_can_be_started_and_begin_later)
{
  const auto done = std::make_shared<std::promise<void>>();
  {
    WorkLanes lanes;
    {
      const NoThreads none;
      EXPECT_THROW(lanes.add("a", [] { ADD_FAILURE() << "it has been refused"; }),
                   std::system_error);
    }
    lanes.add("a", [done] { done->set_value(); });
    done->get_future().wait();
  }
  WorkLanes unused;
  const NoThreads none;
  EXPECT_THROW(unused.add("a", [] {}), std::system_error);
}
