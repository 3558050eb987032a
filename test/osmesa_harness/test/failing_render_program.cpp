// Fails, or breaks off, as FAIL_BY asks: what render_test makes of it is tested by test_results.py.
#include <osmesa_harness/render_fixture.h>

#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>

extern "C" void crashHere();

namespace {

class Failing : public osmesa_harness::RenderFixture
{
};

std::string failBy()
{
  const char* way = std::getenv("FAIL_BY");
  return way ? way : "";
}

// Written to through a pointer that no compiler knows.
volatile int* volatile nowhere = nullptr;

// Ends the process after Google Test has written its results.
struct EndsBadly
{
  ~EndsBadly()
  {
    if (failBy() == "exit") {
      std::_Exit(3);
    }
  }
} ends_badly;

TEST_F(Failing, does_what_it_is_asked_for)
{
  if (failBy() == "crash") {
    crashHere();
  }
  if (failBy() == "crash_in_a_thread") {
    std::thread(crashHere).join();
  }
  if (failBy() == "abort") {
    std::abort();
  }
  if (failBy() == "hang") {
    spin(600000);
  }
  const osmesa_harness::Image drawn = grab();
  osmesa_harness::Image expected = drawn;
  if (failBy() == "picture") {
    expected.set(7, 5, {255, 0, 0});
  }
  EXPECT_TRUE(osmesa_harness::imagesMatch("empty", drawn, expected));
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("drawn", drawn));
}

}  // namespace

void crashHere()
{
  *nowhere = 1;
}
