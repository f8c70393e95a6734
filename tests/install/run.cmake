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

# The program comes with its scenes, its manual page and its completions.
if(EXISTS ${WORK}/prefix/bin/occlude)
  foreach(file occlude/assets/castle/castle.glb man/man1/occlude.1 fish/vendor_completions.d/occlude.fish
          bash-completion/completions/occlude zsh/site-functions/_occlude)
    if(NOT EXISTS ${WORK}/prefix/share/${file})
      message(FATAL_ERROR "the install tree has no share/${file}")
    endif()
  endforeach()
  file(READ ${WORK}/prefix/share/man/man1/occlude.1 page)
  foreach(word bench verify algorithms "EXIT STATUS")
    if(NOT page MATCHES "${word}")
      message(FATAL_ERROR "the manual page does not speak of ${word}")
    endif()
  endforeach()
endif()

# A component alone: the C library brings its header and what finds it, and no C++.
if(EXISTS ${WORK}/prefix/include/occlude/c/occlude.h)
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/only_c --component c)
  file(GLOB_RECURSE files RELATIVE ${WORK}/only_c ${WORK}/only_c/*)
  list(FILTER files EXCLUDE REGEX "libocclude\\.so|occlude-c|include/occlude/c/(occlude|occluders)\\.h")
  if(files OR NOT EXISTS ${WORK}/only_c/include/occlude/c/occlude.h)
    message(FATAL_ERROR "the component c brings ${files}")
  endif()
endif()
run(${CMAKE_COMMAND} -S ${SOURCE}/tests/install -B ${WORK}/installed ${common}
    -DCMAKE_PREFIX_PATH=${WORK}/prefix -DOCCLUDE_COMPONENTS=${COMPONENTS})
run(${CMAKE_COMMAND} --build ${WORK}/installed)
run(${WORK}/installed/consumer)
if(EXISTS ${WORK}/installed/consumer_c)
  run(${WORK}/installed/consumer_c)
endif()

# The same consumers by pkg-config alone.
find_program(PKG_CONFIG pkg-config REQUIRED)
file(GLOB_RECURSE pc_file ${WORK}/prefix/*/occlude.pc)
get_filename_component(pc_folder ${pc_file} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
set(modules occlude)
if(COMPONENTS MATCHES "gl")
  list(APPEND modules occlude-gl)
endif()
execute_process(COMMAND ${PKG_CONFIG} --define-variable=prefix=${WORK}/prefix --static --cflags
                        --libs ${modules}
                OUTPUT_VARIABLE words OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(words UNIX_COMMAND "${words} ${FLAGS}")
run(${COMPILER} -std=c++20 ${SOURCE}/tests/install/consumer.cpp -o ${WORK}/by_pkg_config ${words})
run(${WORK}/by_pkg_config)

run(${CMAKE_COMMAND} -S ${SOURCE}/tests/install -B ${WORK}/subdirectory ${common}
    -DOCCLUDE_SOURCE=${SOURCE})
run(${CMAKE_COMMAND} -S ${SOURCE}/tests/install -B ${WORK}/fetched ${common}
    -DOCCLUDE_SOURCE=${SOURCE} -DOCCLUDE_FETCH=ON)
