# A toolchain file: WebAssembly with the system interface of WASI, by Debian's clang, lld, wasi-libc and
# libclang-rt-14-dev-wasm32, or by the tools of a folder: cc, ar and ranlib.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES LUM_WASM_TOOLS)
if(LUM_WASM_TOOLS)
  set(CMAKE_C_COMPILER ${LUM_WASM_TOOLS}/cc)
  set(CMAKE_AR ${LUM_WASM_TOOLS}/ar)
  set(CMAKE_RANLIB ${LUM_WASM_TOOLS}/ranlib)
else()
  set(CMAKE_C_COMPILER clang)
  set(CMAKE_C_COMPILER_TARGET wasm32-wasi)
endif()
# There are no threads, and what writes files is left out.
set(LUM_WASM ON)
set(CMAKE_DISABLE_FIND_PACKAGE_Threads ON)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
# Every browser in which the page works has vectors and the others. Without bulk memory: with it clang 14 would make errno a thread's.
set(CMAKE_C_FLAGS_INIT "-msimd128 -mnontrapping-fptoint -msign-ext")
