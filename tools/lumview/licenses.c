#include "licenses.h"

#include "assets.h"

#include <stdio.h>
#include <string.h>

void licenses_print(void)
{
    for (size_t i = 0; i < assets_count; i++) {
        if (strcmp(assets[i].path, "/licenses.txt") == 0) {
            (void)fwrite(assets[i].bytes, 1, assets[i].len, stdout);
        }
    }
}
