# C++ tests of the core: each test/*_test.cpp as it is, and once more with AddressSanitizer and
# UndefinedBehaviorSanitizer in it and in the core. test/threads_test.cpp runs with ThreadSanitizer, too.
# test/sanitizer_check.cpp proves that a sanitizer sees what it shall. Without the sanitizers where
# MESH_MAP_SANITIZE is OFF, or where no program runs with them.
include(CheckCXXSourceRuns)

#catkin_lint: ignore_once global_var_collision
#catkin_lint: ignore_once literal_project_name
option(MESH_MAP_SANITIZE "Build and run the C++ tests of mesh_map with sanitizers, too" ON)

# Whether programs that are built with -fsanitize=<sanitizers> run here.
function(check_sanitizer sanitizers variable)
  set(CMAKE_REQUIRED_FLAGS "-fsanitize=${sanitizers}")
  check_cxx_source_runs("#include <vector>
    int main() { return static_cast<int>(std::vector<int>(1).front()); }" ${variable})
  if(NOT ${variable})
    message(WARNING "the C++ tests of ${PROJECT_NAME} do not run with -fsanitize=${sanitizers} here")
  endif()
endfunction()

# add_core_test(<test/NAME.cpp> <suffix of the target> <library to test>)
function(add_core_test source suffix library)
  get_filename_component(name ${source} NAME_WE)
  set(target ${PROJECT_NAME}_${name}${suffix})
  catkin_add_gtest(${target} ${source})
  if(TARGET ${target})
    target_link_libraries(${target} ${library} ${GTEST_MAIN_LIBRARIES})
    target_include_directories(${target} PRIVATE src)
    target_compile_options(${target} PRIVATE -Wall -Wextra -Werror -ffp-contract=off)
  endif()
endfunction()

# The core with a sanitizer, as a library that only tests link; what links it gets the flags, too.
function(add_sanitized_core target sanitizers)
  get_target_property(sources ${PROJECT_NAME}_core SOURCES)
  add_library(${target} STATIC EXCLUDE_FROM_ALL ${sources})
  # the sources that are generated are made once
  add_dependencies(${target} ${PROJECT_NAME}_core)
  set_target_properties(${target} PROPERTIES ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
  target_compile_options(${target} PRIVATE -Wall -Wextra -Werror -ffp-contract=off)
  target_compile_options(${target} PUBLIC
    -fsanitize=${sanitizers} -fno-sanitize-recover=all -fno-omit-frame-pointer -O1 -g1 -UNDEBUG)
  target_link_libraries(${target} PUBLIC Threads::Threads -fsanitize=${sanitizers})
endfunction()

file(GLOB core_tests CONFIGURE_DEPENDS test/*_test.cpp)
foreach(source ${core_tests})
  add_core_test(${source} "" ${PROJECT_NAME}_core)
endforeach()

# The kernels on a device; without OpenCL that test is skipped.
find_package(OpenCL)
find_path(OPENCL_HPP_FOLDER NAMES CL/opencl.hpp CL/cl2.hpp HINTS ${OpenCL_INCLUDE_DIRS})
if(OpenCL_FOUND AND OPENCL_HPP_FOLDER AND TARGET ${PROJECT_NAME}_device_kernel_test)
  target_link_libraries(${PROJECT_NAME}_device_kernel_test OpenCL::OpenCL)
  target_include_directories(${PROJECT_NAME}_device_kernel_test SYSTEM PRIVATE ${OPENCL_HPP_FOLDER})
  target_compile_definitions(${PROJECT_NAME}_device_kernel_test PRIVATE MESH_MAP_TEST_OPENCL)
endif()

if(MESH_MAP_SANITIZE)
  check_sanitizer(address,undefined MESH_MAP_ADDRESS_SANITIZER)
  check_sanitizer(thread MESH_MAP_THREAD_SANITIZER)
endif()
if(MESH_MAP_SANITIZE AND MESH_MAP_ADDRESS_SANITIZER)
  add_sanitized_core(${PROJECT_NAME}_core_sanitized address,undefined)
  list(FILTER core_tests EXCLUDE REGEX device_kernel_test)  # it would judge the compiler in the driver
  foreach(source ${core_tests} test/sanitizer_check.cpp)
    add_core_test(${source} _sanitized ${PROJECT_NAME}_core_sanitized)
  endforeach()
endif()
if(MESH_MAP_SANITIZE AND MESH_MAP_THREAD_SANITIZER)
  add_sanitized_core(${PROJECT_NAME}_core_thread_sanitized thread)
  foreach(source test/threads_test.cpp test/sanitizer_check.cpp)
    add_core_test(${source} _thread_sanitized ${PROJECT_NAME}_core_thread_sanitized)
  endforeach()
endif()
