/* The compressions that a build lacks; CMake says which. */
#include "unpack.h"

#ifdef LUM_LACKS_ZLIB
lum_unpacker *const lum_unpack_gzip = NULL;
#endif
#ifdef LUM_LACKS_ZSTD
lum_unpacker *const lum_unpack_zstd = NULL;
#endif
#ifdef LUM_LACKS_LZ4
lum_unpacker *const lum_unpack_lz4 = NULL;
#endif
#ifdef LUM_LACKS_BZ2
lum_unpacker *const lum_unpack_bz2 = NULL;
#endif
