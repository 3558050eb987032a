#pragma once

#include <string>

/// The OpenCL functions that this program defines before libOpenCL's: they pass calls on, but for
/// those that are to fail.
namespace failing_opencl {

/// From now on the calls are counted, and the one of this index fails, or all from it on.
void failAt(long index, bool forever = false);

/// No call fails. Returns how many were counted.
long stop();

/// Name of the function that failed first since failAt(); empty if none did.
std::string failed();

/// What the device says of its memory, instead of the truth; 0: the truth.
void claimMemory(unsigned long max_buffer, unsigned long memory);

/// Whether the device forgets to write its answers.
void answerNothing(bool on);

/// While on, a build waits.
void holdBuilds(bool on);

}  // namespace failing_opencl
