# What an installed copy consists of: headers, one library and one package file a component.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/lamella)

install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/lamella DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS lamella EXPORT lamella_core_targets)
install(EXPORT lamella_core_targets FILE lamella-core-targets.cmake NAMESPACE lamella:: DESTINATION ${package_folder})
if(TARGET lamella_io)
  install(TARGETS lamella_io EXPORT lamella_io_targets)
  install(EXPORT lamella_io_targets FILE lamella-io-targets.cmake NAMESPACE lamella:: DESTINATION ${package_folder})
endif()
configure_package_config_file(${CMAKE_CURRENT_SOURCE_DIR}/lamellaConfig.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/lamellaConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/lamellaConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/lamellaConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/lamellaConfigVersion.cmake
  DESTINATION ${package_folder})
