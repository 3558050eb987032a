#pragma once

#include <string>
#include <vector>

#include "spatial/opencl.h"
#include "spatial/opencl_device.h"
#include "spatial/program_cache.h"

namespace rviz_mesh_plugin {

/// The devices of all platforms that can compile and share this machine's byte order. A platform
/// that fails is passed.
std::vector<cl::Device> listDevices();

DeviceInfo describe(const cl::Device& device);

/// One line: which call failed, and with what.
std::string describe(const cl::Error& error);

/// A device with a program built for it. Threads may share it, but for kernels: each call makes its
/// own.
struct OpenClProgram
{
  DeviceInfo info;
  cl::Device device;
  cl::Context context;
  cl::CommandQueue queue;
  cl::Program program;
  std::string key;             ///< in the cache
  bool from_cache = false;     ///< nothing was compiled
  std::size_t max_buffer = 0;  ///< bytes that a buffer has at most
  std::size_t memory = 0;      ///< bytes of the device
  std::size_t max_work_group = 1;
};

/// Loads the program from the cache, or compiles it where that has none, or none that the driver
/// takes. Throws cl::Error; where the compiler refuses, a cl::BuildError with its log.
OpenClProgram buildProgram(const cl::Device& device, const std::string& source,
                           const std::string& options, const ProgramCache& cache);

/// Keeps a compiled program for the next start. Best after its first launch: some drivers compile
/// parts of it only then. Returns whether it is kept.
bool keepProgram(const OpenClProgram& program, const ProgramCache& cache);

}  // namespace rviz_mesh_plugin
