#include <gtest/gtest.h>
#include <unistd.h>

int main(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  alarm(900);  // seconds; a deadlock ends this program and not the whole run
  return RUN_ALL_TESTS();
}
