#!/usr/bin/env bash
# A catkin package of somebody else, built against what is installed: messages, their headers, and libraries.
set -euo pipefail
folder=$(mktemp -d)
mkdir -p "$folder/outside/msg"
cd "$folder/outside"
cat >package.xml <<'XML'
<package format="3">
  <name>outside</name>
  <version>0.0.1</version>
  <description>Uses what is installed.</description>
  <maintainer email="somebody@example.org">somebody</maintainer>
  <license>BSD</license>
  <buildtool_depend>catkin</buildtool_depend>
  <depend>mesh_map</depend>
  <depend>mesh_msgs</depend>
</package>
XML
echo 'mesh_msgs/MeshGeometry mesh' >msg/Seen.msg
cat >CMakeLists.txt <<'CMAKE'
cmake_minimum_required(VERSION 3.16)
project(outside)
set(CMAKE_CXX_STANDARD 17)
find_package(catkin REQUIRED COMPONENTS label_manager mbf_msgs mesh_map mesh_msgs mesh_msgs_conversions mesh_msgs_transform
  mesh_msgs_hdf5 mesh_navigation message_generation roscpp rviz_mesh_plugin)
find_package(osmesa_harness REQUIRED)
foreach(part MAIN RENDER_TEST SHIM OSMESA)
  if(NOT EXISTS "${osmesa_harness_${part}}")
    message(FATAL_ERROR "osmesa_harness_${part} is ${osmesa_harness_${part}}")
  endif()
endforeach()
if(NOT COMMAND osmesa_harness_add_render_test OR NOT COMMAND mesh_msgs_add_tests)
  message(FATAL_ERROR "a function for tests is missing")
endif()
add_message_files(FILES Seen.msg)
generate_messages(DEPENDENCIES mesh_msgs)
catkin_package(CATKIN_DEPENDS mesh_map mesh_msgs)
include_directories(${catkin_INCLUDE_DIRS})
add_executable(look look.cpp)
add_dependencies(look ${outside_EXPORTED_TARGETS})
target_link_libraries(look ${catkin_LIBRARIES})
CMAKE
cat >look.cpp <<'CPP'
#include <label_manager/GetLabelGroups.h>
#include <mbf_msgs/GetPathAction.h>
#include <mesh_map/bvh/rays/bvh_rays.h>
#include <mesh_msgs/TriangleIndices.h>
#include <mesh_msgs_transform/transforms.h>
#include <outside/Seen.h>

#include <iostream>

int main()
{
  outside::Seen seen;
  seen.mesh.vertices.resize(3);
  const std::vector<float> positions{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::vector<std::uint32_t> faces{0, 1, 2};
  const auto bvh = mesh_map::Bvh::build({positions, faces});
  const auto hit = mesh_map::castRay(bvh, {{0.25, 0.25, 2.0}, {0.0, 0.0, -1.0}});
  std::cout << seen.mesh.vertices.size() << " vertices, hit at " << hit.distance << " m\n";
}
CPP
cmake -S . -B build >cmake.log 2>&1 || { cat cmake.log; exit 1; }
cmake --build build >build.log 2>&1 || { cat build.log; exit 1; }
build/devel/lib/outside/look | tee seen.txt
grep -q -x '3 vertices, hit at 2 m' seen.txt
