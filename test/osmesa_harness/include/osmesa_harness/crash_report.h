#pragma once

namespace osmesa_harness {

/// From now on SIGSEGV, SIGBUS, SIGILL, SIGFPE and SIGABRT first tell on stderr which of them it
/// is, in which test, and the native stack of the thread that it came from; then they end the
/// process as they would have (with a core file, where one is wanted). What handles one of them
/// already, as a sanitizer does, stays. A frame is PROGRAM(function+offset), as `addr2line -e
/// PROGRAM` wants it.
void reportCrashes();

}  // namespace osmesa_harness
