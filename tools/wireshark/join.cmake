# cmake -DPROGRAM=... -DPARTS="NAME ..." -DOUT=... -P join.cmake
# The program prints the tables. A part is the body of a function; the parts behind
# it have what it returns, by its name.
execute_process(COMMAND ${PROGRAM} OUTPUT_VARIABLE joined RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${PROGRAM}: status ${status}")
endif()
separate_arguments(parts UNIX_COMMAND "${PARTS}")
foreach(part IN LISTS parts)
  file(READ ${CMAKE_CURRENT_LIST_DIR}/${part}.lua text)
  string(APPEND joined "local ${part} = (function()\n${text}end)()\n\n")
endforeach()
file(WRITE ${OUT} "${joined}")
