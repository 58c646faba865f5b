/* compare CAPTURE...: whether our reader gives of each what libpcap gives. */
#include "judge.h"

#include <stdio.h>
#include <stdlib.h>

static uint8_t *read_file(const char *path, size_t *len)
{
    FILE *file = fopen(path, "rb");
    uint8_t *bytes = NULL;
    size_t room = 1024;
    *len = 0;
    while (file != NULL && (bytes == NULL || *len == room)) {
        room *= 2u;
        uint8_t *more = realloc(bytes, room);
        if (more == NULL) {
            break;
        }
        bytes = more;
        *len += fread(bytes + *len, 1, room - *len, file);
    }
    if (file != NULL) {
        (void)fclose(file);
    }
    return bytes;
}

static int compare(const char *path)
{
    judge_result result = {0};
    lum_error error = {""};
    size_t len = 0;
    uint8_t *bytes = read_file(path, &len);
    if (bytes == NULL) {
        perror(path);
        return 1;
    }
    const int status = judge_compare(bytes, len, &result, &error);
    free(bytes);
    if (status != 0) {
        (void)fprintf(stderr, "%s: %s\n", path, error.text);
        return 1;
    }
    (void)printf(
        "%s: %llu records, %s\n", path, (unsigned long long)result.records,
        result.ended
            ? "to the end"
            : (result.opened ? "until libpcap fails" : "libpcap refuses it"));
    return 0;
}

int main(int argc, char **argv)
{
    int status = 0;
    for (int i = 1; i < argc; i++) {
        status |= compare(argv[i]);
    }
    return status;
}
