/* Links base of an installed copy. */
#include <lum/base/error.h>
#include <lum/base/time.h>

#include <stdio.h>
#include <string.h>

int main(void)
{
    lum_error error;

    (void)puts("base");
    return lum_error_set(&error, "%d", 7) != -1 || strcmp(error.text, "7") != 0;
}
