# What only tests ask of the decoder of lumview.html (tools/lumview/wasm).
target_sources(lumview_wasm PRIVATE ${CMAKE_CURRENT_LIST_DIR}/all_points.c)
