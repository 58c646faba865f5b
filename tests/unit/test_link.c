#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/link.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* As files have them. */
enum {
    BSD_NULL = 0,
    ETHERNET = 1,
    PPP = 9,
    RAW_OLD = 12,
    RAW = 101,
    WIFI = 105,
    BSD_LOOP = 108,
    COOKED = 113,
    IPV4 = 228,
    COOKED_V2 = 276
};

#define MARK 0x45 /* the packet's first byte in every golden frame */

#define MACS 2, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 2

static const uint8_t ethernet[] = {MACS, 8, 0, MARK, 7};
static const uint8_t tag_8021q[] = {MACS, 0x81, 0, 0x20, 5, 8, 0, MARK, 7};
static const uint8_t tag_8021ad[] = {MACS, 0x88, 0xa8, 0, 5, 8, 0, MARK, 7};
static const uint8_t tag_9100[] = {MACS, 0x91, 0, 0, 5, 8, 0, MARK, 7};
static const uint8_t tag_stack[] = {MACS, 0x91, 0,    0, 1, 0x88, 0xa8,
                                    0,    2,    0x81, 0, 0, 3,    0x81,
                                    0,    0,    4,    8, 0, MARK, 7};
static const uint8_t cooked[] = {0, 0, 0, 1, 0, 6, 2, 0,    0,
                                 0, 0, 1, 0, 0, 8, 0, MARK, 7};
static const uint8_t cooked_tag[] = {0, 0, 0, 1,    0, 6, 2, 0, 0, 0,    0,
                                     1, 0, 0, 0x81, 0, 0, 9, 8, 0, MARK, 7};
static const uint8_t cooked_v2[] = {8, 0, 0, 0, 0, 0, 0, 3, 0, 1,    0,
                                    6, 2, 0, 0, 0, 0, 1, 0, 0, MARK, 7};
static const uint8_t raw[] = {MARK, 7};
static const uint8_t loop_little[] = {2, 0, 0, 0, MARK, 7};
static const uint8_t loop_big[] = {0, 0, 0, 2, MARK, 7};

static const struct golden {
    uint32_t link_type;
    const uint8_t *frame;
    size_t len;
    size_t header;
} goldens[] = {
    {ETHERNET, ethernet, sizeof ethernet, 14},
    {ETHERNET, tag_8021q, sizeof tag_8021q, 18},
    {ETHERNET, tag_8021ad, sizeof tag_8021ad, 18},
    {ETHERNET, tag_9100, sizeof tag_9100, 18},
    {ETHERNET, tag_stack, sizeof tag_stack, 30},
    {COOKED, cooked, sizeof cooked, 16},
    {COOKED, cooked_tag, sizeof cooked_tag, 20},
    {COOKED_V2, cooked_v2, sizeof cooked_v2, 20},
    {RAW, raw, sizeof raw, 0},
    {RAW_OLD, raw, sizeof raw, 0},
    {IPV4, raw, sizeof raw, 0},
    {BSD_NULL, loop_little, sizeof loop_little, 4},
    {BSD_NULL, loop_big, sizeof loop_big, 4},
    {BSD_LOOP, loop_big, sizeof loop_big, 4},
};

#define GOLDENS (sizeof goldens / sizeof goldens[0])

static bool find_packet(uint32_t link_type, const uint8_t *frame, size_t len,
                        lum_span *packet)
{
    lum_link_reader *reader = lum_link_find(link_type);
    assert_non_null(reader);
    return reader((lum_span){frame, len}, packet);
}

static void the_packet_of_each_link_layer_is_found(void **state)
{
    (void)state;
    for (size_t i = 0; i < GOLDENS; i++) {
        const struct golden *g = &goldens[i];
        lum_span packet = {NULL, 0};
        assert_true(find_packet(g->link_type, g->frame, g->len, &packet));
        assert_ptr_equal(packet.at, g->frame + g->header);
        assert_int_equal(packet.len, 2);
        assert_int_equal(packet.at[0], MARK);
    }
}

static void a_cut_header_holds_no_packet_and_nothing_is_written(void **state)
{
    (void)state;
    for (size_t i = 0; i < GOLDENS; i++) {
        const struct golden *g = &goldens[i];
        for (size_t n = 0; n < g->len; n++) {
            uint8_t *exact = malloc(n != 0 ? n : 1u);
            lum_span packet = {NULL, 77};
            assert_non_null(exact);
            memcpy(exact, g->frame, n);
            assert_int_equal(find_packet(g->link_type, exact, n, &packet),
                             n >= g->header);
            assert_int_equal(packet.len, n >= g->header ? n - g->header : 77);
            free(exact);
        }
    }
}

static void other_protocols_are_not_ipv4(void **state)
{
    const struct golden others[] = {
        {ETHERNET, (const uint8_t[]){MACS, 8, 6, MARK, 7}, 16, 0},
        {ETHERNET, (const uint8_t[]){MACS, 0x86, 0xdd, MARK, 7}, 16, 0},
        {ETHERNET, (const uint8_t[]){MACS, 0x81, 0, 0, 1, 8, 6, MARK, 7}, 20,
         0},
        {ETHERNET, (const uint8_t[]){MACS, 0, 2, MARK, 7}, 16, 0},
        {BSD_NULL, (const uint8_t[]){30, 0, 0, 0, MARK, 7}, 6, 0},
        {BSD_NULL, (const uint8_t[]){0, 2, 0, 0, MARK, 7}, 6, 0},
        {BSD_LOOP, (const uint8_t[]){0, 0, 0, 24, MARK, 7}, 6, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        lum_span packet = {NULL, 77};
        assert_false(find_packet(others[i].link_type, others[i].frame,
                                 others[i].len, &packet));
        assert_int_equal(packet.len, 77);
    }
}

static void a_frame_of_nothing_but_tags_ends(void **state)
{
    uint8_t frame[1500];
    lum_span packet = {NULL, 77};
    (void)state;
    for (size_t i = 0; i < sizeof frame; i += 2) {
        frame[i] = 0x81;
        frame[i + 1] = 0;
    }
    assert_false(find_packet(ETHERNET, frame, sizeof frame, &packet));
    assert_int_equal(packet.len, 77);
}

static void other_link_types_have_no_reader(void **state)
{
    (void)state;
    assert_null(lum_link_find(WIFI));
    assert_null(lum_link_find(PPP));
    assert_null(lum_link_find(UINT32_MAX));
    assert_non_null(lum_link_supported());
}

/* Of each link type that has a reader the words by which messages and the
 * protocol name it. */
static const struct {
    uint32_t link_type;
    const char *words;
} named[] = {
    {ETHERNET, "Ethernet"},     {COOKED, "Linux cooked v1"},
    {COOKED_V2, "v2"},          {RAW, "raw IP"},
    {RAW_OLD, "raw IP"},        {IPV4, "raw IP"},
    {BSD_NULL, "BSD loopback"}, {BSD_LOOP, "BSD loopback"},
};

static const char *words_of(uint32_t link_type)
{
    for (size_t i = 0; i < sizeof named / sizeof named[0]; i++) {
        if (named[i].link_type == link_type) {
            return named[i].words;
        }
    }
    return NULL;
}

static bool is_golden(uint32_t link_type)
{
    size_t i = 0;
    while (i < GOLDENS && goldens[i].link_type != link_type) {
        i++;
    }
    return i < GOLDENS;
}

/* The sentence of the protocol, without its line breaks. */
static void read_sentence(char *out, size_t size)
{
    static char text[200000];
    FILE *file = fopen(LUM_SOURCE_DIR "/docs/protocol.md", "r");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1u, file)] = '\0';
    assert_int_equal(fclose(file), 0);
    const char *from = strstr(text, "Link types:");
    assert_non_null(from);
    size_t n = strcspn(from, ".");
    assert_true(n < size);
    memcpy(out, from, n);
    out[n] = '\0';
    while (n > 0) {
        n--;
        out[n] = out[n] == '\n' ? ' ' : out[n];
    }
}

/* A file has at most 16 bits of it. */
static void every_reader_is_named_and_tested(void **state)
{
    char sentence[400];
    (void)state;
    read_sentence(sentence, sizeof sentence);
    for (uint32_t type = 0; type <= UINT16_MAX; type++) {
        const char *words = words_of(type);
        assert_int_equal(lum_link_find(type) != NULL, words != NULL);
        if (words != NULL) {
            assert_non_null(strstr(lum_link_supported(), words));
            assert_non_null(strstr(sentence, words));
            assert_true(is_golden(type));
            assert_string_equal(lum_link_name(type), "unknown");
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_packet_of_each_link_layer_is_found),
        cmocka_unit_test(a_cut_header_holds_no_packet_and_nothing_is_written),
        cmocka_unit_test(other_protocols_are_not_ipv4),
        cmocka_unit_test(a_frame_of_nothing_but_tags_ends),
        cmocka_unit_test(other_link_types_have_no_reader),
        cmocka_unit_test(every_reader_is_named_and_tested),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
