# C++ tests of the core: a program for each room, of the sources in its folder below test/core, so that a crash takes
# only its room along. A room of nested ones is one program. bvh_faults_test is a program of its own: all memory of it
# comes from a source that fails.
#
# Where MESH_TOOLS_SANITIZE is set, test/core/base/sanitizer_check.cpp proves that a sanitizer sees what it shall.
# ThreadSanitizer runs what starts threads or is run by several.

#catkin_lint: ignore_once literal_project_name
# add_core_test(<name> <sources>...)
function(add_core_test name)
  set(target ${PROJECT_NAME}_${name})
  catkin_add_gtest(${target} ${ARGN})
  if(TARGET ${target})
    target_link_libraries(${target} ${PROJECT_NAME}_core ${GTEST_MAIN_LIBRARIES})
    target_include_directories(${target} PRIVATE src test)
    target_compile_options(${target} PRIVATE -Wall -Wextra -Werror -ffp-contract=off)
    # The sources of a folder are compiled together: Google Test's headers take half of the time.
    if((CMAKE_UNITY_BUILD OR NOT DEFINED CMAKE_UNITY_BUILD) AND NOT CMAKE_VERSION VERSION_LESS 3.18)
      foreach(source ${ARGN})
        get_filename_component(folder ${source} DIRECTORY)
        string(REPLACE "/" "_" folder ${folder})
        set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${folder})
      endforeach()
      set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
      # Meant for headers; here each file is included.
      target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
    endif()
  endif()
endfunction()

set(tests test/core)
set(faults_test ${tests}/bvh/tree/bvh_faults_test.cpp)
set(device_kernel_test ${tests}/bvh/device/device_kernel_test.cpp)

# Their helpers have names that others of their folder have, too.
set_source_files_properties(
  ${tests}/bvh/selection/region_sphere_test.cpp
  ${tests}/paths/footprint_vertices_test.cpp
  ${tests}/paths/geodesic_test.cpp
  ${tests}/paths/walk_test.cpp
  PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)

if(MESH_TOOLS_SANITIZE)
  add_core_test(sanitizer_check ${tests}/base/sanitizer_check.cpp)
endif()

if(MESH_TOOLS_SANITIZE STREQUAL "thread")
  add_core_test(threads_test
    ${tests}/base/threads_test.cpp
    ${tests}/bvh/tree/back_end_test.cpp
    ${tests}/bvh/tree/bvh_refit_test.cpp
    ${tests}/bvh/closest/closest_batch_test.cpp
    ${tests}/collision/collision_test.cpp
    ${tests}/distance/dijkstra_test.cpp
    ${tests}/distance/wave_front_test.cpp
    ${tests}/reconstruction/signed_distance_field_test.cpp
  )
else()
  file(GLOB_RECURSE forgotten RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS ${tests}/*_test.cpp)
  foreach(room base bvh collision mesh distance paths reconstruction)
    file(GLOB_RECURSE sources RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS ${tests}/${room}/*_test.cpp)
    list(REMOVE_ITEM forgotten ${sources})
    list(REMOVE_ITEM sources ${faults_test} ${device_kernel_test})
    add_core_test(${room}_test ${sources})
  endforeach()
  add_core_test(bvh_faults_test ${faults_test})
  if(forgotten)
    message(FATAL_ERROR "these tests are in no room that ${CMAKE_CURRENT_LIST_FILE} names: ${forgotten}")
  endif()
endif()

# The kernels on a device; without OpenCL that test is skipped. A sanitizer would judge the compiler in the driver.
if(NOT MESH_TOOLS_SANITIZE)
  add_core_test(device_kernel_test ${device_kernel_test})
  find_package(OpenCL)
  find_path(OPENCL_HPP_FOLDER NAMES CL/opencl.hpp CL/cl2.hpp HINTS ${OpenCL_INCLUDE_DIRS})
  if(OpenCL_FOUND AND OPENCL_HPP_FOLDER AND TARGET ${PROJECT_NAME}_device_kernel_test)
    target_link_libraries(${PROJECT_NAME}_device_kernel_test OpenCL::OpenCL)
    target_include_directories(${PROJECT_NAME}_device_kernel_test SYSTEM PRIVATE ${OPENCL_HPP_FOLDER})
    target_compile_definitions(${PROJECT_NAME}_device_kernel_test PRIVATE MESH_MAP_TEST_OPENCL)
  endif()
endif()
