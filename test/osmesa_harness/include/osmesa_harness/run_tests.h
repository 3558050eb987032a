#pragma once

namespace osmesa_harness {

/// The main() of a render test: Google Test, ROS (anonymous node), the one QApplication, RViz
/// without anti-aliasing. Returns the exit code. Fails at once where no ROS master answers.
int runTests(int argc, char** argv);

}  // namespace osmesa_harness
