#include "picture.h"

#include "lum/picture/picture.h"

const lum_format_ops *picture_format(void)
{
    return lum_picture_format();
}
