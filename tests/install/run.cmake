# Installs the build tree into a fresh prefix, then configures, builds and runs a consumer of it; and
# configures the same consumer with the source tree as a subdirectory.
# Arguments: SOURCE BUILD WORK GENERATOR COMPILER FLAGS COMPONENTS
file(REMOVE_RECURSE ${WORK})
set(common -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
           -DCMAKE_CXX_FLAGS=${FLAGS})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE}/tests/install -B ${WORK}/installed ${common}
    -DCMAKE_PREFIX_PATH=${WORK}/prefix -DOCCLUDE_COMPONENTS=${COMPONENTS})
run(${CMAKE_COMMAND} --build ${WORK}/installed)
run(${WORK}/installed/consumer)

run(${CMAKE_COMMAND} -S ${SOURCE}/tests/install -B ${WORK}/subdirectory ${common}
    -DOCCLUDE_SOURCE=${SOURCE})
