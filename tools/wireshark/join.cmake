# cmake [-DPROGRAM=...] -DTABLES=... -DDISSECTOR=... -DOUT=... -P join.cmake
# The program prints the tables; without one they are there already.
if(PROGRAM)
  execute_process(COMMAND ${PROGRAM} OUTPUT_FILE ${TABLES} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${PROGRAM}: status ${status}")
  endif()
endif()
file(READ ${TABLES} tables)
file(READ ${DISSECTOR} dissector)
file(WRITE ${OUT} "${tables}${dissector}")
