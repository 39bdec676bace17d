# `cmake --install`: what reads and writes packs, as bakelight::pack for find_package(bakelight), and the recipes beside
# the tools (cmake/Targets.cmake).
include(CMakePackageConfigHelpers)

set_target_properties(bakelight_formats_pack PROPERTIES EXPORT_NAME pack)
set_target_properties(bakelight_formats PROPERTIES EXPORT_NAME formats)
target_include_directories(bakelight_formats INTERFACE $<INSTALL_INTERFACE:include/bakelight>)
target_compile_features(bakelight_formats INTERFACE cxx_std_20)
install(TARGETS bakelight_formats bakelight_formats_pack EXPORT bakelight)
install(EXPORT bakelight NAMESPACE bakelight:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/bakelight
  FILE bakelight-targets.cmake)

# pack.h, and all that it includes.
foreach(header pack pack_contents pack_part pack_image fields field_list json encoded_table shared_bytes file triangle_mesh
               words error)
  install(FILES ${CMAKE_SOURCE_DIR}/formats/${header}.h DESTINATION include/bakelight/formats)
endforeach()

configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/bakelight-config.cmake.in
  ${CMAKE_BINARY_DIR}/bakelight-config.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/bakelight)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/bakelight-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/bakelight-config.cmake ${CMAKE_BINARY_DIR}/bakelight-config-version.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/bakelight)
if(BAKELIGHT_TOOLS)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/configs/recipes/ DESTINATION share/bakelight/recipes)
endif()
