# Third-party libraries. Only the optional rooms, lumview and the tests need any.

find_package(PkgConfig)
set(lum_missing_tests "")

# lum_require(LIST PREFIX MODULE PACKAGE): PkgConfig::PREFIX, or an entry in LIST.
macro(lum_require list prefix module package)
  if(PkgConfig_FOUND)
    pkg_check_modules(${prefix} IMPORTED_TARGET ${module})
  endif()
  if(NOT ${prefix}_FOUND)
    list(APPEND ${list} "${module} (Debian: ${package})")
  endif()
endmacro()

find_package(Threads)

# The rooms that a build can leave out; each after those that it needs.
set(lum_optional_rooms capture frame cloud config picture)

# lum_find_room(ROOM PREFIX MODULE PACKAGE): LUM_WITH_ROOM, and what it lacks in
# lum_missing_ROOM.
macro(lum_find_room room prefix module package)
  string(TOUPPER ${room} ROOM)
  set(LUM_WITH_${ROOM} OFF)
  set(lum_missing_${room} "")
  if(LUM_BUILD_${ROOM})
    if(NOT PkgConfig_FOUND)
      list(APPEND lum_missing_${room} "pkg-config (Debian: pkg-config)")
    endif()
    lum_require(lum_missing_${room} ${prefix} ${module} ${package})
    if(NOT lum_missing_${room})
      set(LUM_WITH_${ROOM} ON)
    endif()
  endif()
endmacro()

# lum_find_optional(NAME WANTED PREFIX MODULE): LUM_WITH_NAME, with PkgConfig::PREFIX.
macro(lum_find_optional name wanted prefix module)
  set(LUM_WITH_${name} OFF)
  if(${wanted} AND PkgConfig_FOUND)
    pkg_check_modules(${prefix} QUIET IMPORTED_TARGET ${module})
    set(LUM_WITH_${name} ${${prefix}_FOUND})
  endif()
endmacro()

set(LUM_WITH_CAPTURE OFF)
set(lum_missing_capture "")
if(LUM_BUILD_CAPTURE)
  set(LUM_WITH_CAPTURE ON)
endif()
set(LUM_WITH_FRAME OFF)
set(lum_missing_frame "")
if(LUM_BUILD_FRAME AND LUM_WITH_CAPTURE)
  set(LUM_WITH_FRAME ON)
elseif(LUM_BUILD_FRAME)
  set(lum_missing_frame "capture")
endif()
lum_find_optional(ZLIB LUM_USE_ZLIB LUM_ZLIB zlib)
lum_find_optional(ZSTD LUM_USE_ZSTD LUM_ZSTD libzstd)
lum_find_room(config LUM_YAML yaml-0.1 libyaml-dev)
lum_find_room(picture LUM_CAIRO cairo-png libcairo2-dev)
set(LUM_WITH_CLOUD OFF)
set(lum_missing_cloud "")
if(LUM_BUILD_CLOUD AND Threads_FOUND)
  set(LUM_WITH_CLOUD ON)
elseif(LUM_BUILD_CLOUD)
  set(lum_missing_cloud "POSIX threads")
endif()
if(LUM_WITH_PICTURE AND NOT LUM_WITH_CLOUD)
  set(LUM_WITH_PICTURE OFF)
  set(lum_missing_picture "cloud")
endif()

# What lumdump and the files of lumsim need: captures, frames and clouds. Without
# YAML they take no calibration and no profile, and say so.
set(LUM_WITH_FILES OFF)
if(LUM_WITH_CAPTURE AND LUM_WITH_FRAME AND LUM_WITH_CLOUD)
  set(LUM_WITH_FILES ON)
endif()

# Editing of lines in lumctl's shell, where there is libedit.
set(LUM_WITH_EDIT OFF)
if(LUM_BUILD_TOOLS)
  lum_find_optional(EDIT LUM_USE_EDIT LUM_EDIT libedit)
endif()

# What the reader of captures is compared with.
set(LUM_WITH_JUDGE OFF)
if(LUM_WITH_CAPTURE AND (LUM_BUILD_TESTS OR LUM_FUZZ))
  lum_find_optional(JUDGE LUM_USE_JUDGE LUM_PCAP libpcap)
endif()

set(LUM_WITH_UNIT_TESTS OFF)
if(LUM_BUILD_TESTS)
  if(LUM_CMOCKA_SOURCE)
    set(LUM_WITH_UNIT_TESTS ON)
  else()
    lum_require(lum_missing_tests LUM_CMOCKA cmocka libcmocka-dev)
    set(LUM_WITH_UNIT_TESTS ${LUM_CMOCKA_FOUND})
  endif()
endif()

# The tools are tested from outside, in Python.
set(LUM_WITH_TOOL_TESTS OFF)
if(LUM_BUILD_TESTS AND LUM_BUILD_TOOLS AND LUM_WITH_FILES AND LUM_WITH_CONFIG AND LUM_WITH_PICTURE)
  find_program(LUM_PYTHON python3 DOC "Python 3 for the tests of the tools")
  if(LUM_PYTHON)
    set(LUM_WITH_TOOL_TESTS ON)
  endif()
endif()

set(LUM_WITH_FUZZERS OFF)
if(LUM_FUZZ AND LUM_WITH_CAPTURE AND LUM_WITH_CONFIG)
  set(LUM_WITH_FUZZERS ON)
endif()

# The Python package is a layer over liblumsdk. The interpreter only makes the
# package; any from 3.9 on, with NumPy, cffi and PyYAML, can use it.
set(LUM_WITH_PYTHON OFF)
set(lum_missing_python "liblumsdk (BUILD_SHARED_LIBS), with frames and clouds")
if(LUM_BUILD_PYTHON AND BUILD_SHARED_LIBS AND LUM_WITH_FILES)
  set(lum_missing_python "Python with cffi (Debian: python3-cffi)")
  if(NOT LUM_PYTHON_WITH_CFFI)
    # The build of a wheel names its own.
    foreach(python IN ITEMS ${Python3_EXECUTABLE} python3 /usr/bin/python3)
      execute_process(COMMAND ${python} -c "import cffi" RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
      if(failed EQUAL 0)
        set(LUM_PYTHON_WITH_CFFI ${python} CACHE STRING "Python 3 with cffi, which makes the package")
        break()
      endif()
    endforeach()
  endif()
  if(LUM_PYTHON_WITH_CFFI)
    set(LUM_WITH_PYTHON ON)
  endif()
endif()
if(SKBUILD AND NOT LUM_WITH_PYTHON)
  message(FATAL_ERROR "There is no Python package without ${lum_missing_python}")
endif()
