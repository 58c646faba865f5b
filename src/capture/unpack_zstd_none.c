/* A build without libzstd. */
#include "unpack.h"

lum_unpacker *const lum_unpack_zstd = NULL;
