# The dynamic symbols of LIBRARY are exactly the functions that HEADER declares.
# Arguments: LIBRARY HEADER NM
execute_process(COMMAND ${NM} -D --defined-only --format=posix ${LIBRARY}
                OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" lines "${listing}")
set(shown "")
foreach(line IN LISTS lines)
  string(REGEX REPLACE "[ @].*" "" name "${line}")
  if(NOT name STREQUAL "OCCLUDE_1") # the version that they carry
    list(APPEND shown ${name})
  endif()
endforeach()

file(READ ${HEADER} header)
string(REPLACE ";" " " header "${header}")
string(REGEX MATCHALL "OCCLUDE_C_API[^(]*occlude_[a-z_]+\\(" declarations "${header}")
set(declared "")
foreach(declaration IN LISTS declarations)
  string(REGEX REPLACE ".*[ *](occlude_[a-z_]+)\\($" "\\1" name "${declaration}")
  list(APPEND declared ${name})
endforeach()

list(SORT shown)
list(SORT declared)
list(LENGTH declared count)
if(count LESS 20)
  message(FATAL_ERROR "only ${count} declarations were found in ${HEADER}")
endif()
if(NOT shown STREQUAL declared)
  message(FATAL_ERROR "the library shows\n  ${shown}\nbut its header declares\n  ${declared}")
endif()
message(STATUS "${count} functions, and nothing else")
