/* A build without zlib. */
#include "unpack.h"

lum_unpacker *const lum_unpack_gzip = NULL;
