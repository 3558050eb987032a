# osmesa_harness_add_render_test(<target> [SOURCES] <files> [LIBRARIES <libraries>] [DEPENDS <targets>]
#                                [ENV <NAME=VALUE>...] [TIMEOUT <seconds>] [BACK_ENDS <back ends>])
#
# Builds a Google Test program with the fixture of <osmesa_harness/render_fixture.h> and runs it on each
# back end: by default as <target>_osmesa without any X server. With BACK_ENDS osmesa xvfb it runs as <target>_xvfb,
# too, on a private Xvfb drawn by Mesa's own GLX: for tests that pictures decide, which a fault of OSMesa could hide.
# (The third is osmesa_x: on Xvfb, but drawn by OSMesa.)
# Each run has a private ROS master, a time limit (600 s, against hangs), JUnit XML and a folder of pictures of its own:
#   <test results>/<project>/render-<target>_<back end>.xml and .../pictures/<target>_<back end>/
# The later runs compare the pictures of sameOnAllBackEnds() with those of the first.
# main() and a first test, which asserts that the right back end draws, are added to the sources.
# DEPENDS: targets to be built before, as a plugin that RViz loads.
# Where OSMESA_HARNESS_LINK is on, the program has the shim linked, so that nothing is preloaded, as sanitizers
# want it; it then runs on OSMesa alone, and may take three times as long.
#catkin_lint: ignore_once literal_project_name
function(osmesa_harness_add_render_test target)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;LIBRARIES;DEPENDS;ENV;BACK_ENDS" ${ARGN})
  if(NOT ARG_SOURCES AND NOT ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "osmesa_harness_add_render_test(${target}): no source files given")
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600)
  endif()
  if(NOT ARG_BACK_ENDS)
    set(ARG_BACK_ENDS osmesa)
  endif()
  if(OSMESA_HARNESS_LINK)
    list(REMOVE_ITEM ARG_BACK_ENDS xvfb)
    math(EXPR ARG_TIMEOUT "3 * ${ARG_TIMEOUT}")
  endif()

  # The harness's own source comes first, because tests run in the order of their files.
  catkin_add_executable_with_gtest(${target}
    ${osmesa_harness_MAIN} ${ARG_SOURCES} ${ARG_UNPARSED_ARGUMENTS} EXCLUDE_FROM_ALL)
  if(NOT TARGET ${target})
    message(WARNING "${target} is not built: Google Test was not found")
    return()
  endif()
  find_package(Qt5 REQUIRED COMPONENTS Widgets)
  target_compile_features(${target} PRIVATE cxx_std_17)
  target_include_directories(${target} SYSTEM PRIVATE ${osmesa_harness_INCLUDE_DIRS})
  target_link_libraries(${target} ${osmesa_harness_LIBRARIES} ${GTEST_LIBRARIES} Qt5::Widgets
    ${ARG_LIBRARIES})

  if(OSMESA_HARNESS_LINK)
    # First of all, before the libraries that bring libGL and libX11.
    target_link_options(${target} PRIVATE "LINKER:--no-as-needed" ${osmesa_harness_SHIM}
      ${osmesa_harness_OSMESA} "LINKER:--as-needed")
  endif()

  set(dependencies ${target} ${ARG_DEPENDS})
  if(TARGET osmesa_glx)
    # This workspace builds the harness itself, and with it the library to preload.
    list(APPEND dependencies osmesa_glx)
    add_dependencies(${target} osmesa_glx)
  endif()
  add_dependencies(tests ${dependencies})

  set(reference "")
  foreach(back_end ${ARG_BACK_ENDS})
    _osmesa_harness_add_run()
    if(NOT reference)
      set(reference ${target}_${back_end})
    endif()
  endforeach()
endfunction()

# The run of ${target} on ${back_end}, with what the function above knows; it waits for the run
# ${reference}, where there is one, and compares with its pictures.
#catkin_lint: ignore_once literal_project_name
macro(_osmesa_harness_add_run)
  set(name ${target}_${back_end})
  set(results ${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME})
  get_target_property(folder ${target} RUNTIME_OUTPUT_DIRECTORY)
  set(command "\"${PYTHON_EXECUTABLE}\" \"${osmesa_harness_RENDER_TEST}\" --back-end ${back_end}")
  string(APPEND command " --results \"${results}/render-${name}.xml\" --label ${name}")
  string(APPEND command " --out \"${results}/pictures/${name}\" --timeout ${ARG_TIMEOUT}")
  if(OSMESA_HARNESS_LINK)
    string(APPEND command " --no-preload")
  endif()
  if(reference)
    string(APPEND command " --reference \"${results}/pictures/${reference}\"")
  endif()
  foreach(setting ${ARG_ENV})
    string(APPEND command " --env \"${setting}\"")
  endforeach()
  string(APPEND command " \"${folder}/${target}\"")
  catkin_run_tests_target("render" ${name} "render-${name}.xml"
    COMMAND "${command}" DEPENDENCIES ${dependencies})
  # ctest starts what takes long first
  set_tests_properties(_ctest_${PROJECT_NAME}_render_${name} PROPERTIES COST 200)

  if(reference)
    set(run run_tests_${PROJECT_NAME}_render_)
    add_dependencies(${run}${name} ${run}${reference})
    add_dependencies(_${run}${name} _${run}${reference})
    set_tests_properties(_ctest_${PROJECT_NAME}_render_${name}
      PROPERTIES DEPENDS _ctest_${PROJECT_NAME}_render_${reference})
  endif()
endmacro()
