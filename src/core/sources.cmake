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
list(TRANSFORM lum_core_sources PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
