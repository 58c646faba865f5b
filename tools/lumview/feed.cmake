# From a source to frames.
set(lum_view_feed
    captures.c
    decoder.c
    feed.c
    frame.c
    gather.c
    link.c
    picture.c
    player.c
    playhead.c
    pump.c
    report.c
    scan.c
    second.c
    stage.c
    thread.c)
list(TRANSFORM lum_view_feed PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
add_library(lum_view_feed OBJECT ${lum_view_feed})
target_include_directories(lum_view_feed PUBLIC ${CMAKE_CURRENT_LIST_DIR})
target_link_libraries(lum_view_feed PUBLIC
                      lum_tool_common lum_tool_files lum_net lum_frame lum_config lum_points m Threads::Threads)
lum_target(lum_view_feed)
