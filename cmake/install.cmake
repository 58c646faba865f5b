# Headers, libraries, tools, man pages, calibrations; find_package and pkg-config.
include(CMakePackageConfigHelpers)

set(lum_installed lum_base lum_core lum_host lum_net lum_points)
set(lum_headers_left_out "")
foreach(room IN LISTS lum_optional_rooms)
  if(TARGET lum_${room})
    list(APPEND lum_installed lum_${room})
  else()
    list(APPEND lum_headers_left_out PATTERN ${room} EXCLUDE)
  endif()
endforeach()
if(NOT TARGET lum_capture) # whose records it gives
  list(APPEND lum_headers_left_out PATTERN live.h EXCLUDE)
endif()
set(lum_config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/lumsdk)

if(TARGET lumsdk)
  list(APPEND lum_installed lumsdk)
endif()
install(TARGETS ${lum_installed} EXPORT lumsdk
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT lumsdk NAMESPACE lumsdk:: FILE lumsdkTargets.cmake DESTINATION ${lum_config_dir})
set(LUM_WITH_SHARED OFF)
if(TARGET lumsdk)
  set(LUM_WITH_SHARED ON)
endif()
configure_package_config_file(cmake/lumsdkConfig.cmake.in lumsdkConfig.cmake
                              INSTALL_DESTINATION ${lum_config_dir})
write_basic_package_version_file(lumsdkConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/lumsdkConfig.cmake ${PROJECT_BINARY_DIR}/lumsdkConfigVersion.cmake
        DESTINATION ${lum_config_dir})

install(DIRECTORY include/lum DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.h" ${lum_headers_left_out})

# Relocatable, unless a directory was given as an absolute path.
set(lum_pc_prefix "${CMAKE_INSTALL_PREFIX}")
if(NOT IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}")
  file(RELATIVE_PATH lum_pc_prefix "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
  string(REGEX REPLACE "/$" "" lum_pc_prefix ${lum_pc_prefix})
  set(lum_pc_prefix "\${pcfiledir}/${lum_pc_prefix}")
endif()
foreach(dir IN ITEMS LIBDIR INCLUDEDIR)
  set(lum_pc_${dir} "${CMAKE_INSTALL_${dir}}")
  if(NOT IS_ABSOLUTE "${lum_pc_${dir}}")
    set(lum_pc_${dir} "\${prefix}/${lum_pc_${dir}}")
  endif()
endforeach()
set(lum_pc_compression "")
if(LUM_WITH_ZLIB)
  string(APPEND lum_pc_compression ", zlib")
endif()
if(LUM_WITH_ZSTD)
  string(APPEND lum_pc_compression ", libzstd")
endif()
foreach(target IN LISTS lum_installed)
  string(REPLACE "lum_" "lumsdk-" lum_pc ${target})
  configure_file(cmake/${lum_pc}.pc.in ${lum_pc}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${lum_pc}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()

install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
if(TARGET lumview)
  install(FILES ${lum_view_licenses} DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME lumview-licenses.txt)
endif()
install(DIRECTORY calib/ DESTINATION ${CMAKE_INSTALL_DATADIR}/lumsdk FILES_MATCHING PATTERN "*.yaml")
foreach(tool IN ITEMS lumctl lumdump lumsim lumtable lumview)
  if(TARGET ${tool})
    install(TARGETS ${tool} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
    if(EXISTS ${PROJECT_SOURCE_DIR}/docs/man/${tool}.1)
      install(FILES docs/man/${tool}.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
    endif()
  endif()
endforeach()
if(LUM_BUILD_TOOLS AND NOT WIN32)
  install(FILES tools/completion/lumsdk.bash
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME lumctl)
  foreach(tool IN ITEMS lumcal lumdump lumfleet lumsim lumtable lumview)
    install(CODE "file(CREATE_LINK lumctl
                       \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/bash-completion/completions/${tool}\"
                       SYMBOLIC)")
  endforeach()
  install(FILES tools/completion/_lumsdk DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
endif()
