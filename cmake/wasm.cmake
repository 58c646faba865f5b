# What lumview.html decodes with: this project once more, for WebAssembly, by the preset wasm. Where something lacks, it is
# left out.
set(LUM_BUILD_PAGE AUTO CACHE STRING "Build lumview.html; needs clang or zig for WebAssembly and sources of libraries")
set_property(CACHE LUM_BUILD_PAGE PROPERTY STRINGS AUTO ON OFF)
set(LUM_SOURCES ${PROJECT_SOURCE_DIR}/build/sources CACHE PATH "Sources of zlib, zstd and libyaml, for WebAssembly")
set(LUM_WITH_PAGE OFF)
set(lum_why_no_page "it comes with lumview: ${lum_why_no_view}")

# lum_find_zig(OUT): its command, as far as one is there.
function(lum_find_zig out)
  find_program(LUM_ZIG zig DOC "zig, a compiler for WebAssembly in place of clang")
  set(${out} "" PARENT_SCOPE)
  foreach(python IN ITEMS ${PROJECT_SOURCE_DIR}/build/venv/bin/python python3)
    execute_process(COMMAND ${python} -m ziglang version RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
    if(NOT LUM_ZIG AND failed EQUAL 0)
      set(${out} "${python} -m ziglang" PARENT_SCOPE)
      return()
    endif()
  endforeach()
  if(LUM_ZIG)
    set(${out} ${LUM_ZIG} PARENT_SCOPE)
  endif()
endfunction()

# lum_find_wasm_compiler(OUT): what went wrong, or "". lum_wasm_tools: the folder of zig's tools, or "": Debian's clang.
function(lum_find_wasm_compiler out)
  set(${out} "" PARENT_SCOPE)
  set(lum_wasm_tools "" PARENT_SCOPE)
  set(folder ${PROJECT_BINARY_DIR}/wasm)
  file(WRITE ${folder}/trial.c "#include <stdlib.h>\nint trial(void);\nint trial(void)\n{\n    return abs(-1);\n}\n")
  execute_process(COMMAND clang --target=wasm32-wasi -mexec-model=reactor trial.c -o trial.wasm WORKING_DIRECTORY ${folder}
                  RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
  if(failed EQUAL 0)
    return()
  endif()
  lum_find_zig(zig)
  if(NOT zig)
    set(${out} "missing: a compiler for WebAssembly (Debian: clang lld wasi-libc libclang-rt-14-dev-wasm32; or zig)"
        PARENT_SCOPE)
    return()
  endif()
  foreach(tool IN ITEMS cc ar ranlib)
    set(command ${tool})
    if(tool STREQUAL "cc")
      set(command "cc -target wasm32-wasi")
    endif()
    file(CONFIGURE OUTPUT ${folder}/zig/${tool} CONTENT "#!/bin/sh\nexec ${zig} ${command} \"$@\"\n" @ONLY)
    file(CHMOD ${folder}/zig/${tool} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  endforeach()
  set(lum_wasm_tools ${folder}/zig PARENT_SCOPE)
endfunction()

# lum_add_wasm(): the target lum_wasm, which makes the file ${lum_wasm}. Flags of the environment are for the host's compiler.
function(lum_add_wasm)
  set(folder ${PROJECT_BINARY_DIR}/wasm/page)
  set(lum_wasm ${folder}/bin/lumview.wasm PARENT_SCOPE)
  ExternalProject_Add(lum_wasm
                      SOURCE_DIR ${PROJECT_SOURCE_DIR}
                      BINARY_DIR ${folder}
                      CONFIGURE_COMMAND ${CMAKE_COMMAND} -E env --unset=CFLAGS --unset=LDFLAGS
                                        ${CMAKE_COMMAND} --preset wasm -S <SOURCE_DIR> -B <BINARY_DIR> -G ${CMAKE_GENERATOR}
                                        -D LUM_WASM_TOOLS=${lum_wasm_tools} -D LUM_WASM_TESTS=${LUM_BUILD_TESTS}
                                        -D LUM_SOURCES=${LUM_SOURCES} -D LUM_WERROR=${LUM_WERROR}
                                        -D CMAKE_C_COMPILER_LAUNCHER=${CMAKE_C_COMPILER_LAUNCHER}
                      BUILD_COMMAND ${CMAKE_COMMAND} --build <BINARY_DIR> --target lumview_wasm
                      BUILD_ALWAYS ON
                      BUILD_BYPRODUCTS ${folder}/bin/lumview.wasm
                      INSTALL_COMMAND ""
                      LOG_CONFIGURE ON
                      USES_TERMINAL_BUILD ON)
  ExternalProject_Add_StepDependencies(lum_wasm configure ${PROJECT_SOURCE_DIR}/CMakePresets.json)
endfunction()

if(LUM_PAGE)
  set(LUM_WITH_PAGE ON)
elseif(LUM_BUILD_PAGE AND LUM_WITH_VIEW)
  if(EXISTS ${LUM_SOURCES}/zlib AND EXISTS ${LUM_SOURCES}/libzstd AND EXISTS ${LUM_SOURCES}/libyaml)
    lum_find_wasm_compiler(lum_why_no_page)
    if(NOT lum_why_no_page AND NOT LUM_BASE64)
      set(lum_why_no_page "missing: base64 (Debian: coreutils)")
    endif()
  else()
    set(lum_why_no_page "missing: sources of zlib, zstd and libyaml in ${LUM_SOURCES} (script/setup --test brings them)")
  endif()
  if(NOT lum_why_no_page)
    set(LUM_WITH_PAGE ON)
    include(ExternalProject)
    lum_add_wasm()
  endif()
endif()
if(LUM_BUILD_PAGE STREQUAL "ON" AND NOT LUM_WITH_PAGE)
  message(FATAL_ERROR "LUM_BUILD_PAGE is on, and lumview.html cannot be built: ${lum_why_no_page}")
endif()
