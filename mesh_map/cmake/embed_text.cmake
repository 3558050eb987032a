# Makes a C++ source that defines a string with the text of a file:
#   cmake -DINPUT=<file> -DOUTPUT=<source> -DHEADER=<its declaration> -DNAMESPACE=<of it> -DNAME=<its name>
#     -P embed_text.cmake
# In pieces, since compilers limit the length of a literal.
set(piece_length 8000)

file(READ "${INPUT}" text)
string(FIND "${text}" ")text\"" end)
if(NOT end EQUAL -1)
  message(FATAL_ERROR "${INPUT} contains the end mark of a literal: )text\"")
endif()
string(LENGTH "${text}" length)
if(length EQUAL 0)
  message(FATAL_ERROR "${INPUT} is empty")
endif()
get_filename_component(file "${INPUT}" NAME)
set(source "// Generated from ${file}\n#include <${HEADER}>\n\nnamespace ${NAMESPACE} {\n\n")
string(APPEND source "const char* const ${NAME} =")
set(begin 0)
while(begin LESS length)
  string(SUBSTRING "${text}" ${begin} ${piece_length} piece)
  string(APPEND source "\n    R\"text(${piece})text\"")
  math(EXPR begin "${begin} + ${piece_length}")
endwhile()
string(APPEND source ";\n\n}  // namespace ${NAMESPACE}\n")
file(WRITE "${OUTPUT}" "${source}")
