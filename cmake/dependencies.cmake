# Libraries of other people. Only io and the tests need any.

find_package(PkgConfig)
set(lum_missing "")       # for io
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
if(LUM_BUILD_IO)
  if(NOT PkgConfig_FOUND)
    list(APPEND lum_missing "pkg-config (Debian: pkg-config)")
  endif()
  lum_require(lum_missing LUM_YAML yaml-0.1 libyaml-dev)
  lum_require(lum_missing LUM_PCAP libpcap libpcap-dev)
  lum_require(lum_missing LUM_PNG libpng libpng-dev)
  if(NOT Threads_FOUND)
    list(APPEND lum_missing "POSIX threads")
  endif()
endif()

# Editing of lines in lumctl's shell, where there is libedit.
set(LUM_WITH_EDIT OFF)
if(LUM_BUILD_TOOLS AND LUM_USE_EDIT AND PkgConfig_FOUND)
  pkg_check_modules(LUM_EDIT QUIET IMPORTED_TARGET libedit)
  set(LUM_WITH_EDIT ${LUM_EDIT_FOUND})
endif()

set(LUM_WITH_IO OFF)
if(LUM_BUILD_IO AND NOT lum_missing)
  set(LUM_WITH_IO ON)
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
if(LUM_BUILD_TESTS AND LUM_BUILD_TOOLS AND LUM_WITH_IO)
  find_program(LUM_PYTHON python3 DOC "Python 3 for the tests of the tools")
  if(LUM_PYTHON)
    set(LUM_WITH_TOOL_TESTS ON)
  endif()
endif()

set(LUM_WITH_FUZZERS OFF)
if(LUM_FUZZ AND LUM_WITH_IO)
  set(LUM_WITH_FUZZERS ON)
endif()
