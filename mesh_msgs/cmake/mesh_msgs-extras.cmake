# mesh_msgs_add_tests([NATIVE] [GROUPS <path>[,<path>...] ...] [TIMEOUT <seconds a test>])
#
# Registers all tests of a package laid out as ours are, with catkin's run_tests and with ctest:
# test/**/test_*.py as one process of pytest, test/**/*.test as rostests.
# NATIVE, for a package with native code of its own: where pytest-xdist is installed, a worker runs the tests, and a crash
# fails the one test that it happened in; a new worker goes on with the others. It takes 3 ms a test.
# GROUPS, for a package whose tests take so long that one process would keep everybody waiting: each a process of its
# own over these folders and files below test/; what no group names is one process more.
#catkin_lint: ignore_once literal_project_name
function(mesh_msgs_add_tests)
  cmake_parse_arguments(ARG "NATIVE" "TIMEOUT" "GROUPS" ${ARGN})
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "mesh_msgs_add_tests: unknown arguments: ${ARG_UNPARSED_ARGUMENTS}")
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  string(REPLACE "," ";" grouped "${ARG_GROUPS}")
  foreach(group ${ARG_GROUPS})
    string(REPLACE "," ";" paths ${group})
    string(REGEX REPLACE "test_|\\.py" "" name ${group})
    string(REGEX REPLACE "[,/]" "-" name ${name})
    _mesh_msgs_add_pytest(${name} ${paths})
  endforeach()
  file(GLOB_RECURSE pytests CONFIGURE_DEPENDS test/test_*.py)
  if(pytests)
    _mesh_msgs_add_pytest(tests .)
  endif()
  file(GLOB_RECURSE rostests RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS test/*.test)
  foreach(test ${rostests})
    add_rostest(${test})
    string(REPLACE "/" "_" name ${test})
    set_tests_properties(_ctest_${PROJECT_NAME}_rostest_${name} PROPERTIES COST 300)
  endforeach()
endfunction()

# One process of pytest over files and folders below test/, but for those that ${grouped} names apart; each test may
# take ${ARG_TIMEOUT} seconds.
#
# pytest is the system's, as rospy is; a warning is an error, except for deprecations inside ROS's own Python.
# (Not --dist loadfile: after a crash it runs the same test again and again.)
# A test that hangs fails with its stack; where even that is held up, in native code, the stacks are printed.
#catkin_lint: ignore_once literal_project_name
function(_mesh_msgs_add_pytest name)
  set(paths "")
  foreach(path ${ARGN})
    if(NOT EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/test/${path})
      message(FATAL_ERROR "mesh_msgs_add_tests: there is no ${CMAKE_CURRENT_SOURCE_DIR}/test/${path}")
    endif()
    string(APPEND paths " test/${path}")
    foreach(other ${grouped})
      string(FIND "/${other}" "/${path}/" place)
      if(path STREQUAL "." OR place EQUAL 0)
        string(APPEND paths " --ignore=test/${other}")
      endif()
    endforeach()
  endforeach()
  math(EXPR dump "${ARG_TIMEOUT} + 30")
  execute_process(COMMAND ${PYTHON_EXECUTABLE} -c "import xdist" RESULT_VARIABLE without_xdist ERROR_QUIET)
  set(worker "")
  if(ARG_NATIVE AND NOT without_xdist)
    set(worker "-n 1 --dist load --max-worker-restart 20")
  endif()
  set(results ${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/pytest-${name}.xml)
  string(CONCAT command
    "${PYTHON_EXECUTABLE} -m pytest -q -p no:cacheprovider --rootdir=${CMAKE_CURRENT_SOURCE_DIR} ${worker}"
    " --timeout=${ARG_TIMEOUT} -o faulthandler_timeout=${dump} --durations=10 --junit-xml=${results}"
    " -W error -W ignore::DeprecationWarning -W ignore::PendingDeprecationWarning -W ignore::ImportWarning"
    " -o junit_suite_name=${PROJECT_NAME}${paths}")
  catkin_run_tests_target("pytest" ${name} "pytest-${name}.xml"
    COMMAND "${command}" WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
  # what computes most goes first, so that nodes, which mind a busy machine, come when it is quieter
  set_tests_properties(_ctest_${PROJECT_NAME}_pytest_${name} PROPERTIES COST 1000)
endfunction()
