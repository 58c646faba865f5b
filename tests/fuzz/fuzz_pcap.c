/* Any bytes, to our reader of captures and to libpcap's. */
#include "judge/judge.h"

#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    judge_result result;
    lum_error error = {""};
    if (judge_compare(data, size, &result, &error) != 0) {
        (void)fprintf(stderr, "%s\n", error.text);
        abort();
    }
    return 0;
}
