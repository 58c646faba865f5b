/* In place of the library that draws pictures, which needs cairo: there is
 * none. */
#include "lum/picture/picture.h"

#include <stddef.h>

const lum_format_ops *lum_picture_format(void)
{
    return NULL;
}
