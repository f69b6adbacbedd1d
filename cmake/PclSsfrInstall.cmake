# Install rules: library, headers, package files. find_package(pcl_ssfr CONFIG) then gives pcl_ssfr::pcl_ssfr and,
# unless they were left out, pcl_ssfr::baselines and pcl_ssfr::multiway, the components "baselines" and "multiway".
include(CMakePackageConfigHelpers)

set(pcl_ssfr_config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/pcl_ssfr")

# Install the library \p target and its targets file \p export.cmake.
function(pcl_ssfr_install_library target export)
  install(TARGETS ${target} EXPORT ${export}
          ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}"
          LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}"
          RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
  install(EXPORT ${export} NAMESPACE pcl_ssfr:: DESTINATION "${pcl_ssfr_config_dir}")
endfunction()
pcl_ssfr_install_library(pcl_ssfr pcl_ssfrTargets)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/pcl_ssfr" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
        FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp" PATTERN "baselines" EXCLUDE PATTERN "multiway" EXCLUDE)
if(PCL_SSFR_BUILD_BASELINES)
  pcl_ssfr_install_library(pcl_ssfr_baselines pcl_ssfrBaselinesTargets)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/pcl_ssfr/baselines"
          DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/pcl_ssfr" FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
endif()
if(PCL_SSFR_BUILD_MULTIWAY)
  pcl_ssfr_install_library(pcl_ssfr_multiway pcl_ssfrMultiwayTargets)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/pcl_ssfr/multiway"
          DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/pcl_ssfr" FILES_MATCHING PATTERN "*.h")
endif()
install(FILES "${PROJECT_BINARY_DIR}/include/pcl_ssfr/export.h" "${PROJECT_BINARY_DIR}/include/pcl_ssfr/version.h"
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/pcl_ssfr")

# A static library hands its private dependencies on to whoever links it.
get_target_property(pcl_ssfr_library_type pcl_ssfr TYPE)
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/pcl_ssfrConfig.cmake.in"
                              "${PROJECT_BINARY_DIR}/pcl_ssfrConfig.cmake"
                              INSTALL_DESTINATION "${pcl_ssfr_config_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/pcl_ssfrConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/pcl_ssfrConfig.cmake" "${PROJECT_BINARY_DIR}/pcl_ssfrConfigVersion.cmake"
        DESTINATION "${pcl_ssfr_config_dir}")

# Where colcon and other ROS tools look for a package.
install(FILES "${PROJECT_SOURCE_DIR}/package.xml" DESTINATION "${CMAKE_INSTALL_DATADIR}/pcl_ssfr")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/pcl_ssfr")
