/* random_captures COUNT SEED CAPTURE...: captures changed at random, to our
 * reader and to libpcap's. Faster than a fuzzer and blind; the same numbers
 * give the same captures. What they differ in is written to differs.pcap. */
#include "judge.h"

#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    ROOM = 4096,
    CHANGES_MAX = 4
};

struct capture {
    uint8_t bytes[ROOM];
    size_t len;
};

static uint64_t state;

/* xorshift64* */
static uint32_t random_u32(void)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (uint32_t)(state * UINT64_C(0x2545f4914f6cdd1d) >> 32);
}

static size_t below(size_t limit)
{
    return limit != 0 ? random_u32() % limit : 0;
}

/* Most fields are at a multiple of 4. */
static size_t place(const struct capture *c, size_t len)
{
    const size_t at = below(c->len - len + 1u);
    return random_u32() % 4u != 0 ? at / 4u * 4u : at;
}

static void change_byte(struct capture *c)
{
    c->bytes[place(c, 1)] = (uint8_t)random_u32();
}

static void change_bit(struct capture *c)
{
    c->bytes[place(c, 1)] ^= (uint8_t)(1u << random_u32() % 8u);
}

/* Lengths, kinds and limits, in either byte order. */
static void set_field(struct capture *c)
{
    static const uint32_t values[] = {
        0,     1,      2,      3,          4,          5,          6,
        9,     12,     14,     16,         28,         32,         36,
        0xff,  0xffff, 262144, 262145,     0x7fffffff, 0x80000000, 0xffffffff,
        65535, 113,    101,    0x0a0d0d0a, 0x1a2b3c4d, 0xa1b2c3d4, 0xa1b23c4d};
    const uint32_t value = values[below(sizeof values / sizeof values[0])];
    const size_t size = random_u32() % 4u != 0 ? 4 : 2;
    const bool is_big = random_u32() % 2u != 0;
    const size_t at = place(c, size);
    for (size_t i = 0; i < size; i++) {
        c->bytes[at + i] =
            (uint8_t)(value >> (8u * (is_big ? size - 1u - i : i)));
    }
}

static void add_to_field(struct capture *c)
{
    const size_t at = place(c, 1);
    c->bytes[at] = (uint8_t)(c->bytes[at] + below(17) - 8u);
}

static void cut(struct capture *c)
{
    const size_t at = place(c, 0);
    const size_t len = below(c->len - at + 1u);
    memmove(c->bytes + at, c->bytes + at + len, c->len - at - len);
    c->len -= len;
}

static void end_early(struct capture *c)
{
    c->len = below(c->len + 1u);
}

/* A part of it once more, somewhere. */
static void repeat(struct capture *c)
{
    const size_t from = place(c, 0);
    size_t len = below(c->len - from + 1u);
    len = len < ROOM - c->len ? len : ROOM - c->len;
    const size_t to = place(c, 0);
    uint8_t part[ROOM];
    memcpy(part, c->bytes + from, len);
    memmove(c->bytes + to + len, c->bytes + to, c->len - to);
    memcpy(c->bytes + to, part, len);
    c->len += len;
}

static void change(struct capture *c)
{
    static void (*const changes[])(struct capture *) = {
        change_byte,  change_bit, set_field, set_field,
        add_to_field, cut,        end_early, repeat};
    if (c->len >= 4) {
        changes[below(sizeof changes / sizeof changes[0])](c);
    }
}

static int read_seed(const char *path, struct capture *out)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        perror(path);
        return -1;
    }
    out->len = fread(out->bytes, 1, sizeof out->bytes, file);
    (void)fclose(file);
    return 0;
}

static int tell(const struct capture *c, const lum_error *error)
{
    FILE *file = fopen("differs.pcap", "wb");
    (void)fprintf(stderr, "%s: differs.pcap\n", error->text);
    if (file != NULL) {
        (void)fwrite(c->bytes, 1, c->len, file);
        (void)fclose(file);
    }
    return 1;
}

static int run(uint64_t count, const struct capture *seeds, size_t seed_count)
{
    uint64_t opened = 0;
    uint64_t ended = 0;
    uint64_t records = 0;
    for (uint64_t i = 0; i < count; i++) {
        struct capture c = seeds[below(seed_count)];
        judge_result result = {0};
        lum_error error = {""};
        for (size_t k = below(CHANGES_MAX) + 1u; k > 0; k--) {
            change(&c);
        }
        if (judge_compare(c.bytes, c.len, &result, &error) != 0) {
            return tell(&c, &error);
        }
        opened += result.opened != 0;
        ended += result.ended != 0;
        records += result.records;
    }
    (void)printf("%" PRIu64 " captures; libpcap opened %" PRIu64
                 " and came to the end of %" PRIu64 "; %" PRIu64
                 " records were equal\n",
                 count, opened, ended, records);
    return records != 0 ? 0 : 1;
}

int main(int argc, char **argv)
{
    if (argc < 4) {
        (void)fputs("usage: random_captures COUNT SEED CAPTURE...\n", stderr);
        return 2;
    }
    const size_t seed_count = (size_t)argc - 3u;
    struct capture *seeds = calloc(seed_count, sizeof *seeds);
    int status = seeds == NULL;
    for (size_t i = 0; status == 0 && i < seed_count; i++) {
        status = read_seed(argv[i + 3u], &seeds[i]) != 0;
    }
    state = (strtoull(argv[2], NULL, 10) + 1u) * UINT64_C(0x9e3779b97f4a7c15);
    status =
        status != 0 ? 1 : run(strtoull(argv[1], NULL, 10), seeds, seed_count);
    free(seeds);
    return status;
}
