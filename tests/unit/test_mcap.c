#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/crc32.h"
#include "cloud/mcap_file.h"
#include "cloud/part.h"
#include "cloud/ros_messages.h"
#include "cloud/ros_points.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define NS_PER_S INT64_C(1000000000)
#define BEGIN_NS (INT64_C(1767225605) * NS_PER_S + 71027)

static char directory[] = "/tmp/lum-mcap-XXXXXX";
static char path[64];
static lum_crc32 crc;

static int make_directory(void **state)
{
    (void)state;
    lum_crc32_init(&crc);
    if (mkdtemp(directory) == NULL) {
        return -1;
    }
    snprintf(path, sizeof path, "%s/out.mcap", directory);
    return 0;
}

/* Whatever is left would keep it. */
static int remove_directory(void **state)
{
    (void)state;
    return rmdir(directory);
}

static bool exists(void)
{
    struct stat status;
    return lstat(path, &status) == 0;
}

/* --- A small reader --- */

struct bytes {
    const uint8_t *at;
    size_t left;
};

static uint64_t take(struct bytes *b, size_t n)
{
    uint64_t v = 0;
    assert_true(b->left >= n);
    for (size_t i = 0; i < n; i++) {
        v |= (uint64_t)b->at[i] << 8u * i;
    }
    b->at += n;
    b->left -= n;
    return v;
}

static struct bytes take_part(struct bytes *b, size_t n)
{
    const struct bytes part = {b->at, n};
    assert_true(b->left >= n);
    b->at += n;
    b->left -= n;
    return part;
}

/* A text, or anything that has a length of 32 bits. */
static struct bytes take_text(struct bytes *b)
{
    return take_part(b, (size_t)take(b, 4));
}

static void expect_text(struct bytes text, const char *want)
{
    assert_int_equal(text.left, strlen(want));
    assert_memory_equal(text.at, want, text.left);
}

struct record {
    uint8_t op;
    size_t offset;
    struct bytes content;
};

struct file {
    uint8_t *bytes;
    size_t size;
    struct record records[400];
    size_t count;
    size_t of[16]; /* by opcode */
};

static void take_records(struct file *f, struct bytes *b)
{
    while (b->left > 8u) {
        const size_t offset = (size_t)(b->at - f->bytes);
        const uint8_t op = (uint8_t)take(b, 1);
        const struct bytes content = take_part(b, (size_t)take(b, 8));
        assert_true(op > 0 && op < 16u && f->count < 400u);
        f->records[f->count++] = (struct record){op, offset, content};
        f->of[op]++;
    }
}

static const uint8_t magic[8] = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

/* Reads a file, and removes it. */
static void read_file(struct file *f)
{
    FILE *in = fopen(path, "r");
    struct stat status;
    assert_non_null(in);
    assert_int_equal(fstat(fileno(in), &status), 0);
    *f = (struct file){.size = (size_t)status.st_size};
    f->bytes = malloc(f->size + 1u);
    assert_non_null(f->bytes);
    assert_int_equal(fread(f->bytes, 1, f->size, in), f->size);
    fclose(in);
    assert_int_equal(unlink(path), 0);
    struct bytes b = {f->bytes, f->size};
    assert_memory_equal(take_part(&b, 8).at, magic, 8);
    take_records(f, &b);
    if (f->of[0x02] > 0) {
        assert_int_equal(b.left, 8);
        assert_memory_equal(b.at, magic, 8);
    }
}

static const struct record *find(const struct file *f, uint8_t op, size_t nth)
{
    for (size_t i = 0; i < f->count; i++) {
        if (f->records[i].op == op && nth-- == 0) {
            return &f->records[i];
        }
    }
    fail();
    return NULL;
}

struct chunk {
    uint64_t begin;
    uint64_t end;
    uint64_t size;
    char compression[8];
    struct bytes records;
};

static struct chunk chunk_of(const struct record *r)
{
    struct bytes b = r->content;
    struct chunk c = {.begin = take(&b, 8)};
    c.end = take(&b, 8);
    c.size = take(&b, 8);
    const uint32_t sum = (uint32_t)take(&b, 4);
    const struct bytes name = take_text(&b);
    memcpy(c.compression, name.at, name.left);
    c.records = take_part(&b, (size_t)take(&b, 8));
    assert_int_equal(b.left, 0);
    if (name.left == 0) {
        assert_int_equal(c.records.left, c.size);
        assert_int_equal(sum,
                         lum_crc32_add(&crc, 0, c.records.at, (size_t)c.size));
    }
    return c;
}

struct message {
    unsigned channel;
    uint32_t sequence;
    uint64_t time;
    struct bytes data;
};

static struct message take_message(struct bytes *b)
{
    assert_int_equal(take(b, 1), 0x05);
    struct bytes content = take_part(b, (size_t)take(b, 8));
    struct message m = {.channel = (unsigned)take(&content, 2)};
    m.sequence = (uint32_t)take(&content, 4);
    m.time = take(&content, 8);
    assert_int_equal(take(&content, 8), m.time);
    m.data = content;
    return m;
}

/* The nth message of a topic, in files whose chunks are not compressed. */
static struct message find_message(const struct file *f, unsigned topic,
                                   size_t nth)
{
    for (size_t i = 0; i < f->of[0x06]; i++) {
        struct bytes b = chunk_of(find(f, 0x06, i)).records;
        while (b.left > 0) {
            const struct message m = take_message(&b);
            if (m.channel == topic + 1u && nth-- == 0) {
                return m;
            }
        }
    }
    fail();
    return (struct message){0};
}

struct cloud {
    int64_t stamp_ns;
    uint32_t width;
    const uint8_t *points;
};

static struct cloud cloud_of(struct message m)
{
    struct bytes b = m.data;
    struct cloud c = {0};
    assert_int_equal(take(&b, 4), 0x100);
    c.stamp_ns = (int64_t)take(&b, 4) * NS_PER_S;
    c.stamp_ns += (int64_t)take(&b, 4);
    assert_int_equal(c.stamp_ns, m.time);
    assert_string_equal((const char *)take_text(&b).at, "luminar");
    assert_int_equal(take(&b, 4), 1); /* height */
    c.width = (uint32_t)take(&b, 4);
    assert_true(b.left >= (size_t)c.width * 24u);
    assert_int_equal(m.data.at[m.data.left - 1u], 1); /* is_dense */
    c.points = m.data.at + m.data.left - 1u - (size_t)c.width * 24u;
    return c;
}

static float float_at(const struct cloud *c, size_t i, size_t offset)
{
    struct bytes b = {c->points + i * 24u + offset, 4};
    const uint32_t bits = (uint32_t)take(&b, 4);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static unsigned ring_at(const struct cloud *c, size_t i)
{
    return c->points[i * 24u + 20u] | (unsigned)c->points[i * 24u + 21u] << 8;
}

/* --- Writing --- */

static lum_calibration calibration;

static lum_writer *open_as(const lum_mcap_options *mcap)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_MCAP,
                                        .comment = "# lumsdk origin 1",
                                        .mcap = mcap};
    lum_writer *writer = NULL;
    lum_error error = {""};
    if (lum_writer_open(path, &options, &writer, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return writer;
}

static lum_writer *open_of(unsigned contents)
{
    lum_calibration_default(&calibration);
    return open_as(&(lum_mcap_options){.struct_size = sizeof(lum_mcap_options),
                                       .calibration = &calibration,
                                       .calibration_yaml = "a: 1\n",
                                       .is_plain = true,
                                       .contents = contents});
}

static lum_writer *open_plain(void)
{
    return open_of(0);
}

static const lum_sample samples[2] = {{.x = 1.5f,
                                       .y = -2.0f,
                                       .z = 0.25f,
                                       .pulse_width = 4.5f,
                                       .pixel = 1,
                                       .return_number = 1},
                                      {.x = 3.0f, .return_number = 300}};

static int add_to(lum_writer *writer, int64_t frame, unsigned eye,
                  uint32_t number, float time, lum_error *error)
{
    const float times[2] = {time, time + 0.001f};
    return lum_writer_add(
        writer,
        &(lum_line_samples){.struct_size = sizeof(lum_line_samples),
                            .samples = samples,
                            .count = 2,
                            .frame = frame,
                            .line = number,
                            .eye = (uint8_t)eye,
                            .times = times},
        error);
}

static void add(lum_writer *writer, unsigned eye, uint32_t number, float time)
{
    assert_int_equal(add_to(writer, 0, eye, number, time, NULL), 0);
}

static void add_frame(lum_writer *writer, int64_t utc_ns)
{
    assert_int_equal(lum_writer_begin_frame(writer, utc_ns, NULL), 0);
    add(writer, LUM_EYE_BLUE, 0, 0.0f);
    add(writer, LUM_EYE_GREEN, 0, 0.002f);
    assert_int_equal(lum_writer_end_frame(writer, NULL), 0);
}

static const lum_status_value value = {"lost_words", "7"};
static const lum_writer_status status = {.struct_size = sizeof status,
                                         .time_ns = BEGIN_NS,
                                         .level = LUM_STATUS_WARN,
                                         .name = "n",
                                         .message = "me",
                                         .hardware_id = "h",
                                         .values = &value,
                                         .count = 1};

static void close_writer(lum_writer *writer)
{
    lum_error error = {""};
    if (lum_writer_close(writer, &error) != 0) {
        fail_msg("%s", error.text);
    }
}

/* --- CRC, CDR, messages --- */

static void crc_is_that_of_zip(void **state)
{
    uint8_t bytes[100];
    (void)state;
    assert_int_equal(lum_crc32_add(&crc, 0, "123456789", 9), 0xcbf43926u);
    assert_int_equal(lum_crc32_add(&crc, 0, "", 0), 0);
    for (size_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = (uint8_t)(i * 37u);
    }
    const uint32_t whole = lum_crc32_add(&crc, 0, bytes, sizeof bytes);
    for (size_t i = 0; i <= sizeof bytes; i++) {
        const uint32_t head = lum_crc32_add(&crc, 0, bytes, i);
        assert_int_equal(lum_crc32_add(&crc, head, bytes + i, sizeof bytes - i),
                         whole);
    }
}

/* All lengths around its steps, from all places in a word, after some bytes. */
static void crc_is_the_same_by_table(void **state)
{
    uint8_t bytes[400];
    lum_crc32 by_table = crc;
    (void)state;
    by_table.has_clmul = false;
    for (size_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = (uint8_t)(i * i * 37u + i / 7u);
    }
    for (size_t from = 0; from < 16u; from++) {
        for (size_t n = 0; from + n <= sizeof bytes; n++) {
            const uint32_t before = (uint32_t)(n * 2654435761u);
            assert_int_equal(lum_crc32_add(&crc, before, bytes + from, n),
                             lum_crc32_add(&by_table, before, bytes + from, n));
        }
    }
}

static void cdr_aligns_from_behind_its_head(void **state)
{
    static const uint8_t want[] = {
        0, 1,    0,    0,                           /* plain, little-endian */
        9, 0,    0,    0,                           /* a byte, to 4 */
        3, 0,    0,    0,    'a',  'b', 0,          /* with its NUL */
        0, 0x78, 0x56, 0x34, 0x12,                  /* to 4 */
        7, 0,    0,    0,    0,    0,   0,    0,    /* to 8 */
        0, 0,    0,    0,    0,    0,   0xf8, 0x3f, /* 1.5 */
        1, 0,    0,    0,    0};                    /* an empty text */
    lum_bytes bytes = {0};
    (void)state;
    lum_bytes_put_u16(&bytes, 0); /* alignment does not count from here */
    lum_cdr cdr = lum_cdr_begin(&bytes);
    lum_cdr_put_u8(&cdr, 9);
    lum_cdr_put_string(&cdr, "ab");
    lum_cdr_put_u32(&cdr, 0x12345678u);
    lum_cdr_put_u8(&cdr, 7);
    lum_cdr_put_f64(&cdr, 1.5);
    lum_cdr_put_string(&cdr, "");
    assert_false(bytes.failed);
    assert_int_equal(bytes.len, 2u + sizeof want);
    assert_memory_equal(bytes.at + 2, want, sizeof want);
    lum_bytes_free(&bytes);
}

static void a_cloud_is_as_ros_2_has_it(void **state)
{
    static const uint8_t
        want[] = {0,   1,   0,   0,   5,   0,   0,   0,   6,   0,   0,
                  0,                                    /* 5 s, 6 ns */
                  2,   0,   0,   0,   'f', 0,   0,   0, /* frame_id */
                  1,   0,   0,   0,   1,   0,   0,   0,   8,   0,   0,
                  0, /* height, width */
                  2,   0,   0,   0,   'x', 0,   0,   0,   0,   0,   0,
                  0,   7,   0,   0,   0,   1,   0,   0,   0,   2,   0,
                  0,   0,   'y', 0,   0,   0,   4,   0,   0,   0,   7,
                  0,   0,   0,   1,   0,   0,   0,   2,   0,   0,   0,
                  'z', 0,   0,   0,   8,   0,   0,   0,   7,   0,   0,
                  0,   1,   0,   0,   0,   10,  0,   0,   0,   'i', 'n',
                  't', 'e', 'n', 's', 'i', 't', 'y', 0,   0,   0,   12,
                  0,   0,   0,   7,   0,   0,   0,   1,   0,   0,   0,
                  5,   0,   0,   0,   't', 'i', 'm', 'e', 0,   0,   0,
                  0,   16,  0,   0,   0,   7,   0,   0,   0,   1,   0,
                  0,   0,   5,   0,   0,   0,   'r', 'i', 'n', 'g', 0,
                  0,   0,   0,   20,  0,   0,   0,   4,   0,   0,   0,
                  1,   0,   0,   0,   7,   0,   0,   0,   'r', 'e', 't',
                  'u', 'r', 'n', 0,   0,   22,  0,   0,   0,   2,   0,
                  0,   0,   1,   0,   0,   0,   4,   0,   0,   0,   'e',
                  'y', 'e', 0,   23,  0,   0,   0,   2,   0,   0,   0,
                  1,   0,   0,   0,   0,   0,   0,   0,   24,  0,   0,
                  0,   24,  0,   0,   0,   24,  0,   0,   0};
    lum_bytes bytes = {0};
    (void)state;
    const lum_extras none = {0};
    lum_cdr cdr = lum_ros_begin_cloud(&bytes, 5 * NS_PER_S + 6, "f", 1, &none);
    assert_int_equal(bytes.len, sizeof want);
    assert_memory_equal(bytes.at, want, sizeof want);
    lum_ros_end_cloud(&cdr);
    assert_int_equal(bytes.len, sizeof want + 1u);
    assert_int_equal(bytes.at[sizeof want], 1);
    lum_bytes_free(&bytes);
}

static double double_at(const lum_bytes *bytes, size_t at)
{
    struct bytes b = {bytes->at + at, 8};
    const uint64_t bits = take(&b, 8);
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static void mounts_are_transforms(void **state)
{
    lum_bytes bytes = {0};
    lum_calibration c;
    (void)state;
    lum_calibration_default(&c);
    c.eye[LUM_EYE_BLUE].mount_um[1] = -250000;
    c.eye[LUM_EYE_BLUE].mount_yaw_udeg = 0;
    c.eye[LUM_EYE_BLUE].mount_roll_udeg = 90000000;
    char children[LUM_EYES][LUM_ROS_CHILD_BYTES];
    lum_ros_transform transforms[LUM_EYES];
    lum_ros_find_mounts("f", &c, children, transforms);
    lum_ros_put_transforms(&bytes, 5 * NS_PER_S, transforms, LUM_EYES);
    /* count, stamp, "f", "f_blue", then doubles */
    assert_int_equal(bytes.at[4], 2);
    assert_string_equal((const char *)bytes.at + 28, "f_blue");
    const size_t first = 4u + 32u;
    assert_true(double_at(&bytes, first) == 0.0);
    assert_true(double_at(&bytes, first + 8u) == -0.25);
    assert_float_equal(double_at(&bytes, first + 24u), 0.70710678, 1e-8);
    assert_float_equal(double_at(&bytes, first + 48u), 0.70710678, 1e-8);
    /* the same again: stamp, "f", "f_green", doubles */
    const size_t second = first + 56u + 32u;
    assert_float_equal(double_at(&bytes, second + 40u), 0.25881905, 1e-8);
    assert_float_equal(double_at(&bytes, second + 48u), 0.96592583, 1e-8);
    assert_int_equal(bytes.len, second + 56u);
    lum_bytes_free(&bytes);
}

static void a_status_is_an_array_of_one(void **state)
{
    static const uint8_t want[] = {0,   1,   0,   0,   0,   0,   0,   0,   0,
                                   0,   0,   0, /* before 1970: none */
                                   1,   0,   0,   0,   0,   0,   0,   0,   1,
                                   0,   0,   0, /* no frame_id, one status */
                                   1,   0,   0,   0,   2,   0,   0,   0,   'n',
                                   0,   0,   0,   3,   0,   0,   0,   'm', 'e',
                                   0,   0,   2,   0,   0,   0,   'h', 0,   0,
                                   0,   1,   0,   0,   0,   11,  0,   0,   0,
                                   'l', 'o', 's', 't', '_', 'w', 'o', 'r', 'd',
                                   's', 0,   0,   2,   0,   0,   0,   '7', 0};
    lum_writer_status s = status;
    lum_bytes bytes = {0};
    (void)state;
    s.time_ns = -5;
    lum_ros_put_status(&bytes, &s);
    assert_int_equal(bytes.len, sizeof want);
    assert_memory_equal(bytes.at, want, sizeof want);
    lum_bytes_free(&bytes);
}

static void seconds_beyond_32_bits_are_the_last(void **state)
{
    lum_writer_status s = status;
    lum_bytes bytes = {0};
    (void)state;
    s.time_ns = INT64_MAX;
    lum_ros_put_status(&bytes, &s);
    struct bytes b = {bytes.at + 4, 8};
    assert_int_equal(take(&b, 4), INT32_MAX);
    assert_true(take(&b, 4) < NS_PER_S);
    lum_bytes_free(&bytes);
}

static const uint8_t payload[] = {0xa1, 0xa2, 0xa3};
static const lum_writer_datagram datagram = {.time_ns = 3 * NS_PER_S + 9,
                                             .payload = payload,
                                             .len = sizeof payload,
                                             .source = 0x0a2a0025,
                                             .destination = 0x0a2a0001,
                                             .source_port = 5517,
                                             .destination_port = 0x1234};

static void a_datagram_is_as_documented(void **state)
{
    static const uint8_t want[] = {
        0,    1,    0,    0,    3,    0,    0,    0,    9,    0,    0,    0,
        0x0a, 0x2a, 0x00, 0x25, 0x8d, 0x15, 0x0a, 0x2a, 0x00, 0x01, 0x34, 0x12,
        3,    0,    0,    0,    3,    0,    0,    0,    0xa1, 0xa2, 0xa3};
    lum_bytes bytes = {0};
    (void)state;
    lum_ros_put_datagram(&bytes, &datagram);
    assert_int_equal(bytes.len, sizeof want);
    assert_memory_equal(bytes.at, want, sizeof want);
    lum_bytes_free(&bytes);
}

static void bytes_remember_that_memory_was_short(void **state)
{
    lum_bytes bytes = {0};
    (void)state;
    lum_bytes_put_u32(&bytes, 5);
    assert_null(lum_bytes_extend(&bytes, SIZE_MAX / 2u));
    assert_true(bytes.failed);
    lum_bytes_put_u32(&bytes, 5);
    assert_int_equal(bytes.len, 4);
    lum_bytes_end_u32(&bytes, lum_bytes_begin_u32(&bytes));
    lum_bytes_free(&bytes);
    assert_false(bytes.failed);
}

/* --- Files --- */

/* What the index says of each message is where that message is. */
static void expect_indexes(const struct file *f)
{
    size_t messages = 0;
    for (size_t i = 0; i < f->of[0x08]; i++) {
        struct bytes b = find(f, 0x08, i)->content;
        const struct record *chunk = find(f, 0x06, i);
        const struct chunk c = chunk_of(chunk);
        assert_int_equal(take(&b, 8), c.begin);
        assert_int_equal(take(&b, 8), c.end);
        assert_int_equal(take(&b, 8), chunk->offset);
        assert_int_equal(take(&b, 8), 9u + chunk->content.left);
        struct bytes map = take_text(&b);
        const uint64_t after = chunk->offset + 9u + chunk->content.left;
        const uint64_t index_length = take(&b, 8);
        expect_text(take_text(&b), c.compression);
        assert_int_equal(take(&b, 8), c.records.left);
        assert_int_equal(take(&b, 8), c.size);
        assert_int_equal(b.left, 0);
        while (map.left > 0) {
            const unsigned channel = (unsigned)take(&map, 2);
            const uint64_t at = take(&map, 8);
            assert_true(at >= after && at < after + index_length);
            struct bytes index = {f->bytes + at, f->size - (size_t)at};
            assert_int_equal(take(&index, 1), 0x07);
            (void)take(&index, 8);
            assert_int_equal(take(&index, 2), channel);
            for (struct bytes e = take_text(&index); e.left > 0; messages++) {
                const uint64_t time = take(&e, 8);
                const size_t offset = (size_t)take(&e, 8);
                struct bytes at_message = {c.records.at + offset,
                                           c.records.left - offset};
                const struct message m = take_message(&at_message);
                assert_int_equal(m.channel, channel);
                assert_int_equal(m.time, time);
            }
        }
    }
    struct bytes statistics = find(f, 0x0b, 0)->content;
    assert_int_equal(take(&statistics, 8), messages);
}

/* The footer's sum, and where groups stand. */
static void expect_summary(const struct file *f)
{
    struct bytes footer = find(f, 0x02, 0)->content;
    const size_t start = (size_t)take(&footer, 8);
    const size_t offsets = (size_t)take(&footer, 8);
    const uint32_t sum = (uint32_t)take(&footer, 4);
    assert_int_equal(footer.left, 0);
    assert_int_equal(start, find(f, 0x0f, 0)->offset + 13u);
    assert_int_equal(offsets, find(f, 0x0e, 0)->offset);
    assert_int_equal(sum, lum_crc32_add(&crc, 0, f->bytes + start,
                                        f->size - start - 8u - sizeof sum));
    size_t next = start;
    for (size_t i = 0; i < f->of[0x0e]; i++) {
        struct bytes b = find(f, 0x0e, i)->content;
        const uint8_t op = (uint8_t)take(&b, 1);
        assert_int_equal(take(&b, 8), next);
        assert_int_equal(f->bytes[next], op);
        next += (size_t)take(&b, 8);
    }
    assert_int_equal(next, offsets);
}

static void a_file_has_all_its_parts(void **state)
{
    struct file f;
    (void)state;
    lum_writer *writer = open_plain();
    add_frame(writer, BEGIN_NS);
    add_frame(writer, BEGIN_NS + NS_PER_S / 10);
    assert_int_equal(lum_writer_add_status(writer, &status, NULL), 0);
    close_writer(writer);
    read_file(&f);
    struct bytes header = find(&f, 0x01, 0)->content;
    expect_text(take_text(&header), "ros2");
    assert_int_equal(f.of[0x06], 1);
    assert_int_equal(f.of[0x03], 6); /* schemas; again in the summary */
    assert_int_equal(f.of[0x04], 6);
    assert_int_equal(f.of[0x09], 1);
    assert_int_equal(f.of[0x0c], 1);
    expect_indexes(&f);
    expect_summary(&f);
    struct bytes attachment = find(&f, 0x09, 0)->content;
    const uint8_t *begin = attachment.at;
    (void)take_part(&attachment, 16);
    expect_text(take_text(&attachment), "calibration.yaml");
    expect_text(take_text(&attachment), "application/yaml");
    expect_text(take_part(&attachment, (size_t)take(&attachment, 8)), "a: 1\n");
    const size_t n = (size_t)(attachment.at - begin);
    assert_int_equal(take(&attachment, 4), lum_crc32_add(&crc, 0, begin, n));
    struct bytes statistics = find(&f, 0x0b, 0)->content;
    assert_int_equal(take(&statistics, 8), 4);
    assert_int_equal(take(&statistics, 2), 3);
    assert_int_equal(take(&statistics, 4), 3);
    assert_int_equal(take(&statistics, 4), 1);
    assert_int_equal(take(&statistics, 4), 1);
    assert_int_equal(take(&statistics, 4), 1);
    assert_int_equal(take(&statistics, 8), BEGIN_NS);
    assert_int_equal(take(&statistics, 8), BEGIN_NS + NS_PER_S / 10);
    assert_int_equal(find_message(&f, LUM_ROS_TF_STATIC, 0).time, BEGIN_NS);
    assert_int_equal(find_message(&f, LUM_ROS_POINTS, 1).sequence, 1);
    free(f.bytes);
}

static void a_file_without_messages_is_whole(void **state)
{
    struct file f;
    (void)state;
    close_writer(open_plain());
    read_file(&f);
    assert_int_equal(f.of[0x06], 0);
    expect_indexes(&f);
    expect_summary(&f);
    free(f.bytes);
}

static void points_are_in_order_of_time(void **state)
{
    static const float want[] = {0.0f,   0.001f, 0.002f, 0.003f,
                                 0.004f, 0.005f, 0.006f, 0.007f};
    static const unsigned eyes[] = {1, 1, 0, 0, 1, 1, 0, 0};
    struct file f;
    (void)state;
    lum_writer *writer = open_plain();
    assert_int_equal(lum_writer_begin_frame(writer, BEGIN_NS, NULL), 0);
    add(writer, LUM_EYE_BLUE, 3, 0.507f); /* comes before an earlier one */
    add(writer, LUM_EYE_BLUE, 2, 0.503f);
    add(writer, LUM_EYE_GREEN, 1, 0.501f);
    add(writer, LUM_EYE_GREEN, 2, 0.505f);
    close_writer(writer);
    read_file(&f);
    const struct cloud c = cloud_of(find_message(&f, LUM_ROS_POINTS, 0));
    assert_int_equal(c.width, 8);
    assert_true(llabs(c.stamp_ns - BEGIN_NS - 501000000) < 100);
    for (size_t i = 0; i < 8u; i++) {
        assert_float_equal(float_at(&c, i, 16), want[i], 1e-6);
        assert_int_equal(c.points[i * 24u + 23u], eyes[i]);
    }
    assert_true(float_at(&c, 0, 0) == 1.5f && float_at(&c, 0, 4) == -2.0f &&
                float_at(&c, 0, 8) == 0.25f && float_at(&c, 0, 12) == 4.5f);
    assert_int_equal(c.points[22], 1);
    assert_int_equal(c.points[24u + 22u], 255); /* the 300th */
    free(f.bytes);
}

static unsigned green_ring(lum_writer *writer, uint32_t a, uint32_t b)
{
    struct file f;
    assert_int_equal(lum_writer_begin_frame(writer, BEGIN_NS, NULL), 0);
    add(writer, LUM_EYE_BLUE, a, 0.1f);
    add(writer, LUM_EYE_GREEN, b, 0.0f);
    close_writer(writer);
    read_file(&f);
    const struct cloud c = cloud_of(find_message(&f, LUM_ROS_POINTS, 0));
    assert_int_equal(ring_at(&c, 2), a < 32767u ? a : UINT16_MAX);
    const unsigned ring = ring_at(&c, 0);
    free(f.bytes);
    return ring;
}

static void rings_are_lines_of_both_eyes(void **state)
{
    (void)state;
    assert_int_equal(green_ring(open_plain(), 5, 63), 64 + 63);
    assert_int_equal(green_ring(open_plain(), 5, 64), UINT16_MAX);
    assert_int_equal(green_ring(open_plain(), 64, 64), 640 + 64);
    assert_int_equal(green_ring(open_plain(), 639, 639), 640 + 639);
    assert_int_equal(green_ring(open_plain(), 640, 640), 32767 + 640);
    assert_int_equal(green_ring(open_plain(), 70, UINT32_MAX), UINT16_MAX);
}

static void lines_alone_make_frames(void **state)
{
    const float none = 0.0f;
    struct file f;
    (void)state;
    lum_writer *writer = open_plain();
    lum_line_samples line = {.struct_size = sizeof line,
                             .samples = samples,
                             .count = 2,
                             .frame = 7,
                             .timestamp_us = 5000000};
    assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
    line.timestamp_us += 250000;
    assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
    line.frame = 8;
    line.timestamp_us = LUM_TIMESTAMP_NONE;
    assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
    close_writer(writer);
    read_file(&f);
    const struct cloud a = cloud_of(find_message(&f, LUM_ROS_POINTS, 0));
    const struct cloud b = cloud_of(find_message(&f, LUM_ROS_POINTS, 1));
    assert_int_equal(a.width, 4);
    assert_int_equal(a.stamp_ns, 5 * NS_PER_S);
    assert_true(float_at(&a, 1, 16) == none && float_at(&a, 2, 16) == 0.25f);
    assert_int_equal(b.width, 2);
    assert_int_equal(b.stamp_ns, 0);
    free(f.bytes);
}

/* --- Other contents --- */

static void a_line_is_a_message(void **state)
{
    static const unsigned eyes[] = {1, 0, 1, 0};
    static const unsigned numbers[] = {1, 2, 2, 3};
    struct file f;
    (void)state;
    lum_writer *writer = open_of(LUM_MCAP_OF_LINES);
    assert_int_equal(lum_writer_begin_frame(writer, BEGIN_NS, NULL), 0);
    add(writer, LUM_EYE_BLUE, 3, 0.507f); /* comes before an earlier one */
    add(writer, LUM_EYE_BLUE, 2, 0.503f);
    add(writer, LUM_EYE_GREEN, 1, 0.501f);
    add(writer, LUM_EYE_GREEN, 2, 0.505f);
    assert_int_equal(
        lum_writer_begin_frame(writer, BEGIN_NS + 2 * NS_PER_S, NULL), 0);
    add(writer, LUM_EYE_BLUE, 0, 0.0f);
    close_writer(writer);
    read_file(&f);
    for (size_t i = 0; i < 4u; i++) {
        const struct cloud c = cloud_of(find_message(&f, LUM_ROS_POINTS, i));
        const int64_t after = 501000000 + 2000000 * (int64_t)i;
        assert_int_equal(c.width, 2);
        assert_true(llabs(c.stamp_ns - BEGIN_NS - after) < 100);
        assert_true(float_at(&c, 0, 16) == 0.0f);
        assert_float_equal(float_at(&c, 1, 16), 0.001f, 1e-6);
        assert_int_equal(ring_at(&c, 0), eyes[i] * 64u + numbers[i]);
        assert_int_equal(c.points[23], eyes[i]);
    }
    const struct cloud last = cloud_of(find_message(&f, LUM_ROS_POINTS, 4));
    assert_int_equal(last.stamp_ns, BEGIN_NS + 2 * NS_PER_S);
    assert_int_equal(f.of[0x06], 2);
    free(f.bytes);
}

static void datagrams_stand_beside_frames(void **state)
{
    struct file f;
    (void)state;
    lum_writer *writer = open_of(LUM_MCAP_OF_FRAMES | LUM_MCAP_OF_DATAGRAMS);
    assert_int_equal(lum_writer_add_datagram(writer, &datagram, NULL), 0);
    add_frame(writer, BEGIN_NS);
    assert_int_equal(lum_writer_add_datagram(writer, &datagram, NULL), 0);
    close_writer(writer);
    read_file(&f);
    assert_int_equal(find_message(&f, LUM_ROS_DATAGRAMS, 1).time,
                     3 * NS_PER_S + 9);
    assert_int_equal(cloud_of(find_message(&f, LUM_ROS_POINTS, 0)).width, 4);
    expect_indexes(&f);
    expect_summary(&f);
    free(f.bytes);
}

static void datagrams_alone_need_no_clouds(void **state)
{
    struct file f;
    (void)state;
    lum_writer *writer = open_of(LUM_MCAP_OF_DATAGRAMS);
    add_frame(writer, BEGIN_NS); /* has no place */
    assert_int_equal(lum_writer_add_datagram(writer, &datagram, NULL), 0);
    close_writer(writer);
    read_file(&f);
    struct bytes schema = find(&f, 0x03, 1)->content;
    assert_int_equal(take(&schema, 2), 2);
    expect_text(take_text(&schema), "lumsdk_msgs/msg/Datagram");
    struct bytes statistics = find(&f, 0x0b, 0)->content;
    assert_int_equal(take(&statistics, 8), 1);
    assert_int_equal(take(&statistics, 2), 2);
    const struct message m = find_message(&f, 1, 0);
    assert_int_equal(m.data.left, 35);
    assert_int_equal(m.time, 3 * NS_PER_S + 9);
    expect_indexes(&f);
    free(f.bytes);
}

/* Where a reader looks before the first message. */
static void metadata_stands_before_channels(void **state)
{
    struct file f;
    (void)state;
    close_writer(open_plain());
    read_file(&f);
    assert_true(find(&f, 0x0c, 0)->offset < find(&f, 0x03, 0)->offset);
    free(f.bytes);
}

static void a_datagram_that_is_too_long_is_refused(void **state)
{
    lum_writer_datagram bad = datagram;
    lum_error error = {""};
    (void)state;
    lum_writer *writer = open_of(LUM_MCAP_OF_DATAGRAMS);
    bad.len = LUM_WRITER_DATAGRAM_BYTES_MAX + 1u;
    assert_int_equal(lum_writer_add_datagram(writer, &bad, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, "65508 bytes; at most 65507"));
    assert_int_equal(lum_writer_add_datagram(writer, &datagram, NULL), -1);
    lum_writer_abort(writer);
}

static void a_frame_without_points_is_a_cloud_without_width(void **state)
{
    struct file f;
    (void)state;
    lum_writer *writer = open_plain();
    assert_int_equal(lum_writer_end_frame(writer, NULL), 0); /* none */
    assert_int_equal(lum_writer_begin_frame(writer, BEGIN_NS, NULL), 0);
    close_writer(writer);
    read_file(&f);
    assert_int_equal(cloud_of(find_message(&f, LUM_ROS_POINTS, 0)).width, 0);
    free(f.bytes);
}

/* --- Chunks --- */

static void a_chunk_covers_a_second(void **state)
{
    struct file f;
    (void)state;
    lum_writer *writer = open_plain();
    for (int64_t i = 0; i < 25; i++) {
        add_frame(writer, BEGIN_NS + i * NS_PER_S / 10);
    }
    close_writer(writer);
    read_file(&f);
    assert_int_equal(f.of[0x06], 3);
    expect_indexes(&f);
    expect_summary(&f);
    for (size_t i = 0; i < 3u; i++) {
        const struct chunk c = chunk_of(find(&f, 0x06, i));
        assert_true(c.end - c.begin < NS_PER_S);
    }
    free(f.bytes);
}

static void a_chunk_ends_with_what_fills_it(void **state)
{
    enum {
        LINES = 45000 /* of two points: half a chunk */
    };
    struct file f;
    (void)state;
    lum_writer *writer = open_plain();
    for (int frame = 0; frame < 5; frame++) {
        assert_int_equal(lum_writer_begin_frame(writer, BEGIN_NS, NULL), 0);
        for (uint32_t i = 0; i < LINES; i++) {
            add(writer, LUM_EYE_BLUE, i, 0.0f);
        }
        assert_int_equal(lum_writer_end_frame(writer, NULL), 0);
    }
    close_writer(writer);
    read_file(&f);
    assert_int_equal(f.of[0x06], 3);
    expect_indexes(&f);
    for (size_t i = 0; i < 2u; i++) {
        const struct chunk c = chunk_of(find(&f, 0x06, i));
        assert_true(c.size >= LUM_MCAP_CHUNK_BYTES &&
                    c.size < 2u * LUM_MCAP_CHUNK_BYTES);
    }
    free(f.bytes);
}

static void chunks_are_compressed_where_that_is_built_in(void **state)
{
    struct file f;
    (void)state;
    lum_writer *writer = open_as(NULL);
    add_frame(writer, BEGIN_NS);
    close_writer(writer);
    read_file(&f);
    const struct chunk c = chunk_of(find(&f, 0x06, 0));
    assert_string_equal(c.compression, lum_mcap_can_compress() ? "zstd" : "");
    assert_true(lum_mcap_can_compress() ? c.records.left < c.size
                                        : c.records.left == c.size);
    expect_summary(&f);
    free(f.bytes);
}

/* --- Threads --- */

/* A line of a thousand points, until the next call; half of them come while the
 * other eye has its. */
static lum_line_samples long_line(uint32_t number)
{
    static lum_sample many[1000];
    static float times[1000];
    for (size_t i = 0; i < 1000u; i++) {
        many[i] = samples[i % 2u];
        many[i].x += (float)(i * number % 977u);
        times[i] = (float)(number * 500u + i) * 1e-7f;
    }
    return (lum_line_samples){.struct_size = sizeof(lum_line_samples),
                              .samples = many,
                              .times = times,
                              .count = 1000,
                              .line = number / 2u,
                              .eye = number & 1u};
}

static void add_long(lum_writer *writer, uint32_t number)
{
    const lum_line_samples line = long_line(number);
    assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
}

/* Frames that the sink gets without a copy, small ones, and a chunk that ends
 * because of its time. */
static void add_frames_of_all_sizes(lum_writer *writer)
{
    static const uint32_t lines[] = {1, 500, 3, 180, 520, 2, 360};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        const int64_t utc_ns = BEGIN_NS + (int64_t)i * NS_PER_S / 3;
        assert_int_equal(lum_writer_begin_frame(writer, utc_ns, NULL), 0);
        for (uint32_t k = 0; k < lines[i]; k++) {
            add_long(writer, k);
        }
        assert_int_equal(lum_writer_end_frame(writer, NULL), 0);
        assert_int_equal(lum_writer_add_status(writer, &status, NULL), 0);
    }
}

static void threads_write_the_same_bytes(void **state)
{
    static const unsigned threads[] = {0, 1, 2, 3, 8};
    (void)state;
    for (int plain = 0; plain < 2; plain++) {
        struct file files[2];
        for (size_t i = 0; i < sizeof threads / sizeof threads[0]; i++) {
            const lum_mcap_options mcap = {.struct_size = sizeof mcap,
                                           .is_plain = plain != 0};
            struct file *f = &files[i > 0 ? 1 : 0];
            lum_writer *writer = open_as(&mcap);
            lum_writer_pack_by(writer, threads[i]);
            add_frames_of_all_sizes(writer);
            close_writer(writer);
            read_file(f);
            if (plain != 0) {
                expect_indexes(f);
                expect_summary(f);
            }
            if (i > 0) {
                assert_int_equal(f->size, files[0].size);
                assert_memory_equal(f->bytes, files[0].bytes, f->size);
                free(f->bytes);
            }
        }
        free(files[0].bytes);
    }
}

static void a_flush_waits_for_the_threads(void **state)
{
    (void)state;
    lum_writer *writer = open_as(NULL);
    lum_writer_pack_by(writer, 3);
    add_frames_of_all_sizes(writer);
    assert_int_equal(lum_writer_flush(writer, NULL), 0);
    const uint64_t bytes = lum_writer_bytes(writer);
    assert_int_equal(lum_writer_flush(writer, NULL), 0);
    assert_true(bytes > 0 && lum_writer_bytes(writer) == bytes);
    lum_writer_abort(writer);
    assert_false(exists());
}

/* --- Points that are foreseen --- */

#define LONG_LINES 200u

enum order {
    IN_TURN,
    ONE_EYE,
    BLUE_FIRST,
    LATE,
    EMPTY,
    UNTIMED,
    ORDERS
};

static lum_line_samples ordered_line(enum order order, uint32_t k)
{
    lum_line_samples line = long_line(order == LATE && k > 9u ? k ^ 4u : k);
    line.eye = order == BLUE_FIRST ? k >= LONG_LINES / 2u : line.eye;
    line.eye = order == ONE_EYE ? LUM_EYE_GREEN : line.eye;
    line.count = order == EMPTY && k % 7u < 3u ? 0 : line.count;
    line.times = order == UNTIMED && k == 9u ? NULL : line.times;
    return line;
}

static void add_ordered(lum_writer *writer, enum order order, bool foresees)
{
    assert_int_equal(lum_writer_begin_frame(writer, BEGIN_NS, NULL), 0);
    for (uint32_t k = 0; k < LONG_LINES && foresees; k++) {
        const lum_line_samples line = ordered_line(order, k);
        lum_writer_foresee(writer, &line);
    }
    for (uint32_t k = 0; k < LONG_LINES; k++) {
        const lum_line_samples line = ordered_line(order, k);
        assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
    }
    assert_int_equal(lum_writer_end_frame(writer, NULL), 0);
}

static void expect_same_if_foreseen(const lum_mcap_options *mcap)
{
    struct file files[2];
    for (unsigned foresees = 0; foresees < 2u; foresees++) {
        lum_writer *writer = open_as(mcap);
        for (unsigned order = 0; order < ORDERS; order++) {
            add_ordered(writer, (enum order)order, foresees != 0);
            assert_int_equal(lum_writer_add_status(writer, &status, NULL), 0);
        }
        close_writer(writer);
        read_file(&files[foresees]);
        if (mcap->is_plain) {
            expect_indexes(&files[foresees]);
            expect_summary(&files[foresees]);
        }
    }
    assert_int_equal(files[0].size, files[1].size);
    assert_memory_equal(files[0].bytes, files[1].bytes, files[0].size);
    free(files[0].bytes);
    free(files[1].bytes);
}

/* Some are put while they are made, some are too small for that. */
static void foreseen_points_make_the_same_file(void **state)
{
    lum_mcap_options mcap = {.struct_size = sizeof mcap, .is_plain = true};
    (void)state;
    expect_same_if_foreseen(&mcap);
    mcap.contents = LUM_MCAP_OF_LINES;
    expect_same_if_foreseen(&mcap);
    mcap.contents = LUM_MCAP_OF_DATAGRAMS;
    expect_same_if_foreseen(&mcap);
    mcap.contents = LUM_MCAP_OF_FRAMES;
    mcap.is_growing = true;
    expect_same_if_foreseen(&mcap);
    expect_same_if_foreseen(&(lum_mcap_options){.struct_size = sizeof mcap});
}

/* What is expected is 5 MB in each of two messages. */
static void expect_room(bool can_patch, size_t least, size_t most)
{
    static const unsigned char zeros[50000];
    lum_mcap_file file = {0};
    lum_sink *sink = NULL;
    lum_bytes *out = NULL;
    assert_int_equal(lum_sink_open(path, &sink, NULL), 0);
    assert_int_equal(lum_mcap_begin(&file, sink, "l", false, NULL), 0);
    assert_int_equal(lum_mcap_add_channel(&file, "t", "u", "d", "q", NULL), 0);
    file.can_patch = can_patch;
    for (int64_t m = 0; m < 2; m++) {
        assert_int_equal(lum_mcap_begin_message(&file, 0, m, &out, NULL), 0);
        assert_int_equal(lum_mcap_expect(&file, 5000000, NULL), 0);
        for (unsigned i = 0; i < 100u; i++) {
            assert_int_equal(
                lum_mcap_put_expected(&file, zeros, sizeof zeros, NULL), 0);
        }
        assert_int_equal(lum_mcap_end_message(&file, NULL), 0);
    }
    assert_in_range(file.chunks[0].messages.room, least, most);
    assert_int_equal(lum_mcap_end(&file, NULL), 0);
    assert_int_equal(lum_sink_close(sink, NULL), 0);
    lum_mcap_free(&file);
    assert_int_equal(unlink(path), 0);
}

static void a_large_message_needs_no_memory_where_a_sum_can_be_patched(
    void **state)
{
    (void)state;
    expect_room(true, 1, 10000);
    expect_room(false, 5000000, 6000000);
}

static void a_large_message_that_is_given_up_leaves_nothing(void **state)
{
    (void)state;
    lum_writer *writer = open_plain();
    assert_int_equal(lum_writer_begin_frame(writer, BEGIN_NS, NULL), 0);
    for (uint32_t k = 0; k < LONG_LINES; k++) {
        const lum_line_samples line = long_line(k);
        lum_writer_foresee(writer, &line);
    }
    for (uint32_t k = 0; k < LONG_LINES / 2u; k++) {
        add_long(writer, k);
    }
    assert_true(lum_writer_bytes(writer) > 2000000u);
    lum_writer_abort(writer);
    assert_false(exists());
}

/* Of 4.8 MB no more than some lines wait for the other eye. */
static void foreseen_points_are_not_kept(void **state)
{
    lum_ros_points points = {0};
    size_t count = 0;
    float first_s = -1.0f;
    (void)state;
    for (uint32_t k = 0; k < LONG_LINES; k++) {
        const lum_line_samples line = long_line(k);
        lum_ros_points_foresee(&points, &line);
    }
    assert_true(lum_ros_points_can_merge(&points, &count, &first_s));
    assert_int_equal(count, LONG_LINES * 1000u);
    assert_true(first_s == 0.0f);
    const size_t bytes = lum_ros_points_bytes(&points);
    unsigned char *out = malloc(count * bytes);
    assert_non_null(out);
    unsigned char *to = out;
    for (uint32_t k = 0; k < LONG_LINES; k++) {
        const lum_line_samples line = long_line(k);
        assert_int_equal(lum_ros_points_add(&points, &line, 0.0f), 0);
        to = lum_ros_points_merge(&points, first_s, to);
    }
    assert_ptr_equal(to, out + count * bytes);
    assert_true(points.eyes[0].kept.room < 100000u &&
                points.eyes[1].kept.room < 100000u);
    lum_ros_points_end_merge(&points);
    assert_int_equal(lum_ros_points_count(&points), 0);
    assert_false(lum_ros_points_can_merge(&points, &count, &first_s));
    lum_ros_points_free(&points);
    free(out);
}

static void points_that_were_not_foreseen_are_refused(void **state)
{
    (void)state;
    for (uint32_t more = 0; more < 2u; more++) {
        lum_error error = {""};
        lum_writer *writer = open_plain();
        assert_int_equal(lum_writer_begin_frame(writer, BEGIN_NS, NULL), 0);
        for (uint32_t k = 0; k < 2u; k++) {
            const lum_line_samples line = long_line(2u * k);
            lum_writer_foresee(writer, &line);
        }
        add_long(writer, 0);
        if (more != 0) {
            const lum_line_samples line = long_line(1);
            assert_int_equal(lum_writer_add(writer, &line, &error), -1);
        } else {
            assert_int_equal(lum_writer_end_frame(writer, &error), -1);
        }
        assert_int_equal(errno, EINVAL);
        assert_non_null(strstr(error.text, "differ from those announced"));
        lum_writer_abort(writer);
        assert_false(exists());
    }
}

/* --- Recordings --- */

static lum_writer *open_growing(void)
{
    return open_as(&(lum_mcap_options){.struct_size = sizeof(lum_mcap_options),
                                       .is_plain = true,
                                       .is_growing = true});
}

/* Before anything but the beginning is there for him. */
static void a_recording_tells_that_the_reader_of_a_pipe_has_left(void **state)
{
    const lum_mcap_options mcap = {.struct_size = sizeof mcap,
                                   .is_growing = true};
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_MCAP,
                                        .mcap = &mcap};
    lum_writer *writer = NULL;
    int ends[2];
    char name[32];
    (void)state;
    assert_int_equal(pipe(ends), 0);
    (void)snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    assert_int_equal(lum_writer_open(name, &options, &writer, NULL), 0);
    assert_int_equal(lum_writer_flush(writer, NULL), 0);
    (void)close(ends[0]);
    assert_int_equal(lum_writer_flush(writer, NULL), -1);
    assert_int_equal(errno, EPIPE);
    lum_writer_abort(writer);
    (void)close(ends[1]);
}

/* What a kill leaves is what the file has now. */
static void a_recording_has_its_chunks_before_it_ends(void **state)
{
    const struct timespec moment = {0, 1000000};
    struct stat now = {0};
    struct file f;
    (void)state;
    lum_writer *writer = open_growing();
    assert_int_equal(lum_writer_flush(writer, NULL), 0);
    assert_false(exists());
    add_frame(writer, BEGIN_NS);
    assert_int_equal(lum_writer_flush(writer, NULL), 0);
    const uint64_t bytes = lum_writer_bytes(writer);
    while (stat(path, &now) != 0 || (uint64_t)now.st_size < bytes) {
        (void)nanosleep(&moment, NULL);
    }
    add_frame(writer, BEGIN_NS + 1); /* in no chunk yet */
    lum_writer_abort(writer);
    read_file(&f);
    assert_int_equal(f.of[0x06], 1);
    assert_int_equal(f.of[0x02], 0);
    assert_int_equal(cloud_of(find_message(&f, LUM_ROS_POINTS, 0)).width, 4);
    free(f.bytes);
}

static void a_recording_that_ends_is_whole(void **state)
{
    struct file f;
    (void)state;
    lum_writer *writer = open_growing();
    add_frame(writer, BEGIN_NS);
    assert_int_equal(lum_writer_flush(writer, NULL), 0);
    assert_int_equal(lum_writer_flush(writer, NULL), 0);
    add_frame(writer, BEGIN_NS + 1);
    close_writer(writer);
    read_file(&f);
    assert_int_equal(f.of[0x06], 2);
    expect_indexes(&f);
    expect_summary(&f);
    free(f.bytes);
}

static void a_recording_without_data_leaves_nothing(void **state)
{
    (void)state;
    lum_writer_abort(open_growing());
    assert_false(exists());
}

static void a_conversion_that_is_given_up_leaves_nothing(void **state)
{
    (void)state;
    lum_writer *writer = open_plain();
    add_frame(writer, BEGIN_NS);
    assert_int_equal(lum_writer_flush(writer, NULL), 0);
    lum_writer_abort(writer);
    assert_false(exists());
}

/* --- What is refused, what fails --- */

static void expect_full_disk(unsigned threads)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_MCAP};
    lum_writer *writer = NULL;
    lum_error error = {""};
    int result = 0;
    assert_int_equal(lum_writer_open("/dev/full", &options, &writer, NULL), 0);
    lum_writer_pack_by(writer, threads);
    for (int64_t i = 0; result == 0; i++) { /* until its thread has written */
        if (i < 100) {
            add_frame(writer, BEGIN_NS + i);
        }
        (void)nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL);
        result = lum_writer_flush(writer, &error);
    }
    assert_int_equal(result, -1);
    assert_int_equal(errno, ENOSPC);
    assert_non_null(strstr(error.text, "/dev/full"));
    assert_int_equal(lum_writer_begin_frame(writer, 0, NULL), -1);
    assert_int_equal(lum_writer_end_frame(writer, NULL), -1);
    assert_int_equal(lum_writer_add_status(writer, &status, NULL), -1);
    assert_int_equal(lum_writer_close(writer, &error), -1);
    assert_int_equal(errno, ENOSPC);
}

static void a_full_disk_is_reported_and_stays_so(void **state)
{
    (void)state;
    expect_full_disk(0);
    expect_full_disk(2);
}

static void refuse(const lum_mcap_options *mcap, const char *says)
{
    const lum_writer_options options = {
        .struct_size = sizeof options, .format = LUM_FORMAT_MCAP, .mcap = mcap};
    lum_writer *writer = NULL;
    lum_error error = {""};
    assert_int_equal(lum_writer_open(path, &options, &writer, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, says));
    assert_false(exists());
}

static void options_that_are_none_are_refused(void **state)
{
    char id[LUM_MCAP_FRAME_ID_MAX + 2u] = "";
    lum_mcap_options mcap = {.struct_size = sizeof mcap, .frame_id = ""};
    (void)state;
    refuse(&(lum_mcap_options){0}, "lum_mcap_options");
    mcap.frame_id = NULL;
    mcap.contents = 8;
    refuse(&mcap, "contents that MCAP does not have");
    mcap.contents = LUM_MCAP_OF_FRAMES | LUM_MCAP_OF_LINES;
    refuse(&mcap, "of a frame or of a line, not both");
    mcap.contents = 0;
    mcap.frame_id = "";
    refuse(&mcap, "frame_id of 0 bytes");
    memset(id, 'x', LUM_MCAP_FRAME_ID_MAX + 1u);
    mcap.frame_id = id;
    refuse(&mcap, "frame_id of 201 bytes");
    id[LUM_MCAP_FRAME_ID_MAX] = '\0';
    lum_calibration_default(&calibration);
    mcap.calibration = &calibration;
    lum_writer *writer = open_as(&mcap);
    add_frame(writer, BEGIN_NS);
    close_writer(writer);
    assert_int_equal(unlink(path), 0);
}

static void a_status_without_its_size_is_refused(void **state)
{
    lum_writer_status bad = status;
    lum_error error = {""};
    (void)state;
    bad.struct_size = 0;
    lum_writer *writer = open_plain();
    assert_int_equal(lum_writer_add_status(writer, &bad, &error), -1);
    assert_non_null(strstr(error.text, "lum_writer_status"));
    lum_writer_abort(writer);
}

static void other_formats_have_no_frames(void **state)
{
    const lum_writer_options options = {.struct_size = sizeof options};
    lum_writer *writer = NULL;
    (void)state;
    assert_true(lum_format_has_frames(LUM_FORMAT_MCAP));
    assert_false(lum_format_has_frames(LUM_FORMAT_CSV));
    assert_false(lum_format_has_frames(LUM_FORMATS));
    assert_int_equal(lum_writer_open(path, &options, &writer, NULL), 0);
    add_frame(writer, 0);
    assert_int_equal(lum_writer_add_status(writer, &status, NULL), 0);
    assert_int_equal(lum_writer_add_datagram(writer, &datagram, NULL), 0);
    close_writer(writer);
    assert_int_equal(unlink(path), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(crc_is_that_of_zip),
        cmocka_unit_test(crc_is_the_same_by_table),
        cmocka_unit_test(cdr_aligns_from_behind_its_head),
        cmocka_unit_test(a_cloud_is_as_ros_2_has_it),
        cmocka_unit_test(mounts_are_transforms),
        cmocka_unit_test(a_status_is_an_array_of_one),
        cmocka_unit_test(seconds_beyond_32_bits_are_the_last),
        cmocka_unit_test(a_datagram_is_as_documented),
        cmocka_unit_test(bytes_remember_that_memory_was_short),
        cmocka_unit_test(a_file_has_all_its_parts),
        cmocka_unit_test(a_file_without_messages_is_whole),
        cmocka_unit_test(points_are_in_order_of_time),
        cmocka_unit_test(rings_are_lines_of_both_eyes),
        cmocka_unit_test(lines_alone_make_frames),
        cmocka_unit_test(a_line_is_a_message),
        cmocka_unit_test(datagrams_stand_beside_frames),
        cmocka_unit_test(datagrams_alone_need_no_clouds),
        cmocka_unit_test(metadata_stands_before_channels),
        cmocka_unit_test(a_datagram_that_is_too_long_is_refused),
        cmocka_unit_test(a_frame_without_points_is_a_cloud_without_width),
        cmocka_unit_test(a_chunk_covers_a_second),
        cmocka_unit_test(a_chunk_ends_with_what_fills_it),
        cmocka_unit_test(chunks_are_compressed_where_that_is_built_in),
        cmocka_unit_test(threads_write_the_same_bytes),
        cmocka_unit_test(a_flush_waits_for_the_threads),
        cmocka_unit_test(foreseen_points_make_the_same_file),
        cmocka_unit_test(
            a_large_message_needs_no_memory_where_a_sum_can_be_patched),
        cmocka_unit_test(a_large_message_that_is_given_up_leaves_nothing),
        cmocka_unit_test(foreseen_points_are_not_kept),
        cmocka_unit_test(points_that_were_not_foreseen_are_refused),
        cmocka_unit_test(a_recording_has_its_chunks_before_it_ends),
        cmocka_unit_test(a_recording_that_ends_is_whole),
        cmocka_unit_test(a_recording_without_data_leaves_nothing),
        cmocka_unit_test(a_conversion_that_is_given_up_leaves_nothing),
        cmocka_unit_test(a_recording_tells_that_the_reader_of_a_pipe_has_left),
        cmocka_unit_test(a_full_disk_is_reported_and_stays_so),
        cmocka_unit_test(options_that_are_none_are_refused),
        cmocka_unit_test(a_status_without_its_size_is_refused),
        cmocka_unit_test(other_formats_have_no_frames),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
