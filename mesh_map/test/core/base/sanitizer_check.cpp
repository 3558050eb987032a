// Proves that the sanitizers are live, in the tests and in the core: each mistake ends the program.
#include <mesh_map/bvh/tree/bvh.h>

#include <gtest/gtest.h>

#include <climits>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "core/support/test_meshes.h"

namespace {

#ifdef __SANITIZE_ADDRESS__

int readBehind(const std::vector<int>& values)
{
  return values.data()[values.size()];
}

TEST(AddressSanitizer, SeesAReadBehindAnArrayInATest)
{
  volatile int sum = 0;
  EXPECT_EQ(std::vector<int>({7}).front(), 7);
  EXPECT_DEATH(sum = sum + readBehind({1, 2, 3}), "heap-buffer-overflow");
}

TEST(AddressSanitizer, SeesAReadBehindAnArrayInTheCore)
{
  const TestMesh mesh = terrain(2);
  // says that it has one vertex more than it has, to which the last face refers
  const std::vector<float> positions(mesh.positions.begin(), mesh.positions.end() - 3);
  const mesh_map::MeshView lie{{positions.data(), mesh.positions.size()}, mesh.faces};
  EXPECT_NO_THROW(mesh_map::Bvh::build(mesh.view()));
  EXPECT_DEATH(mesh_map::Bvh::build(lie), "heap-buffer-overflow");
}

TEST(AddressSanitizer, SeesMemoryThatIsNeverFreed)
{
  EXPECT_EXIT(
      {
        new int(1);
        std::exit(0);
      },
      testing::ExitedWithCode(23), "detected memory leaks");
}

TEST(UndefinedBehaviorSanitizer, SeesAnOverflow)
{
  volatile int large = INT_MAX;
  EXPECT_DEATH(large = large + 1, "signed integer overflow");
}

#endif  // __SANITIZE_ADDRESS__

#ifdef __SANITIZE_THREAD__

TEST(ThreadSanitizer, SeesARaceInATest)
{
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_DEATH(
      {
        int count = 0;
        std::thread other([&count] { ++count; });
        ++count;
        other.join();
      },
      "data race");
}

TEST(ThreadSanitizer, SeesARaceInTheCore)
{
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  const TestMesh mesh = terrain(20);
  mesh_map::Bvh bvh = mesh_map::Bvh::build(mesh.view());
  EXPECT_DEATH(
      {
        std::thread other([&] { bvh.refit(mesh.view()); });
        bvh.refit(mesh.view());
        other.join();
      },
      "data race");
}

#endif  // __SANITIZE_THREAD__

}  // namespace

// What the sanitizers read at the start of a program.
extern "C" const char* __asan_default_options()
{
  return "detect_leaks=1";
}
extern "C" const char* __lsan_default_options()
{
  return "exitcode=23";
}
extern "C" const char* __tsan_default_options()
{
  return "halt_on_error=1";
}
