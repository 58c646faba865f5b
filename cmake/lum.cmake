# What all targets have in common.

if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Debug, Release, RelWithDebInfo, MinSizeRel" FORCE)
endif()

set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# Files above 2 GiB on hosts of 32 bits, in all that looks at, reads or writes one.
# No public header has a type that depends on it.
add_compile_definitions(_FILE_OFFSET_BITS=64)

set(lum_compile_options
    -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wvla -Wstrict-prototypes -Wmissing-prototypes
    # A switch over an enumeration names all of it, also where it has a default: what is new must be looked at everywhere.
    -Wswitch-enum)
# The same points on every processor, and by vectors of every width: a product and a sum are not joined and rounded once,
# where there is an instruction for it.
list(APPEND lum_compile_options -ffp-contract=off)
set(lum_link_options "")
if(LUM_LINKER)
  list(APPEND lum_link_options -fuse-ld=${LUM_LINKER})
endif()
if(WIN32)
  # Vista's Winsock; formats of C99 in printf.
  add_compile_definitions(_WIN32_WINNT=0x0600 __USE_MINGW_ANSI_STDIO=1)
endif()

if(LUM_WERROR)
  list(APPEND lum_compile_options -Werror)
endif()
if(LUM_MCDC)
  list(APPEND lum_compile_options -fprofile-instr-generate -fcoverage-mapping -fcoverage-mcdc)
  list(APPEND lum_link_options -fprofile-instr-generate)
endif()
if(LUM_CHECKED)
  list(APPEND lum_compile_options -DLUM_CHECKED)
endif()
if(LUM_SANITIZE)
  list(APPEND lum_compile_options
       -fsanitize=${LUM_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -g)
  list(APPEND lum_link_options -fsanitize=${LUM_SANITIZE})
endif()
if(LUM_FUZZ)
  if(NOT CMAKE_C_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "LUM_FUZZ needs clang, not ${CMAKE_C_COMPILER_ID}: configure with -DCMAKE_C_COMPILER=clang")
  endif()
  list(APPEND lum_compile_options -fsanitize=fuzzer-no-link)
endif()

# lum_target(NAME): language level, warnings, sanitizers.
function(lum_target name)
  set_target_properties(${name} PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)
  target_compile_options(${name} PRIVATE ${lum_compile_options})
  target_link_options(${name} PRIVATE ${lum_link_options})
endfunction()

# Into shared libraries too, which WebAssembly has none of.
set(lum_library_moves ON)
if(LUM_WASM)
  set(lum_library_moves OFF)
endif()

# lum_library(NAME EXPORTED_NAME SOURCE...): a static library that is installed.
function(lum_library name exported)
  add_library(${name} STATIC ${ARGN})
  add_library(lumsdk::${exported} ALIAS ${name})
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${exported} POSITION_INDEPENDENT_CODE ${lum_library_moves})
  target_include_directories(${name} PUBLIC
                             $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  lum_target(${name})
endfunction()

# lum_program(NAME SOURCE...): an executable.
function(lum_program name)
  add_executable(${name} ${ARGN})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  lum_target(${name})
endfunction()

# lum_help(TARGET FOLDER): what --help prints, of a folder's help.txt.
function(lum_help target folder)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/help.txt)
  file(READ ${folder}/help.txt text HEX)
  string(REGEX REPLACE "(..)" "0x\\1," text "${text}")
  file(CONFIGURE OUTPUT help.c CONTENT "extern const char help_text[];\nconst char help_text[] = {${text}0};\n")
  target_sources(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/help.c)
endfunction()

# lum_tool(NAME SOURCE...): a program for users, in BUILD/bin.
function(lum_tool name)
  lum_program(${name} ${ARGN})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/help.txt)
    lum_help(${name} ${CMAKE_CURRENT_SOURCE_DIR})
  endif()
endfunction()

# lum_tested_by(ROOM TARGET...): what `script/test ROOM` builds: the target tests-ROOM.
function(lum_tested_by room)
  if(NOT TARGET tests-${room})
    add_custom_target(tests-${room})
  endif()
  add_dependencies(tests-${room} ${ARGN})
endfunction()
