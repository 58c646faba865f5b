#include "count.h"

#include "port/port.h"
#include "port/text.h"

#define LOOPS    500000u
#define READINGS 1000u

bool datagram_begin(struct datagram *d, const lum_layout *layout,
                    const lum_group *group)
{
    size_t head = 0;
    if (lum_group_encode(layout, group, d->bytes, sizeof d->bytes, &head) !=
        LUM_OK) {
        return false;
    }
    d->len = head + (size_t)group->num_samples * LUM_SAMPLE_BYTES;
    return d->len <= sizeof d->bytes;
}

uint8_t *datagram_sample(struct datagram *d, uint32_t samples, uint32_t i)
{
    return d->bytes + d->len - (size_t)(samples - i) * LUM_SAMPLE_BYTES;
}

void count_add(struct count *c, uint32_t ticks, uint32_t units)
{
    c->ticks += ticks;
    c->readings++;
    c->units += units;
}

void count_print(const char *name, const struct count *c)
{
    text line = {{0}, 0};
    text_put(&line, name);
    text_put(&line, " ");
    text_put_number(&line, c->ticks);
    text_put(&line, " ");
    text_put_number(&line, c->readings);
    text_put(&line, " ");
    text_put_number(&line, c->units);
    text_end(&line);
}

/* Two instructions a turn. */
static void spin(uint32_t turns)
{
#if defined(__thumb__)
    __asm__ volatile(".syntax unified\n\t1: subs %0, #1\n\tbne 1b"
                     : "+r"(turns)::"cc");
#else
    (void)turns;
#endif
}

void count_print_scale(void)
{
    struct count loop = {0, 0, 0};
    struct count nothing = {0, 0, 0};
    uint32_t begin = port_ticks();
    spin(LOOPS);
    count_add(&loop, port_ticks() - begin, 2 * LOOPS);
    for (uint32_t i = 0; i < READINGS; i++) {
        begin = port_ticks();
        count_add(&nothing, port_ticks() - begin, 1);
    }
    count_print("loop", &loop);
    count_print("nothing", &nothing);
}
