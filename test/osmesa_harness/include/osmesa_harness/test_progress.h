#pragma once

namespace osmesa_harness {

/// From now on each test that begins or ends is told in the file that OSMESA_HARNESS_PROGRESS names
/// (where it is set), at once and in one line, as an element of JUnit's XML: `<begun .../>`, and
/// `<testcase ...>`. Google Test itself writes its results when all is over, which a crash
/// prevents.
void tellProgress();

}  // namespace osmesa_harness
