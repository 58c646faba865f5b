# What WebAssembly has no packages of: libraries from their sources, as far as they unpack and parse, in place of those
# that pkg-config would find.

# lum_source_library(NAME FOLDER PATTERN...): PkgConfig::NAME, of files in LUM_SOURCES/FOLDER.
function(lum_source_library name folder)
  list(TRANSFORM ARGN PREPEND ${LUM_SOURCES}/${folder}/)
  file(GLOB files ${ARGN})
  if(files)
    add_library(${name} STATIC ${files})
    add_library(PkgConfig::${name} ALIAS ${name})
    # Others' code, which our warnings are not for.
    target_compile_options(${name} PRIVATE -w)
    set(${name}_FOUND ON PARENT_SCOPE)
  endif()
endfunction()

lum_source_library(LUM_ZLIB zlib adler32.c crc32.c inffast.c inflate.c inftrees.c zutil.c)
lum_source_library(LUM_ZSTD libzstd lib/common/*.c lib/decompress/*.c)
lum_source_library(LUM_YAML libyaml src/*.c)
if(LUM_ZLIB_FOUND AND LUM_ZSTD_FOUND AND LUM_YAML_FOUND)
  target_include_directories(LUM_ZLIB PUBLIC ${LUM_SOURCES}/zlib)
  target_include_directories(LUM_ZSTD PUBLIC ${LUM_SOURCES}/libzstd/lib)
  target_compile_definitions(LUM_ZSTD PRIVATE ZSTD_DISABLE_ASM ZSTD_LEGACY_SUPPORT=0 ZSTD_NO_INLINE HUF_FORCE_DECOMPRESS_X1
                                              ZSTD_FORCE_DECOMPRESS_SEQUENCES_SHORT)
  target_include_directories(LUM_YAML PUBLIC ${LUM_SOURCES}/libyaml/include)
  target_compile_definitions(LUM_YAML PUBLIC YAML_DECLARE_STATIC PRIVATE YAML_VERSION_STRING="" YAML_VERSION_MAJOR=0
                                                                         YAML_VERSION_MINOR=0 YAML_VERSION_PATCH=0)
else()
  message(FATAL_ERROR "No sources of zlib, zstd and libyaml are in ${LUM_SOURCES}: script/setup --test brings them")
endif()
set(LUM_ZSTD_PACKS OFF CACHE INTERNAL "zstd is there to unpack only")
