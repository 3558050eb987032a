// Compiled into every render test, in front of its own sources, so that this test runs first.
#include <osmesa_harness/back_end.h>
#include <osmesa_harness/render_fixture.h>
#include <osmesa_harness/run_tests.h>

#include <iostream>

namespace {

class BackEnd : public osmesa_harness::RenderFixture
{
};

TEST_F(BackEnd, is_the_one_asked_for)
{
  grab();
  const auto back_end = osmesa_harness::currentBackEnd();
  std::cout << "OpenGL " << back_end.version << " on " << back_end.renderer
            << (back_end.osmesa ? " through OSMesa" : "") << ", Qt on " << back_end.platform
            << std::endl;
  EXPECT_EQ(osmesa_harness::backEndComplaint(back_end), "");
}

}  // namespace

int main(int argc, char** argv)
{
  return osmesa_harness::runTests(argc, argv);
}
