# `cmake --install` and find_package(treelet).

include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/treelet")

install(TARGETS treelet EXPORT treelet-targets
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT library
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT library
  RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT library
  FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT library)
install(EXPORT treelet-targets
  NAMESPACE treelet:: DESTINATION "${package_dir}" COMPONENT library)

configure_package_config_file(
  "${CMAKE_CURRENT_LIST_DIR}/treelet-config.cmake.in"
  "${PROJECT_BINARY_DIR}/treelet-config.cmake"
  INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file(
  "${PROJECT_BINARY_DIR}/treelet-config-version.cmake"
  COMPATIBILITY SameMinorVersion)  # below 1.0 a minor release may break the interface
install(FILES
  "${PROJECT_BINARY_DIR}/treelet-config.cmake"
  "${PROJECT_BINARY_DIR}/treelet-config-version.cmake"
  DESTINATION "${package_dir}" COMPONENT library)
