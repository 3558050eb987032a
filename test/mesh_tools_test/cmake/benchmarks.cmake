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

# The C++ side of benchmark/rviz_display.py: RViz itself, in the fixture of render tests.
find_package(osmesa_harness REQUIRED)
find_package(rviz REQUIRED)
find_package(visualization_msgs REQUIRED)
find_package(Qt5 REQUIRED COMPONENTS Widgets)
find_package(GTest)
if(GTest_FOUND OR GTEST_FOUND)
  add_executable(rviz_display_benchmark benchmark/rviz_display.cpp)
  target_compile_definitions(rviz_display_benchmark PRIVATE QT_NO_KEYWORDS)
  target_compile_options(rviz_display_benchmark PRIVATE -Wall -Wextra -Werror)
  target_include_directories(rviz_display_benchmark SYSTEM PRIVATE ${catkin_INCLUDE_DIRS}
    ${osmesa_harness_INCLUDE_DIRS} ${rviz_INCLUDE_DIRS} ${visualization_msgs_INCLUDE_DIRS})
  target_link_libraries(rviz_display_benchmark ${osmesa_harness_LIBRARIES} ${rviz_LIBRARIES}
    ${catkin_LIBRARIES} GTest::GTest Qt5::Widgets)
  add_dependencies(rviz_display_benchmark ${catkin_EXPORTED_TARGETS})
  install(TARGETS rviz_display_benchmark RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  # The C++ sides of benchmark/selection.py and benchmark/endurance.py. The headers of the plugin are its own: they come
  # from its sources.
  find_package(rviz_mesh_plugin REQUIRED)
  foreach(name selection endurance)
    add_executable(${name}_benchmark benchmark/${name}.cpp)
    target_compile_definitions(${name}_benchmark PRIVATE QT_NO_KEYWORDS)
    target_compile_options(${name}_benchmark PRIVATE -Wall -Wextra -Werror)
    #catkin_lint: ignore_once missing_directory external_directory
    target_include_directories(${name}_benchmark SYSTEM PRIVATE ${catkin_INCLUDE_DIRS}
      ${osmesa_harness_INCLUDE_DIRS} ${rviz_INCLUDE_DIRS} ${rviz_mesh_plugin_INCLUDE_DIRS}
      ${rviz_mesh_plugin_SOURCE_PREFIX}/src ${visualization_msgs_INCLUDE_DIRS})
    target_link_libraries(${name}_benchmark ${osmesa_harness_LIBRARIES} ${rviz_LIBRARIES}
      ${rviz_mesh_plugin_LIBRARIES} ${catkin_LIBRARIES} GTest::GTest Qt5::Widgets)
    add_dependencies(${name}_benchmark ${catkin_EXPORTED_TARGETS})
    install(TARGETS ${name}_benchmark RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  endforeach()
endif()

install(TARGETS serialization_roscpp RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
install(DIRECTORY benchmark DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION} USE_SOURCE_PERMISSIONS)
