# Settings of our own targets: strict warnings, no global flags.
function(pcl_ssfr_configure_target target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast
                                           -Wcast-qual -Wconversion -Wno-sign-conversion -Woverloaded-virtual)
  # GCC 12 sees overruns and uninitialised values in Eigen 3.4 and in PCL's ICP where there are none.
  target_compile_options(${target} PRIVATE "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-maybe-uninitialized>")
  if(PCL_SSFR_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  # PCL's targets name libraries that nothing here calls; each one linked is loaded at every start.
  if(UNIX AND NOT APPLE)
    target_link_options(${target} PRIVATE "LINKER:--as-needed")
  endif()
endfunction()

# pcl_ssfr_loads_comparison(target): a program that runs methods finds their module, where it was built or installed.
function(pcl_ssfr_loads_comparison target)
  add_dependencies(${target} pcl_ssfr_comparison)
  set_property(TARGET ${target} APPEND PROPERTY BUILD_RPATH "$<TARGET_FILE_DIR:pcl_ssfr_comparison>")
  # The older of both tags: no LD_LIBRARY_PATH leads to another build's module, and it holds where a sanitizer asks.
  if(UNIX AND NOT APPLE)
    target_link_options(${target} PRIVATE "LINKER:--disable-new-dtags")
  endif()
endfunction()

# pcl_ssfr_add_library(name sources...): the library that is installed, which shows what is exported and nothing else,
# and name_internal, the same objects as a static library for the programs and tests of this project, which use stages
# that users do not see. Sources are compiled once, as name_objects.
function(pcl_ssfr_add_library name)
  add_library(${name}_objects OBJECT ${ARGN})
  add_library(${name} "$<TARGET_OBJECTS:${name}_objects>")
  add_library(${name}_internal STATIC EXCLUDE_FROM_ALL "$<TARGET_OBJECTS:${name}_objects>")
  foreach(library ${name}_objects ${name} ${name}_internal)
    pcl_ssfr_configure_target(${library})
    set_target_properties(${library} PROPERTIES LINKER_LANGUAGE CXX)
  endforeach()
  set_target_properties(${name}_objects PROPERTIES
    POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  # While the major version is 0, every minor one may change the binary interface.
  set_target_properties(${name} PROPERTIES
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  # What a library takes of the core is not for its users either.
  if(BUILD_SHARED_LIBS AND UNIX AND NOT APPLE)
    target_link_options(${name} PRIVATE "LINKER:--version-script=${PROJECT_SOURCE_DIR}/src/exports.map")
    set_target_properties(${name} PROPERTIES LINK_DEPENDS "${PROJECT_SOURCE_DIR}/src/exports.map")
  endif()
endfunction()
