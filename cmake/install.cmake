# What `cmake --install` puts where, so that find_package(occlude CONFIG) gives occlude::occlude and,
# where they were built, occlude::gl, occlude::c, occlude::conformance and the adapters occlude::osg
# and occlude::vtk; and the program with its scenes, manual page and completions. Each is an install
# component: occlude, gl, c, conformance, osg, vtk and program.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(OCCLUDE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/occlude)

# A library as a component of the CMake package: NAMESPACE occlude::, targets file FILE.
function(occlude_install_library target component file)
  install(TARGETS ${target} EXPORT ${file}
          LIBRARY COMPONENT ${component} ARCHIVE COMPONENT ${component}
          FILE_SET HEADERS COMPONENT ${component})
  install(EXPORT ${file} NAMESPACE occlude:: DESTINATION ${OCCLUDE_PACKAGE_DIR}
          COMPONENT ${component})
endfunction()

occlude_install_library(occlude occlude occlude-targets)
foreach(component gl c conformance osg vtk)
  if(TARGET occlude_${component})
    set_target_properties(occlude_${component} PROPERTIES EXPORT_NAME ${component})
    occlude_install_library(occlude_${component} ${component} occlude-${component}-targets)
  endif()
endforeach()

if(TARGET occlude_program)
  install(TARGETS occlude_program RUNTIME COMPONENT program)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/assets/bunny ${PROJECT_SOURCE_DIR}/assets/castle
          DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/occlude/assets COMPONENT program)
  if(TARGET occlude_command_line_files)
    set(OCCLUDE_SHELL_FILES ${PROJECT_BINARY_DIR}/command_line_files)
    install(FILES ${OCCLUDE_SHELL_FILES}/occlude.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1
            COMPONENT program)
    install(FILES ${OCCLUDE_SHELL_FILES}/occlude.bash RENAME occlude COMPONENT program
            DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions)
    install(FILES ${OCCLUDE_SHELL_FILES}/_occlude COMPONENT program
            DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/zsh/site-functions)
    install(FILES ${OCCLUDE_SHELL_FILES}/occlude.fish COMPONENT program
            DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/fish/vendor_completions.d)
  endif()
endif()

configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/occlude-config.cmake.in
  ${PROJECT_BINARY_DIR}/occlude-config.cmake
  INSTALL_DESTINATION ${OCCLUDE_PACKAGE_DIR})
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/occlude-config-version.cmake COMPATIBILITY SameMinorVersion)
# ... and what pkg-config tells: occlude, occlude-gl and occlude-c.
set(OCCLUDE_PC_FILES occlude)
set(OCCLUDE_PC_REQUIRES "")
set(OCCLUDE_PC_LIBS "")
if(OCCLUDE_THREADS)
  list(APPEND OCCLUDE_PC_REQUIRES tbb)
  string(APPEND OCCLUDE_PC_LIBS " -ltbb")
endif()
if(OCCLUDE_SIMD)
  list(APPEND OCCLUDE_PC_REQUIRES libhwy)
  string(APPEND OCCLUDE_PC_LIBS " -lhwy")
endif()
list(JOIN OCCLUDE_PC_REQUIRES ", " OCCLUDE_PC_REQUIRES)
if(TARGET occlude_gl)
  list(APPEND OCCLUDE_PC_FILES occlude-gl)
endif()
if(TARGET occlude_c)
  list(APPEND OCCLUDE_PC_FILES occlude-c)
endif()
foreach(name IN LISTS OCCLUDE_PC_FILES)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  string(REGEX REPLACE "^occlude-" "" component ${name})
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
          COMPONENT ${component})
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/occlude-config.cmake
              ${PROJECT_BINARY_DIR}/occlude-config-version.cmake
        DESTINATION ${OCCLUDE_PACKAGE_DIR} COMPONENT occlude)
