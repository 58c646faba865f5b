# The core's files, for all that compile them: CMakeLists.txt beside this one, the top's as a component of ESP-IDF, and
# zephyr/CMakeLists.txt.
set(lum_core_sources
    assembler.c
    calibration.c
    clock.c
    command.c
    counter.c
    frames.c
    group.c
    laser.c
    layout_any.c
    lines.c
    packet.c
    points_fixed.c
    product.c
    profile.c
    receiver.c
    returns.c
    stream.c
    turn.c
    wire.c
    words.c)

# What Kconfig has chosen, or variables of the same names: another file in place of one.
if(CONFIG_LUMSDK_LAYOUT_FIXED)
  list(TRANSFORM lum_core_sources REPLACE layout_any.c layout_fixed.c)
elseif(CONFIG_LUMSDK_LAYOUT_OWN)
  list(REMOVE_ITEM lum_core_sources layout_any.c)
endif()
if(CONFIG_LUMSDK_FRAMES_NONE)
  list(TRANSFORM lum_core_sources REPLACE frames.c frames_none.c)
endif()

list(TRANSFORM lum_core_sources PREPEND ${CMAKE_CURRENT_LIST_DIR}/)

# A file of lumtable, which includes the core's own headers.
if(CONFIG_LUMSDK_LAYOUT_OWN)
  get_filename_component(lum_layout_file "${CONFIG_LUMSDK_LAYOUT_FILE}" ABSOLUTE BASE_DIR ${CMAKE_SOURCE_DIR})
  if(NOT EXISTS "${lum_layout_file}" OR IS_DIRECTORY "${lum_layout_file}")
    message(FATAL_ERROR "CONFIG_LUMSDK_LAYOUT_FILE: '${CONFIG_LUMSDK_LAYOUT_FILE}' is no file; give the path of one "
                        "that lumtable --layout wrote, from ${CMAKE_SOURCE_DIR} on")
  endif()
  list(APPEND lum_core_sources ${lum_layout_file})
  set_source_files_properties(${lum_layout_file} PROPERTIES INCLUDE_DIRECTORIES ${CMAKE_CURRENT_LIST_DIR})
endif()
