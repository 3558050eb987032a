#include "osmesa_harness/run_tests.h"

#include <cstdlib>
#include <iostream>

#include <gtest/gtest.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/node_handle.h>
#include <rviz/ogre_helpers/render_system.h>

#include <QApplication>

#include "osmesa_harness/crash_report.h"
#include "osmesa_harness/render_fixture.h"
#include "osmesa_harness/test_progress.h"

namespace osmesa_harness {

int runTests(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  tellProgress();
  reportCrashes();
  ros::init(argc, argv, "render_test", ros::init_options::AnonymousName);
  if (!ros::master::check()) {
    std::cerr << "no ROS master at " << ros::master::getURI()
              << ": start the test with `rosrun osmesa_harness headless --master`" << std::endl;
    return EXIT_FAILURE;
  }
  QApplication application(argc, argv);
  application.setQuitOnLastWindowClosed(false);
  // Windows of OSMesa have none, and pixels are compared.
  rviz::RenderSystem::disableAntiAliasing();
  ros::NodeHandle keeps_ros_running;
  const int result = RUN_ALL_TESTS();
  RenderFixture::close();  // before Qt goes
  return result;
}

}  // namespace osmesa_harness
