# From a source to frames.
set(lum_view_threads sensor_link.c thread_monitor.c)
set(lum_view_alone alone.c)
set(lum_view_feed
    capture_player.c
    capture_scan.c
    captures.c
    decoder.c
    feed.c
    gather.c
    page_frame.c
    playhead.c
    second_profile.c
    stage.c
    view_picture.c)
foreach(files IN ITEMS lum_view_threads lum_view_alone lum_view_feed)
  list(TRANSFORM ${files} PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
endforeach()

# With threads, and for systems that have none.
set(lum_view_targets lum_view_feed_alone)
if(NOT LUM_WASM)
  list(APPEND lum_view_targets lum_view_feed)
  add_library(lum_view_feed OBJECT ${lum_view_feed} ${lum_view_threads})
  target_link_libraries(lum_view_feed PUBLIC lum_net Threads::Threads)
endif()
add_library(lum_view_feed_alone OBJECT EXCLUDE_FROM_ALL ${lum_view_feed} ${lum_view_alone})
foreach(target IN LISTS lum_view_targets)
  target_include_directories(${target} PUBLIC ${CMAKE_CURRENT_LIST_DIR} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(${target} PUBLIC lum_tool_common lum_tool_files lum_frame lum_config lum_points m)
  lum_target(${target})
endforeach()
