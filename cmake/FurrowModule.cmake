# furrow_add_module(NAME SOURCES ... [MODULES lower modules] [PRIVATE third-party targets])
#   One static library furrow_<NAME>, exported as furrow::<NAME>. Public headers stand in include/furrow/<NAME>; third-party
#   headers are seen by this module's .cpp files only.
# furrow_add_test(NAME SOURCES ... [MODULES modules] [PRIVATE third-party targets])
#   One GoogleTest program <NAME>_test, registered with CTest as one test.

add_library(furrow_options INTERFACE)
target_compile_features(furrow_options INTERFACE cxx_std_20)
target_compile_options(furrow_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Wcast-align -Woverloaded-virtual
  -Wconversion -Wno-sign-conversion -Wnull-dereference -Wdouble-promotion -Wimplicit-fallthrough
  $<$<BOOL:${FURROW_WARNINGS_AS_ERRORS}>:-Werror>
  # GCC 12 warns of these inside the standard library where nothing is wrong (its bug 105651 and kin).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-null-dereference -Wno-maybe-uninitialized -Wno-restrict -Wno-free-nonheap-object
    -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread>
  -ffp-contract=off)

set_property(GLOBAL PROPERTY FURROW_MODULE_TARGETS "")

function(furrow_add_module NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;MODULES;PRIVATE" ${ARGN})
  add_library(furrow_${NAME} STATIC ${ARG_SOURCES})
  add_library(furrow::${NAME} ALIAS furrow_${NAME})
  set_target_properties(furrow_${NAME} PROPERTIES EXPORT_NAME ${NAME} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(furrow_${NAME} PUBLIC cxx_std_20)
  target_include_directories(furrow_${NAME}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${PROJECT_SOURCE_DIR}/src)
  list(TRANSFORM ARG_MODULES PREPEND furrow_)
  target_link_libraries(furrow_${NAME} PUBLIC ${ARG_MODULES} Eigen3::Eigen PRIVATE $<BUILD_INTERFACE:furrow_options>
    ${ARG_PRIVATE} Threads::Threads)
  set_property(GLOBAL APPEND PROPERTY FURROW_MODULE_TARGETS furrow_${NAME})
endfunction()

function(furrow_add_test NAME)
  cmake_parse_arguments(ARG "" "" "SOURCES;MODULES;PRIVATE" ${ARGN})
  add_executable(${NAME}_test ${ARG_SOURCES})
  list(TRANSFORM ARG_MODULES PREPEND furrow_)
  target_include_directories(${NAME}_test PRIVATE ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/src)
  target_compile_definitions(${NAME}_test PRIVATE FURROW_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(${NAME}_test PRIVATE furrow_options ${ARG_MODULES} ${ARG_PRIVATE} GTest::gtest_main)
  add_test(NAME ${NAME} COMMAND ${NAME}_test)
endfunction()

function(furrow_install_package)
  include(CMakePackageConfigHelpers)
  get_property(targets GLOBAL PROPERTY FURROW_MODULE_TARGETS)
  add_library(furrow_all INTERFACE)
  target_link_libraries(furrow_all INTERFACE ${targets})
  set_target_properties(furrow_all PROPERTIES EXPORT_NAME furrow)
  install(TARGETS ${targets} furrow_all EXPORT furrow ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY include/furrow DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT furrow NAMESPACE furrow:: FILE furrow-targets.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/furrow)
  configure_package_config_file(cmake/furrow-config.cmake.in ${PROJECT_BINARY_DIR}/furrow-config.cmake
    INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/furrow)
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/furrow-config-version.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/furrow-config.cmake ${PROJECT_BINARY_DIR}/furrow-config-version.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/furrow)
endfunction()
