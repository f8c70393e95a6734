# What `cmake --install` puts where, so that find_package(occlude CONFIG) gives occlude::occlude and,
# where they were built, occlude::gl and occlude::conformance.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(OCCLUDE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/occlude)

install(TARGETS occlude EXPORT occlude-targets FILE_SET HEADERS)
install(EXPORT occlude-targets NAMESPACE occlude:: DESTINATION ${OCCLUDE_PACKAGE_DIR})
if(TARGET occlude_gl)
  set_target_properties(occlude_gl PROPERTIES EXPORT_NAME gl)
  install(TARGETS occlude_gl EXPORT occlude-gl-targets FILE_SET HEADERS)
  install(EXPORT occlude-gl-targets NAMESPACE occlude:: DESTINATION ${OCCLUDE_PACKAGE_DIR})
endif()
if(TARGET occlude_c)
  set_target_properties(occlude_c PROPERTIES EXPORT_NAME c)
  install(TARGETS occlude_c EXPORT occlude-c-targets FILE_SET HEADERS)
  install(EXPORT occlude-c-targets NAMESPACE occlude:: DESTINATION ${OCCLUDE_PACKAGE_DIR})
endif()
if(TARGET occlude_conformance)
  set_target_properties(occlude_conformance PROPERTIES EXPORT_NAME conformance)
  install(TARGETS occlude_conformance EXPORT occlude-conformance-targets FILE_SET HEADERS)
  install(EXPORT occlude-conformance-targets NAMESPACE occlude:: DESTINATION ${OCCLUDE_PACKAGE_DIR})
endif()
if(TARGET occlude_program)
  install(TARGETS occlude_program)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/assets/bunny
          DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/occlude/assets)
endif()

configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/occlude-config.cmake.in
  ${PROJECT_BINARY_DIR}/occlude-config.cmake
  INSTALL_DESTINATION ${OCCLUDE_PACKAGE_DIR})
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/occlude-config-version.cmake COMPATIBILITY SameMinorVersion)
# ... and what pkg-config tells: occlude, occlude-gl and occlude-c.
set(OCCLUDE_PC_FILES occlude)
if(TARGET occlude_gl)
  list(APPEND OCCLUDE_PC_FILES occlude-gl)
endif()
if(TARGET occlude_c)
  list(APPEND OCCLUDE_PC_FILES occlude-c)
endif()
foreach(name IN LISTS OCCLUDE_PC_FILES)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/occlude-config.cmake
              ${PROJECT_BINARY_DIR}/occlude-config-version.cmake
        DESTINATION ${OCCLUDE_PACKAGE_DIR})
