#include <mesh_map/bvh/closest/bvh_closest.h>
#include <mesh_map/bvh/rays/bvh_rays.h>
#include <mesh_map/bvh/selection/bvh_selection.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <new>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "bvh_checks.h"

using mesh_map::Bvh;
using mesh_map::BvhOptions;

// All memory of this program comes from here: it is counted, and refused when a test wants that.
namespace {

std::atomic<std::int64_t> bytes_in_use{0};
std::atomic<std::int64_t> calls{0}, first_refused{-1}, last_refused{-1};

void* allocate(std::size_t size, std::size_t alignment)
{
  const std::int64_t call = calls++;
  if (first_refused <= call && call <= last_refused) {
    return nullptr;
  }
  void* const memory =
      alignment <= alignof(std::max_align_t)
          ? std::malloc(size)
          : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  bytes_in_use += memory == nullptr ? 0 : static_cast<std::int64_t>(malloc_usable_size(memory));
  return memory;
}

void* allocateOrThrow(std::size_t size, std::size_t alignment)
{
  void* const memory = allocate(size, alignment);
  if (memory == nullptr) {
    throw std::bad_alloc();
  }
  return memory;
}

void release(void* memory) noexcept
{
  if (memory != nullptr) {
    bytes_in_use -= static_cast<std::int64_t>(malloc_usable_size(memory));
    std::free(memory);
  }
}

}  // namespace

void* operator new(std::size_t size)
{
  return allocateOrThrow(size, 1);
}
void* operator new(std::size_t size, std::align_val_t alignment)
{
  return allocateOrThrow(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
  return allocate(size, 1);
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept
{
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept
{
  release(memory);
}
void operator delete(void* memory, std::size_t) noexcept
{
  release(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept
{
  release(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept
{
  release(memory);
}

namespace {

std::size_t threadCount()
{
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("Threads:", 0) == 0) {
      return std::stoul(line.substr(8));
    }
  }
  return 0;
}

/// The number of threads once it is no more than expected, or after a while: the system may count a
/// thread for a moment after it has been joined.
std::size_t settledThreadCount(std::size_t expected)
{
  for (int wait = 0; wait < 5000 && threadCount() > expected; ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return threadCount();
}

/// Something that takes memory and time, and says whether its answer is right.
struct Task
{
  std::string name;
  std::function<bool(const BvhOptions&)> run;
  bool stops = true;  // when told to
};

/// What tasks work on.
class Faults : public testing::Test
{
 protected:
  Faults()
  {
    for (float& value : moved_.positions) {
      value *= 1.5f;
    }
    refitted_.refit(moved_.view());
    for (unsigned i = 0; i < 3000; ++i) {
      const double x = 0.0033 * i, y = 0.0031 * (3000 - i);
      origins_.insert(origins_.end(), {x, y, 5.0});
      directions_.insert(directions_.end(), {0.1, 0.2, -1.0});
    }
  }

  std::vector<Task> tasks()
  {
    const mesh_map::RayBatch rays = {origins_, directions_, {}};
    const mesh_map::SphereRegion ball({5, 5, 0}, 3.0);
    std::vector<Task> result = {
        {"build",
         [this](const BvhOptions& options) {
           return sameTree(Bvh::build(mesh_.view(), options), bvh_);
         }},
        {"refit",
         [this](const BvhOptions& options) {
           Bvh bvh = bvh_;
           try {
             bvh.refit(moved_.view(), options);
           } catch (...) {
             EXPECT_TRUE(sameTree(bvh, bvh_));
             throw;
           }
           return sameTree(bvh, refitted_);
         }},
        {"serialize", [this](const BvhOptions&) { return bvh_.serialize() == bytes_; }, false},
        {"deserialize",
         [this](const BvhOptions&) {
           return sameTree(Bvh::deserialize(bytes_, mesh_.view()), bvh_);
         },
         false},
        {"castRays",
         [this, rays, expected = mesh_map::castRays(bvh_, rays)](const BvhOptions& options) {
           return mesh_map::castRays(bvh_, rays, {}, options).distances == expected.distances;
         }},
        {"raysHitAny",
         [this, rays, expected = mesh_map::raysHitAny(bvh_, rays)](const BvhOptions& options) {
           return mesh_map::raysHitAny(bvh_, rays, {}, options) == expected;
         }},
        {"closestPoints",
         [this, expected = mesh_map::closestPoints(bvh_, origins_)](const BvhOptions& options) {
           return mesh_map::closestPoints(bvh_, origins_, {}, options).distances ==
                  expected.distances;
         }},
        {"selectFaces",
         [this, ball, expected = mesh_map::selectFaces(bvh_, ball)](const BvhOptions&) {
           return mesh_map::selectFaces(bvh_, ball) == expected;
         },
         false},
    };
    return result;
  }

  const TestMesh mesh_ = terrain(66);
  TestMesh moved_ = mesh_;
  const Bvh bvh_ = Bvh::build(mesh_.view());
  Bvh refitted_ = bvh_;
  const std::vector<std::uint8_t> bytes_ = bvh_.serialize();
  std::vector<double> origins_, directions_;
};

}  // namespace

/// Every call for memory is refused once: it alone, and all after it, too.
TEST_F(Faults, NothingIsLeftWhereMemoryEnds)
{
  for (const Task& task : tasks()) {
    for (const unsigned threads : {1u, 3u}) {
      for (const std::int64_t refused_at_a_time : {1, 1 << 30}) {
        BvhOptions options;
        options.threads = threads;
        const std::int64_t bytes_before = bytes_in_use;
        const std::size_t threads_before = threadCount();
        int thrown = 0;
        bool reached = true;
        for (std::int64_t call = 0; reached; ++call) {
          bool right = true;
          calls = 0;
          last_refused = call + refused_at_a_time - 1;
          first_refused = call;
          try {
            right = task.run(options);  // threads may do without a further one
          } catch (const std::bad_alloc&) {
            ++thrown;
          }
          reached = calls > call;
          first_refused = last_refused = -1;
          ASSERT_TRUE(right) << task.name << " without memory at call " << call;
          ASSERT_EQ(bytes_in_use, bytes_before) << task.name << ", call " << call;
          ASSERT_LE(settledThreadCount(threads_before), threads_before)
              << task.name << ", call " << call;
        }
        EXPECT_GT(thrown, 0) << task.name;
      }
    }
  }
}

TEST_F(Faults, NothingIsLeftWhereItIsCancelled)
{
  std::mt19937 random(4);
  const std::size_t threads_before = threadCount();
  for (const Task& task : tasks()) {
    if (!task.stops) {
      continue;
    }
    int stopped = 0;
    const std::int64_t bytes_before = bytes_in_use;
    for (int round = 0; round < 60; ++round) {
      std::atomic<bool> cancel{round == 0};
      BvhOptions options;
      options.threads = 1 + random() % 3;
      options.cancel = &cancel;
      std::thread after_a_while;
      if (round % 2 == 0) {
        const double limit = static_cast<double>(random() % 1000) / 1000.0;
        options.progress = [&cancel, limit](double fraction) { cancel = fraction >= limit; };
      } else {
        const std::chrono::microseconds time(random() % (round < 20 ? 200 : 20000));
        after_a_while = std::thread([&cancel, time]() {
          std::this_thread::sleep_for(time);
          cancel = true;
        });
      }
      bool right = true;
      try {
        right = task.run(options);
      } catch (const mesh_map::Canceled&) {
        ++stopped;
      }
      if (after_a_while.joinable()) {
        after_a_while.join();
      }
      ASSERT_TRUE(right) << task.name;
    }
    EXPECT_EQ(bytes_in_use, bytes_before) << task.name;
    EXPECT_LE(settledThreadCount(threads_before), threads_before) << task.name;
    EXPECT_GT(stopped, 0) << task.name;
  }
}

TEST_F(Faults, WhatProgressThrowsComesOut)
{
  const std::size_t threads_before = threadCount();
  for (const double limit : {0.0, 0.3, 0.7, 1.0}) {
    BvhOptions options;
    options.threads = 3;
    options.progress = [limit](double fraction) {
      if (fraction >= limit) {
        throw std::domain_error("stop here");
      }
    };
    const std::int64_t bytes_before = bytes_in_use;
    EXPECT_THROW(Bvh::build(mesh_.view(), options), std::domain_error);
    EXPECT_EQ(bytes_in_use, bytes_before);
    Bvh bvh = bvh_;
    EXPECT_THROW(bvh.refit(moved_.view(), options), std::domain_error);
    EXPECT_TRUE(sameTree(bvh, bvh_));
    EXPECT_LE(settledThreadCount(threads_before), threads_before);
  }
}
