# Install rules: library, headers, package files. find_package(pcl_ssfr CONFIG) then gives pcl_ssfr::pcl_ssfr
# and pcl_ssfr::baselines.
include(CMakePackageConfigHelpers)

set(pcl_ssfr_config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/pcl_ssfr")

set(pcl_ssfr_installed pcl_ssfr)
if(PCL_SSFR_BUILD_BASELINES)
  list(APPEND pcl_ssfr_installed pcl_ssfr_baselines)
endif()
install(TARGETS ${pcl_ssfr_installed} EXPORT pcl_ssfrTargets
        ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}"
        LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}"
        RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
set(pcl_ssfr_left_out "")
if(NOT PCL_SSFR_BUILD_BASELINES)
  set(pcl_ssfr_left_out PATTERN "baselines" EXCLUDE)
endif()
install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/pcl_ssfr" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
        FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp" ${pcl_ssfr_left_out})
install(FILES "${PROJECT_BINARY_DIR}/include/pcl_ssfr/export.h" "${PROJECT_BINARY_DIR}/include/pcl_ssfr/version.h"
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/pcl_ssfr")

install(EXPORT pcl_ssfrTargets NAMESPACE pcl_ssfr:: DESTINATION "${pcl_ssfr_config_dir}")
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
