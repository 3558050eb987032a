#include "failing_opencl.h"

#include <dlfcn.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <mutex>
#include <thread>

#include "spatial/opencl.h"

namespace failing_opencl {

namespace {

std::atomic<long> calls{0}, fail_at{-1};
std::atomic<bool> all_after{false}, nothing{false}, hold{false};
std::atomic<unsigned long> claimed_buffer{0}, claimed_memory{0};
std::mutex mutex;
std::string first_failed;

bool fails(const char* name)
{
  const long call = calls++;
  const long at = fail_at;
  if (at < 0 || call < at || (call > at && !all_after)) {
    return false;
  }
  const std::lock_guard<std::mutex> lock(mutex);
  if (first_failed.empty()) {
    first_failed = name;
  }
  return true;
}

template <class Function>
Function* next(Function*, const char* name)
{
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

void failAt(long index, bool forever)
{
  const std::lock_guard<std::mutex> lock(mutex);
  first_failed.clear();
  calls = 0;
  all_after = forever;
  fail_at = index;
}

long stop()
{
  fail_at = -1;
  return calls;
}

std::string failed()
{
  const std::lock_guard<std::mutex> lock(mutex);
  return first_failed;
}

void claimMemory(unsigned long max_buffer, unsigned long memory)
{
  claimed_buffer = max_buffer;
  claimed_memory = memory;
}

void answerNothing(bool on)
{
  nothing = on;
}

void holdBuilds(bool on)
{
  hold = on;
}

}  // namespace failing_opencl

using namespace failing_opencl;

#define NEXT(name) next(&name, #name)

// A function that returns its status, and one that returns an object and writes the status.
#define STATUS(name, parameters, arguments, error)           \
  extern "C" CL_API_ENTRY cl_int CL_API_CALL name parameters \
  {                                                          \
    return fails(#name) ? (error) : NEXT(name) arguments;    \
  }
#define OBJECT(type, name, parameters, arguments, error)   \
  extern "C" CL_API_ENTRY type CL_API_CALL name parameters \
  {                                                        \
    if (fails(#name)) {                                    \
      *status = (error);                                   \
      return nullptr;                                      \
    }                                                      \
    return NEXT(name) arguments;                           \
  }

STATUS(clGetPlatformIDs, (cl_uint a, cl_platform_id* b, cl_uint* c), (a, b, c), -1001)
STATUS(clGetPlatformInfo, (cl_platform_id a, cl_platform_info b, size_t c, void* d, size_t* e),
       (a, b, c, d, e), CL_OUT_OF_HOST_MEMORY)
STATUS(clGetDeviceIDs, (cl_platform_id a, cl_device_type b, cl_uint c, cl_device_id* d, cl_uint* e),
       (a, b, c, d, e), CL_DEVICE_NOT_FOUND)
STATUS(clRetainDevice, (cl_device_id a), (a), CL_OUT_OF_HOST_MEMORY)
OBJECT(cl_context, clCreateContext,
       (const cl_context_properties* a, cl_uint b, const cl_device_id* c,
        void(CL_CALLBACK* d)(const char*, const void*, size_t, void*), void* e, cl_int* status),
       (a, b, c, d, e, status), CL_DEVICE_NOT_AVAILABLE)
OBJECT(cl_command_queue, clCreateCommandQueue,
       (cl_context a, cl_device_id b, cl_command_queue_properties c, cl_int* status),
       (a, b, c, status), CL_OUT_OF_RESOURCES)
OBJECT(cl_program, clCreateProgramWithSource,
       (cl_context a, cl_uint b, const char** c, const size_t* d, cl_int* status),
       (a, b, c, d, status), CL_OUT_OF_HOST_MEMORY)
OBJECT(cl_program, clCreateProgramWithBinary,
       (cl_context a, cl_uint b, const cl_device_id* c, const size_t* d, const unsigned char** e,
        cl_int* f, cl_int* status),
       (a, b, c, d, e, f, status), CL_INVALID_BINARY)
STATUS(clGetProgramInfo, (cl_program a, cl_program_info b, size_t c, void* d, size_t* e),
       (a, b, c, d, e), CL_OUT_OF_RESOURCES)
STATUS(clGetProgramBuildInfo,
       (cl_program a, cl_device_id b, cl_program_build_info c, size_t d, void* e, size_t* f),
       (a, b, c, d, e, f), CL_OUT_OF_RESOURCES)
OBJECT(cl_kernel, clCreateKernel, (cl_program a, const char* b, cl_int* status), (a, b, status),
       CL_OUT_OF_RESOURCES)
STATUS(clSetKernelArg, (cl_kernel a, cl_uint b, size_t c, const void* d), (a, b, c, d),
       CL_OUT_OF_RESOURCES)
OBJECT(cl_mem, clCreateBuffer, (cl_context a, cl_mem_flags b, size_t c, void* d, cl_int* status),
       (a, b, c, d, status), CL_MEM_OBJECT_ALLOCATION_FAILURE)
STATUS(clEnqueueWriteBuffer,
       (cl_command_queue a, cl_mem b, cl_bool c, size_t d, size_t e, const void* f, cl_uint g,
        const cl_event* h, cl_event* i),
       (a, b, c, d, e, f, g, h, i), CL_OUT_OF_RESOURCES)
STATUS(clEnqueueNDRangeKernel,
       (cl_command_queue a, cl_kernel b, cl_uint c, const size_t* d, const size_t* e,
        const size_t* f, cl_uint g, const cl_event* h, cl_event* i),
       (a, b, c, d, e, f, g, h, i), CL_MEM_OBJECT_ALLOCATION_FAILURE)
STATUS(clFlush, (cl_command_queue a), (a), CL_INVALID_COMMAND_QUEUE)
STATUS(clRetainEvent, (cl_event a), (a), CL_OUT_OF_RESOURCES)

extern "C" CL_API_ENTRY cl_int CL_API_CALL clBuildProgram(cl_program a, cl_uint b,
                                                          const cl_device_id* c, const char* d,
                                                          void(CL_CALLBACK* e)(cl_program, void*),
                                                          void* f)
{
  while (hold) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return fails("clBuildProgram") ? CL_BUILD_PROGRAM_FAILURE
                                 : NEXT(clBuildProgram)(a, b, c, d, e, f);
}

extern "C" CL_API_ENTRY cl_int CL_API_CALL clGetDeviceInfo(cl_device_id a, cl_device_info b,
                                                           size_t c, void* d, size_t* e)
{
  if (fails("clGetDeviceInfo")) {
    return CL_OUT_OF_HOST_MEMORY;
  }
  const cl_int status = NEXT(clGetDeviceInfo)(a, b, c, d, e);
  const cl_ulong claim = b == CL_DEVICE_MAX_MEM_ALLOC_SIZE ? claimed_buffer.load()
                         : b == CL_DEVICE_GLOBAL_MEM_SIZE  ? claimed_memory.load()
                                                           : 0;
  if (d && claim > 0) {
    std::memcpy(d, &claim, sizeof claim);
  }
  return status;
}

extern "C" CL_API_ENTRY cl_int CL_API_CALL clEnqueueReadBuffer(cl_command_queue a, cl_mem b,
                                                               cl_bool c, size_t d, size_t e,
                                                               void* f, cl_uint g,
                                                               const cl_event* h, cl_event* i)
{
  if (fails("clEnqueueReadBuffer")) {
    return CL_OUT_OF_RESOURCES;
  }
  const cl_int status = NEXT(clEnqueueReadBuffer)(a, b, nothing ? CL_TRUE : c, d, e, f, g, h, i);
  if (nothing) {
    std::memset(f, 0, e);
  }
  return status;
}

extern "C" CL_API_ENTRY cl_int CL_API_CALL clWaitForEvents(cl_uint a, const cl_event* b)
{
  // The commands end before the failure is seen, as those of a device that is lost.
  const cl_int status = NEXT(clWaitForEvents)(a, b);
  return fails("clWaitForEvents") ? CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST : status;
}
