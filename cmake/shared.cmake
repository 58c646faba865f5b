# liblumsdk: the rooms without a third-party dependency, but for the compression
# that capture reads, as one shared library, where BUILD_SHARED_LIBS asks for it. The static libraries stay. It exports what
# the public headers declare, as the reviewed lists in tests/abi have it, and
# nothing else.
set(lum_shared_rooms base core host net live points capture frame infer cloud map)

# lum_write_exports(SYMBOLS): for the linker of this system, into lum_exports.
function(lum_write_exports symbols)
  set(file ${PROJECT_BINARY_DIR}/lumsdk)
  if(WIN32)
    list(JOIN symbols "\n" lines)
    # The one variable.
    string(REPLACE "lum_command_specs" "lum_command_specs DATA" lines "${lines}")
    string(APPEND file .def)
    set(text "EXPORTS\n${lines}\n")
  elseif(APPLE)
    list(JOIN symbols "\n_" lines)
    string(APPEND file .exp)
    set(text "_${lines}\n")
  else()
    list(JOIN symbols ";\n" lines)
    string(APPEND file .map)
    set(text "LUMSDK_${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} {\nglobal:\n${lines};\nlocal:\n*;\n};\n")
  endif()
  file(CONFIGURE OUTPUT ${file} CONTENT "${text}" @ONLY)
  set(lum_exports ${file} PARENT_SCOPE)
endfunction()

# lum_hide_internals(ROOM...): zig's linker for macOS exports all that can be seen, and
# not only what is listed. So only what a public header declares can be seen.
function(lum_hide_internals)
  set(text "#pragma GCC visibility push(default)\n")
  foreach(folder IN ITEMS . ${ARGN})
    file(GLOB headers RELATIVE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/include/lum/${folder}/*.h)
    foreach(header IN LISTS headers)
      string(APPEND text "#include <${header}>\n")
    endforeach()
  endforeach()
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/lumsdk_public.h CONTENT "${text}#pragma GCC visibility pop\n" @ONLY)
  foreach(room IN LISTS ARGN)
    if(TARGET lum_${room})
      # The header comes before what a source says of the system's headers.
      target_compile_options(lum_${room} PRIVATE -fvisibility=hidden -D_DARWIN_C_SOURCE=
                             -include ${PROJECT_BINARY_DIR}/lumsdk_public.h)
    endif()
  endforeach()
endfunction()

if(BUILD_SHARED_LIBS AND APPLE)
  lum_hide_internals(${lum_shared_rooms})
elseif(BUILD_SHARED_LIBS AND NOT WIN32)
  # Its own calls stay its own. A linker that cannot tell functions apart binds the one
  # variable too, which a program that is linked with the library would have a copy of.
  include(CheckLinkerFlag)
  check_linker_flag(C -Wl,-Bsymbolic-functions LUM_HAS_SYMBOLIC_FUNCTIONS)
  set(lum_symbolic -Bsymbolic-functions)
  if(NOT LUM_HAS_SYMBOLIC_FUNCTIONS)
    set(lum_symbolic -Bsymbolic)
  endif()
endif()

if(BUILD_SHARED_LIBS)
  set(symbols "")
  set(objects "")
  set(needs "")
  foreach(room IN LISTS lum_shared_rooms)
    if(TARGET lum_${room})
      set(list ${PROJECT_SOURCE_DIR}/tests/abi/${room}.symbols)
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${list})
      file(STRINGS ${list} public REGEX " public$")
      list(TRANSFORM public REPLACE " .*" "")
      list(APPEND symbols ${public})
      list(APPEND objects $<TARGET_OBJECTS:lum_${room}>)
      get_target_property(libraries lum_${room} LINK_LIBRARIES)
      list(APPEND needs ${libraries})
    endif()
  endforeach()
  # What rooms need of each other is within.
  list(FILTER needs EXCLUDE REGEX "^lum_|NOTFOUND$")
  list(REMOVE_DUPLICATES needs)
  lum_write_exports("${symbols}")

  add_library(lumsdk SHARED ${objects})
  add_library(lumsdk::lumsdk ALIAS lumsdk)
  set_target_properties(lumsdk PROPERTIES LINKER_LANGUAGE C LINK_DEPENDS ${lum_exports})
  # Before 1.0 a new minor version may break what was built with an older one. In a
  # wheel the library belongs to its package, and has one name.
  if(SKBUILD)
    set_target_properties(lumsdk PROPERTIES INSTALL_NAME_DIR @rpath BUILD_WITH_INSTALL_NAME_DIR ON)
  else()
    set_target_properties(lumsdk PROPERTIES VERSION ${PROJECT_VERSION}
                          SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  endif()
  target_include_directories(lumsdk PUBLIC
                             $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(lumsdk PRIVATE ${needs})
  lum_target(lumsdk)
  if(WIN32)
    target_sources(lumsdk PRIVATE ${lum_exports})
  elseif(APPLE)
    target_link_options(lumsdk PRIVATE -Wl,-exported_symbols_list,${lum_exports})
  else()
    target_link_options(lumsdk PRIVATE -Wl,--version-script=${lum_exports} -Wl,${lum_symbolic})
    # It names all that it needs; what sanitizers need comes with the program.
    if(NOT LUM_SANITIZE AND NOT LUM_FUZZ)
      target_link_options(lumsdk PRIVATE -Wl,-z,defs)
    endif()
  endif()
endif()
