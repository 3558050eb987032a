# The core with the sanitizers that MESH_TOOLS_SANITIZE names; what links it gets the flags, too.
include(CheckCXXSourceRuns)

if(MESH_TOOLS_SANITIZE STREQUAL "address")
  set(sanitizers address,undefined)
elseif(MESH_TOOLS_SANITIZE STREQUAL "thread")
  set(sanitizers thread)
else()
  message(FATAL_ERROR "MESH_TOOLS_SANITIZE is address, thread or empty, not ${MESH_TOOLS_SANITIZE}")
endif()

set(CMAKE_REQUIRED_FLAGS "-fsanitize=${sanitizers}")
check_cxx_source_runs("#include <vector>
  int main() { return static_cast<int>(std::vector<int>(1).front()); }"
  MESH_TOOLS_RUNS_SANITIZED_${MESH_TOOLS_SANITIZE})
unset(CMAKE_REQUIRED_FLAGS)
if(NOT MESH_TOOLS_RUNS_SANITIZED_${MESH_TOOLS_SANITIZE})
  message(FATAL_ERROR "programs built with -fsanitize=${sanitizers} do not run here")
endif()

target_compile_options(${PROJECT_NAME}_core PUBLIC
  -fsanitize=${sanitizers} -fno-sanitize-recover=all -fno-omit-frame-pointer -O1 -g1 -UNDEBUG)
target_link_libraries(${PROJECT_NAME}_core PUBLIC -fsanitize=${sanitizers})
