# The C++ side of benchmark/serialization.py.
add_executable(serialization_roscpp benchmark/serialization_roscpp.cpp)
target_compile_options(serialization_roscpp PRIVATE -Wall -Wextra -Werror)
target_include_directories(serialization_roscpp SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
target_link_libraries(serialization_roscpp ${catkin_LIBRARIES})
add_dependencies(serialization_roscpp ${catkin_EXPORTED_TARGETS})

# The C++ side of benchmark/spatial_index.py, where Embree 3 is there to compare with.
find_path(EMBREE_INCLUDE_DIR embree3/rtcore.h)
find_library(EMBREE_LIBRARY embree3)
if(EMBREE_INCLUDE_DIR AND EMBREE_LIBRARY)
  add_executable(spatial_index_embree benchmark/spatial_index_embree.cpp)
  target_compile_options(spatial_index_embree PRIVATE -Wall -Wextra -Werror)
  target_include_directories(spatial_index_embree
    SYSTEM PRIVATE ${catkin_INCLUDE_DIRS} ${EMBREE_INCLUDE_DIR})
  target_link_libraries(spatial_index_embree ${catkin_LIBRARIES} ${EMBREE_LIBRARY})
  add_dependencies(spatial_index_embree ${catkin_EXPORTED_TARGETS})
  install(TARGETS spatial_index_embree RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endif()

# The C++ sides of benchmark/rviz_display.py, benchmark/selection.py and benchmark/endurance.py: RViz itself, in the fixture
# of render tests. The headers of the plugin are its own: they come from its sources. All three are compiled together:
# what takes the time are the headers of RViz.
find_package(osmesa_harness REQUIRED)
find_package(rviz REQUIRED)
find_package(rviz_mesh_plugin REQUIRED)
find_package(visualization_msgs REQUIRED)
find_package(Qt5 REQUIRED COMPONENTS Widgets)
find_package(GTest)
if(GTest_FOUND OR GTEST_FOUND)
  add_library(rviz_benchmarks OBJECT
    benchmark/endurance.cpp benchmark/rviz_display.cpp benchmark/selection.cpp)
  set_target_properties(rviz_benchmarks PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  target_compile_definitions(rviz_benchmarks PRIVATE QT_NO_KEYWORDS)
  # Subobjects: the warning is meant for headers; here each file is included.
  target_compile_options(rviz_benchmarks PRIVATE -Wall -Wextra -Werror
    $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  #catkin_lint: ignore_once missing_directory external_directory
  target_include_directories(rviz_benchmarks SYSTEM PRIVATE ${catkin_INCLUDE_DIRS}
    ${osmesa_harness_INCLUDE_DIRS} ${rviz_INCLUDE_DIRS} ${rviz_mesh_plugin_INCLUDE_DIRS}
    ${rviz_mesh_plugin_SOURCE_PREFIX}/src ${visualization_msgs_INCLUDE_DIRS})
  target_link_libraries(rviz_benchmarks PRIVATE GTest::GTest Qt5::Widgets)
  add_dependencies(rviz_benchmarks ${catkin_EXPORTED_TARGETS})
  foreach(name display endurance selection)
    set(target ${name}_benchmark)
    if(name STREQUAL "display")
      set(target rviz_display_benchmark)
    endif()
    add_executable(${target} benchmark/rviz_main.cpp $<TARGET_OBJECTS:rviz_benchmarks>)
    target_compile_definitions(${target} PRIVATE BENCHMARK=${name})
    target_link_libraries(${target} ${osmesa_harness_LIBRARIES} ${rviz_LIBRARIES}
      ${rviz_mesh_plugin_LIBRARIES} ${catkin_LIBRARIES} GTest::GTest Qt5::Widgets)
    install(TARGETS ${target} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  endforeach()
endif()

install(TARGETS serialization_roscpp RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
install(DIRECTORY benchmark DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION} USE_SOURCE_PERMISSIONS)
