# mesh_msgs_add_pytest(<file or folder below the package> [TIMEOUT <seconds>])
#
# Registers pytest with catkin's run_tests, JUnit XML among the other results. pytest is the system's, as rospy is;
# a warning is an error, except for deprecations inside ROS's own Python.
#catkin_lint: ignore_once literal_project_name
function(mesh_msgs_add_pytest path)
  cmake_parse_arguments(ARG "" "TIMEOUT" "" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  string(REPLACE "/" "." name ${path})
  set(results ${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/pytest-${name}.xml)
  set(command
    "${PYTHON_EXECUTABLE} -m pytest -q -p no:cacheprovider --timeout=${ARG_TIMEOUT} --junit-xml=${results}"
    " -W error -W ignore::DeprecationWarning -W ignore::PendingDeprecationWarning -W ignore::ImportWarning"
    " -o junit_suite_name=${PROJECT_NAME} ${CMAKE_CURRENT_SOURCE_DIR}/${path}")
  string(CONCAT command ${command})
  catkin_run_tests_target("pytest" ${name} "pytest-${name}.xml"
    COMMAND "${command}" WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
endfunction()

# mesh_msgs_add_tests()
#
# Registers all tests of a package laid out as ours are: test/test_*.py for pytest, test/*.test for rostest.
#catkin_lint: ignore_once literal_project_name
function(mesh_msgs_add_tests)
  file(GLOB pytests RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS test/test_*.py)
  foreach(test ${pytests})
    mesh_msgs_add_pytest(${test})
  endforeach()
  file(GLOB rostests RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS test/*.test)
  foreach(test ${rostests})
    add_rostest(${test})
  endforeach()
endfunction()
