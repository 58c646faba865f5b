#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/packet.h"
#include "lum/wire.h"
#include "support.h"

#include "../layout/both.h"

#include <stdlib.h>
#include <string.h>

/* Any bytes, but a tag, an eye and a count that often are good ones. */
static size_t make_datagram(uint64_t *random, uint8_t *bytes, size_t size)
{
    const size_t len = next_random(random) % (size + 1u);
    for (size_t i = 0; i < size; i++) {
        bytes[i] = (uint8_t)next_random(random);
    }
    bytes[12] = (uint8_t)(next_random(random) % 5u);
    bytes[13] = (uint8_t)(next_random(random) % 3u);
    if (next_random(random) % 4u != 0) {
        bytes[16] = (uint8_t)(next_random(random) % (size / 4u));
        bytes[17] = 0;
        bytes[19] = (uint8_t)(next_random(random) % 5u);
    }
    return len;
}

static void any_bytes_are_read_the_same_by_both(void **state)
{
    uint64_t random = 1;
    unsigned taken[4] = {0};
    lum_layout layout;
    (void)state;
    lum_layout_default(&layout);
    for (unsigned i = 0; i < 100000; i++) {
        uint8_t bytes[96];
        lum_group g;
        const size_t len = make_datagram(&random, bytes, sizeof bytes);
        uint8_t *exact = exact_copy(bytes, len);
        assert_true(layouts_agree(exact, len));
        if (lum_group_decode(&layout, exact, len, &g) == LUM_OK) {
            taken[g.tag]++;
        }
        free(exact);
    }
    assert_true(taken[LUM_TAG_ANGLES] > 1000 && taken[LUM_TAG_RANGES] > 1000);
}

static void a_line_of_all_angles_is_read_the_same_by_both(void **state)
{
    static uint8_t samples[LUM_LINE_PIXELS * LUM_SAMPLE_BYTES];
    const lum_group g = {
        .num_samples = LUM_LINE_PIXELS, .eye = 1, .tag = LUM_TAG_ANGLES};
    uint64_t random = 2;
    size_t len = 0;
    lum_layout layout;
    (void)state;
    lum_layout_default(&layout);
    for (size_t i = 0; i < sizeof samples; i++) {
        samples[i] = (uint8_t)next_random(&random);
    }
    uint8_t *packet = encode_packet(&layout, &g, samples, &len);
    assert_true(layouts_agree(packet, len));
    free(packet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_bytes_are_read_the_same_by_both),
        cmocka_unit_test(a_line_of_all_angles_is_read_the_same_by_both),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
