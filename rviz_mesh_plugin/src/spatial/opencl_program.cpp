#include "spatial/opencl_program.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace rviz_mesh_plugin {

namespace {

/// Text of a property, without the zero that some drivers count in.
std::string text(std::string value)
{
  value.erase(std::find(value.begin(), value.end(), '\0'), value.end());
  return value;
}

std::size_t bytes(cl_ulong value)
{
  return static_cast<std::size_t>(
      std::min<cl_ulong>(value, std::numeric_limits<std::size_t>::max()));
}

/// All that the binary of a program depends on.
std::string keyOf(const DeviceInfo& info, const std::string& source, const std::string& options)
{
  std::string key;
  for (const std::string* part : {&info.platform, &info.platform_version, &info.name, &info.driver,
                                  &info.device_version, &options, &source}) {
    key += *part + '\n';
  }
  return key;
}

/// Whether a device compiles the kernels, which are written in OpenCL C 1.2.
bool usable(const cl::Device& device)
{
  const std::string version = device.getInfo<CL_DEVICE_VERSION>();  // "OpenCL 1.2 ..."
  if (version.rfind("OpenCL 1.0", 0) == 0 || version.rfind("OpenCL 1.1", 0) == 0) {
    return false;
  }
  const std::uint16_t one = 1;
  const bool little_endian = *reinterpret_cast<const unsigned char*>(&one) == 1;
  return device.getInfo<CL_DEVICE_AVAILABLE>() && device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>() &&
         (device.getInfo<CL_DEVICE_ENDIAN_LITTLE>() != 0) == little_endian;
}

}  // namespace

std::vector<cl::Device> listDevices()
{
  std::vector<cl::Platform> platforms;
  cl::Platform::get(&platforms);
  std::vector<cl::Device> found;
  for (const cl::Platform& platform : platforms) {
    try {
      std::vector<cl::Device> devices;
      platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
      devices.erase(std::remove_if(devices.begin(), devices.end(),
                                   [](const cl::Device& device) { return !usable(device); }),
                    devices.end());
      found.insert(found.end(), devices.begin(), devices.end());
    } catch (const cl::Error&) {
      continue;  // a platform without devices says so as an error
    }
  }
  return found;
}

DeviceInfo describe(const cl::Device& device)
{
  const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>(), true);
  const cl_device_type type = device.getInfo<CL_DEVICE_TYPE>();
  DeviceInfo info;
  info.type = type & CL_DEVICE_TYPE_GPU   ? DeviceType::GPU
              : type & CL_DEVICE_TYPE_CPU ? DeviceType::CPU
                                          : DeviceType::OTHER;
  info.name = text(device.getInfo<CL_DEVICE_NAME>());
  info.platform = text(platform.getInfo<CL_PLATFORM_NAME>());
  info.driver = text(device.getInfo<CL_DRIVER_VERSION>());
  info.platform_version = text(platform.getInfo<CL_PLATFORM_VERSION>());
  info.device_version = text(device.getInfo<CL_DEVICE_VERSION>());
  return info;
}

std::string describe(const cl::Error& error)
{
  static const std::pair<cl_int, const char*> MEANINGS[] = {
      {CL_DEVICE_NOT_FOUND, "no device"},
      {CL_DEVICE_NOT_AVAILABLE, "the device is not available"},
      {CL_MEM_OBJECT_ALLOCATION_FAILURE, "out of device memory"},
      {CL_OUT_OF_RESOURCES, "out of resources of the device, or it is lost"},
      {CL_OUT_OF_HOST_MEMORY, "out of memory"},
      {CL_BUILD_PROGRAM_FAILURE, "the compiler refuses"},
      {CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST, "what was running broke off"},
      {CL_INVALID_COMMAND_QUEUE, "the device is lost"},
      {CL_INVALID_CONTEXT, "the device is lost"},
      {-1001,  // CL_PLATFORM_NOT_FOUND_KHR, of the ICD loader
       "no platform; Debian's pocl-opencl-icd makes a device of any processor"},
  };
  std::string line =
      std::string(error.what()) + " failed with error " + std::to_string(error.err());
  for (const auto& meaning : MEANINGS) {
    if (meaning.first == error.err()) {
      line += std::string(" (") + meaning.second + ")";
    }
  }
  return line;
}

OpenClProgram buildProgram(const cl::Device& device, const std::string& source,
                           const std::string& options, const ProgramCache& cache)
{
  OpenClProgram built;
  built.device = device;
  built.info = describe(device);
  built.key = keyOf(built.info, source, options);
  built.max_buffer = bytes(device.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>());
  built.memory = bytes(device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>());
  built.max_work_group = device.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>();
  built.context = cl::Context(device);
  built.queue = cl::CommandQueue(built.context, device);
  if (const auto binary = cache.load(built.key)) {
    try {
      built.program = cl::Program(built.context, {device}, cl::Program::Binaries{*binary});
      built.program.build({device}, options.c_str());
      built.from_cache = true;
      return built;
    } catch (const cl::Error&) {
      built.program = cl::Program();  // the driver has reasons of its own: compile again
    }
  }
  built.program = cl::Program(built.context, source);
  built.program.build({device}, options.c_str());
  return built;
}

bool keepProgram(const OpenClProgram& program, const ProgramCache& cache)
{
  try {
    const auto binaries = program.program.getInfo<CL_PROGRAM_BINARIES>();
    return binaries.size() == 1 && cache.store(program.key, binaries[0]);
  } catch (const cl::Error&) {
    return false;
  }
}

}  // namespace rviz_mesh_plugin
