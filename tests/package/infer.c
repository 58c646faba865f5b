/* Links inference of an installed copy. */
#include <lum/infer/infer.h>

#include <stdio.h>

int main(void)
{
    static lum_infer_result result = {.struct_size = sizeof result};
    lum_infer_options options = {.struct_size = sizeof options};
    lum_infer *infer = NULL;
    lum_error error;

    if (lum_infer_create(&options, &infer, &error) != 0) {
        return 1;
    }
    const int solved = lum_infer_solve(infer, &result, &error);
    lum_infer_free(infer);
    (void)puts("infer");
    return solved == 1 && result.verdict == LUM_INFER_TOO_LITTLE ? 0 : 1;
}
