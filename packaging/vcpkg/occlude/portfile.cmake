# An overlay port: it builds the checkout that it lies in.
#   vcpkg install occlude --overlay-ports=packaging/vcpkg
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

vcpkg_check_features(OUT_FEATURE_OPTIONS FEATURE_OPTIONS FEATURES
  threads OCCLUDE_THREADS
  simd OCCLUDE_SIMD
  gl OCCLUDE_GL
  c OCCLUDE_C
  conformance OCCLUDE_CONFORMANCE)

vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS -DOCCLUDE_TOOLS=OFF -DOCCLUDE_TESTS=OFF -DOCCLUDE_EXAMPLES=OFF -DOCCLUDE_WERROR=OFF
          ${FEATURE_OPTIONS})
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/occlude)
vcpkg_fixup_pkgconfig()

file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
