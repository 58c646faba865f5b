#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "mcap_image.h"

#include "base/crc32.h"
#include "capture/mcap_messages.h"
#include "capture/unpack.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    CLOUDS = 3, /* channels */
    STATUS = 4,
    EVENTS_MAX = 32
};

static lum_crc32 crc;

static int init_crc(void **state)
{
    (void)state;
    lum_crc32_init(&crc);
    return 0;
}

/* --- Files in the making --- */

static void put_channels(image *im)
{
    put_schema(im, 1, "sensor_msgs/msg/PointCloud2");
    put_schema(im, 2, "diagnostic_msgs/msg/DiagnosticArray");
    put_channel(im, CLOUDS, 1, "/points", "cdr");
    put_channel(im, STATUS, 2, "/diagnostics", "cdr");
}

static void put_message(image *im, unsigned channel, unsigned s, size_t len)
{
    const size_t from = begin_record(im, OP_MESSAGE);
    put_int(im, channel, 2);
    put_int(im, 9, 4);
    put_int(im, UINT64_C(1000000000) * s, 8);
    put_int(im, 0, 8);
    for (size_t i = 0; i < len; i++) {
        put_int(im, s + i, 1);
    }
    end_record(im, from);
    im->messages++;
}

/* Three messages in two chunks, with the channels again at the end. */
static image sample(bool is_packed)
{
    void (*const put_chunk)(image *, image *) =
        is_packed ? put_zstd : put_plain;
    image im = begin_file();
    image first = {.bytes = NULL};
    image second = {.bytes = NULL};
    put_channels(&im);
    put_message(&first, CLOUDS, 1, 8);
    put_message(&first, STATUS, 2, 3);
    put_chunk(&im, &first);
    put_message(&second, CLOUDS, 3, 0);
    put_chunk(&im, &second);
    put_channels(&im);
    end_file(&im);
    return im;
}

/* --- Reading them --- */

/* All that a file gave, up to its end or to what was wrong. */
struct outcome {
    lum_mcap_event last;
    size_t count;
    struct {
        lum_mcap_event event;
        size_t index;
        uint64_t log_ns;
        size_t len;
        uint32_t sum; /* of all texts and bytes */
    } events[EVENTS_MAX];
    lum_error error;
    uint64_t damaged;
    char first[LUM_ERROR_BYTES]; /* why the first part was passed over */
};

static uint32_t add_text(uint32_t sum, const char *text)
{
    return lum_crc32_add(&crc, sum, text, strlen(text) + 1u);
}

static void note(struct outcome *o, const lum_mcap_message *m)
{
    assert_true(o->count < EVENTS_MAX);
    uint32_t sum = add_text(0, m->topic->name);
    sum = add_text(sum, m->topic->type);
    sum = add_text(sum, m->topic->definition);
    sum = add_text(sum, m->topic->encoding);
    o->events[o->count].event = o->last;
    o->events[o->count].index = m->index;
    o->events[o->count].log_ns = m->log_ns;
    o->events[o->count].len = m->len;
    o->events[o->count++].sum =
        m->len != 0 ? lum_crc32_add(&crc, sum, m->bytes, m->len) : sum;
}

static void read_all(lum_mcap_messages *reader, struct outcome *o)
{
    lum_mcap_message m;
    while ((o->last = lum_mcap_messages_next(reader, &m, &o->error)) >
           LUM_MCAP_ENDED) {
        note(o, &m);
    }
    if (o->last == LUM_MCAP_ENDED) {
        assert_int_equal(lum_mcap_messages_next(reader, &m, &o->error),
                         LUM_MCAP_ENDED);
    }
}

/* From memory where a byte too far is noticed. */
static struct outcome outcome_of(const uint8_t *bytes, size_t len)
{
    struct outcome o;
    memset(&o, 0, sizeof o);
    uint8_t *exact = malloc(len != 0 ? len : 1u);
    assert_non_null(exact);
    memcpy(exact, bytes, len);
    lum_source *source = lum_source_from_memory("x.mcap", exact, len);
    assert_non_null(source);
    lum_mcap_messages *reader = lum_mcap_messages_new(source, &o.error);
    o.last = LUM_MCAP_FAILED;
    if (reader != NULL) {
        lum_error first = {""};
        read_all(reader, &o);
        o.damaged = lum_mcap_messages_damaged(reader, &first);
        strcpy(o.first, first.text);
    }
    lum_mcap_messages_free(reader);
    lum_source_close(source);
    free(exact);
    return o;
}

/* Frees the image. */
static void expect_error(image *im, const char *text)
{
    const struct outcome o = outcome_of(im->bytes, im->len);
    assert_int_equal(o.last, LUM_MCAP_FAILED);
    if (strstr(o.error.text, text) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", o.error.text, text);
    }
    free(im->bytes);
}

/* Of a file that is read to its end; frees the image. */
static void expect_damage(image *im, uint64_t damaged, const char *text)
{
    const struct outcome o = outcome_of(im->bytes, im->len);
    assert_int_equal(o.last, LUM_MCAP_ENDED);
    assert_int_equal(o.damaged, damaged);
    if (strstr(o.first, text) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", o.first, text);
    }
    free(im->bytes);
}

static bool begins_alike(const struct outcome *a, const struct outcome *b,
                         size_t count)
{
    return memcmp(a->events, b->events, count * sizeof a->events[0]) == 0;
}

static bool can_unpack(void)
{
    return lum_unpack_zstd != NULL;
}

/* --- Tests --- */

static void topics_and_messages_come_in_their_order(void **state)
{
    static const struct {
        lum_mcap_event event;
        size_t index;
        uint64_t s;
        size_t len;
    } expected[] = {{LUM_MCAP_HAS_TOPIC, 0, 0, 0},
                    {LUM_MCAP_HAS_TOPIC, 1, 0, 0},
                    {LUM_MCAP_HAS_MESSAGE, 0, 1, 8},
                    {LUM_MCAP_HAS_MESSAGE, 1, 2, 3},
                    {LUM_MCAP_HAS_MESSAGE, 0, 3, 0}};
    (void)state;
    for (int packed = 0; packed <= (can_unpack() ? 1 : 0); packed++) {
        image im = sample(packed != 0);
        const struct outcome o = outcome_of(im.bytes, im.len);
        assert_int_equal(o.last, LUM_MCAP_ENDED);
        assert_int_equal(o.count, 5);
        for (size_t i = 0; i < 5u; i++) {
            assert_int_equal(o.events[i].event, expected[i].event);
            assert_int_equal(o.events[i].index, expected[i].index);
            assert_int_equal(o.events[i].log_ns, expected[i].s * 1000000000u);
            assert_int_equal(o.events[i].len, expected[i].len);
        }
        free(im.bytes);
    }
}

static void a_topic_has_its_texts_and_a_message_its_bytes(void **state)
{
    static const uint8_t bytes[] = {1, 2, 3, 4, 5, 6, 7, 8};
    (void)state;
    image im = sample(false);
    lum_error error = {""};
    lum_mcap_message m;
    lum_source *source = lum_source_from_memory("x", im.bytes, im.len);
    lum_mcap_messages *reader = lum_mcap_messages_new(source, &error);
    assert_non_null(reader);
    assert_int_equal(lum_mcap_messages_next(reader, &m, &error),
                     LUM_MCAP_HAS_TOPIC);
    assert_string_equal(m.topic->name, "/points");
    assert_string_equal(m.topic->type, "sensor_msgs/msg/PointCloud2");
    assert_string_equal(m.topic->definition, "ros2msg");
    assert_string_equal(m.topic->encoding, "cdr");
    const lum_mcap_messages_topic *points = m.topic;
    assert_int_equal(lum_mcap_messages_next(reader, &m, &error),
                     LUM_MCAP_HAS_TOPIC);
    assert_int_equal(lum_mcap_messages_next(reader, &m, &error),
                     LUM_MCAP_HAS_MESSAGE);
    assert_ptr_equal(m.topic, points);
    assert_memory_equal(m.bytes, bytes, sizeof bytes);
    lum_mcap_messages_free(reader);
    lum_source_close(source);
    free(im.bytes);
}

static void messages_beside_chunks_are_read(void **state)
{
    (void)state;
    image im = begin_file();
    put_channel(&im, CLOUDS, 0, "/raw", "json"); /* without a schema */
    put_message(&im, CLOUDS, 1, 600000);         /* more than a window */
    put_message(&im, CLOUDS, 2, 1);
    end_file(&im);
    const struct outcome o = outcome_of(im.bytes, im.len);
    assert_int_equal(o.last, LUM_MCAP_ENDED);
    assert_int_equal(o.count, 3);
    assert_int_equal(o.events[1].len, 600000);
    free(im.bytes);
}

static void a_file_cut_anywhere_says_so(void **state)
{
    (void)state;
    for (int packed = 0; packed <= (can_unpack() ? 1 : 0); packed++) {
        image im = sample(packed != 0);
        const struct outcome whole = outcome_of(im.bytes, im.len);
        for (size_t len = 0; len < im.len; len++) {
            const struct outcome o = outcome_of(im.bytes, len);
            assert_int_equal(o.last, LUM_MCAP_FAILED);
            assert_true(o.error.text[0] != '\0');
            assert_true(begins_alike(&o, &whole, o.count));
        }
        free(im.bytes);
    }
}

/* All messages are the same, and of the same topics. Behind them another
 * channel may seem to be described. */
static bool has_all_of(const struct outcome *o, const struct outcome *whole)
{
    return o->count >= whole->count && begins_alike(o, whole, whole->count) &&
           (o->count == whole->count ||
            o->events[whole->count].event == LUM_MCAP_HAS_TOPIC);
}

/* What is described beside chunks is guarded by no sum, but compared with what
 * is described at the end again. */
static void a_flipped_bit_gives_an_error_or_the_same(void **state)
{
    (void)state;
    for (int packed = 0; packed <= (can_unpack() ? 1 : 0); packed++) {
        image im = sample(packed != 0);
        const struct outcome whole = outcome_of(im.bytes, im.len);
        for (size_t bit = 0; bit < 8u * im.len; bit++) {
            im.bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
            const struct outcome o = outcome_of(im.bytes, im.len);
            im.bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
            if (o.last == LUM_MCAP_ENDED && o.damaged == 0 &&
                !has_all_of(&o, &whole)) {
                fail_msg("bit %zu of byte %zu: %zu others without an error",
                         bit % 8u, bit / 8u, o.count);
            }
            assert_true(o.last == LUM_MCAP_ENDED || o.error.text[0] != '\0');
        }
        free(im.bytes);
    }
}

static void what_is_no_mcap_file_is_refused(void **state)
{
    (void)state;
    const struct outcome o = outcome_of((const uint8_t *)"%YAML 1.2", 9);
    assert_int_equal(o.last, LUM_MCAP_FAILED);
    assert_string_equal(o.error.text, "it is not an MCAP file");
}

static void what_was_not_described_is_not_handed_out(void **state)
{
    (void)state;
    image im = begin_file();
    put_channels(&im);
    put_message(&im, 9, 1, 4);
    end_file(&im);
    expect_damage(&im, 1, "a message of channel 9, which was not described");
    im = begin_file();
    put_channel(&im, CLOUDS, 5, "/points", "cdr");
    end_file(&im);
    expect_error(&im, "has schema 5, which was not described");
}

static void channels_of_a_damaged_chunk_come_from_the_end(void **state)
{
    image im = begin_file();
    image described = {.bytes = NULL};
    image bad = {.bytes = NULL};
    image good = {.bytes = NULL};
    (void)state;
    put_channels(&described);
    put_channels(&bad);
    put_message(&bad, CLOUDS, 1, 8);
    const struct chunk c = {"", 1, bad.len, bad.len};
    put_chunk_as(&im, &bad, &c);
    put_message(&good, STATUS, 2, 3);
    put_plain(&im, &good);
    end_file_with(&im, &described);
    const struct outcome o = outcome_of(im.bytes, im.len);
    assert_int_equal(o.count, 3);
    assert_int_equal(o.events[0].event, LUM_MCAP_HAS_TOPIC);
    assert_int_equal(o.events[2].event, LUM_MCAP_HAS_MESSAGE);
    assert_int_equal(o.events[2].log_ns, 2000000000);
    expect_damage(&im, 1, "its check sum is wrong");
    free(bad.bytes);
    free(described.bytes);
}

static void another_description_is_refused(void **state)
{
    (void)state;
    image im = begin_file();
    put_channels(&im);
    put_channel(&im, CLOUDS, 1, "/other", "cdr");
    end_file(&im);
    expect_error(&im, "channel 3 is described twice, differently");
    im = begin_file();
    put_channels(&im);
    put_schema(&im, 2, "std_msgs/msg/String");
    end_file(&im);
    expect_error(&im, "schema 2 is described twice, differently");
}

static void memory_for_names_is_bounded(void **state)
{
    char name[LUM_MCAP_NAME_MAX + 2u];
    (void)state;
    memset(name, 'a', sizeof name);
    name[LUM_MCAP_NAME_MAX + 1u] = '\0';
    image im = begin_file();
    put_channel(&im, CLOUDS, 0, name, "cdr");
    expect_error(&im, "a channel has a name that is longer than 255 bytes");
    im = begin_file();
    put_schema(&im, 1, name);
    expect_error(&im, "a schema has a name that is longer than 255 bytes");
    name[LUM_MCAP_NAME_MAX] = '\0';
    im = begin_file();
    put_schema(&im, 1, name);
    put_channel(&im, CLOUDS, 1, name, name);
    end_file(&im);
    assert_int_equal(outcome_of(im.bytes, im.len).last, LUM_MCAP_ENDED);
    free(im.bytes);
}

static void the_number_of_schemas_and_channels_is_bounded(void **state)
{
    (void)state;
    image im = begin_file();
    for (unsigned i = 0; i <= LUM_MCAP_CHANNELS_KEPT_MAX; i++) {
        put_schema(&im, i + 1u, "a");
    }
    expect_error(&im, "more than 256 schemas");
    im = begin_file();
    const size_t begin = im.len;
    for (unsigned i = 0; i <= LUM_MCAP_CHANNELS_KEPT_MAX; i++) {
        put_channel(&im, i, 0, "/a", "cdr");
    }
    lum_error error = {""};
    lum_mcap_message m;
    lum_source *source = lum_source_from_memory("x", im.bytes, im.len);
    lum_mcap_messages *reader = lum_mcap_messages_new(source, &error);
    size_t topics = 0;
    while (lum_mcap_messages_next(reader, &m, &error) == LUM_MCAP_HAS_TOPIC) {
        topics++;
    }
    assert_true(begin < im.len);
    assert_int_equal(topics, LUM_MCAP_CHANNELS_KEPT_MAX);
    assert_non_null(strstr(error.text, "more than 256 channels"));
    lum_mcap_messages_free(reader);
    lum_source_close(source);
    free(im.bytes);
}

static void huge_lengths_are_refused(void **state)
{
    static const uint64_t lengths[] = {UINT64_MAX, UINT64_MAX - 8u,
                                       UINT64_C(1) << 63, UINT64_C(32) << 20};
    (void)state;
    for (size_t i = 0; i < 4u; i++) {
        image im = begin_file();
        put_channels(&im);
        const size_t from = begin_record(&im, OP_MESSAGE);
        put_int(&im, CLOUDS, 8);
        set_int(&im, from + 1u, lengths[i], 8);
        expect_error(&im, "a record is cut short");
    }
}

static void short_records_are_passed_over(void **state)
{
    static const struct {
        unsigned opcode;
        size_t len;
    } bad[] = {{OP_SCHEMA, 1},   {OP_SCHEMA, 9},  {OP_CHANNEL, 3},
               {OP_CHANNEL, 11}, {OP_MESSAGE, 0}, {OP_MESSAGE, 21}};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        image im = begin_file();
        put_channel(&im, 0, 0, "/a", "cdr");
        put_record(&im, bad[i].opcode, bad[i].len);
        end_file(&im);
        expect_damage(&im, 1, "is shorter than it declares");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(topics_and_messages_come_in_their_order),
        cmocka_unit_test(a_topic_has_its_texts_and_a_message_its_bytes),
        cmocka_unit_test(messages_beside_chunks_are_read),
        cmocka_unit_test(a_file_cut_anywhere_says_so),
        cmocka_unit_test(a_flipped_bit_gives_an_error_or_the_same),
        cmocka_unit_test(what_is_no_mcap_file_is_refused),
        cmocka_unit_test(what_was_not_described_is_not_handed_out),
        cmocka_unit_test(channels_of_a_damaged_chunk_come_from_the_end),
        cmocka_unit_test(another_description_is_refused),
        cmocka_unit_test(memory_for_names_is_bounded),
        cmocka_unit_test(the_number_of_schemas_and_channels_is_bounded),
        cmocka_unit_test(huge_lengths_are_refused),
        cmocka_unit_test(short_records_are_passed_over),
    };
    return cmocka_run_group_tests(tests, init_crc, NULL);
}
