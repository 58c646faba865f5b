/* What draws a picture: cairo, where lumdump was built with it. */
#ifndef LUMDUMP_PICTURE_H
#define LUMDUMP_PICTURE_H

#include "lum/cloud/writer.h"

/* NULL: there is none. */
const lum_format_ops *picture_format(void);

#endif
