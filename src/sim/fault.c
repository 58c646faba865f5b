#include "fault.h"

#include <string.h>

void lum_fault_init(lum_fault *out, const double probability[LUM_FAULT_KINDS],
                    uint64_t seed)
{
    memset(out, 0, sizeof *out);
    out->last_ns = INT64_MIN;
    for (unsigned k = 0; k < LUM_FAULT_KINDS; k++) {
        out->probability[k] = probability[k];
        lum_random_init(&out->random[k], seed, ((uint64_t)k << 8) | 3u);
    }
}

/* Decide on a fault, and draw its parameter; always both, so that every packet
 * uses the same number of random numbers. */
static bool strikes(lum_fault *f, enum lum_fault_kind kind, uint32_t range,
                    uint32_t *how)
{
    lum_random *r = &f->random[kind];
    const bool yes = lum_random_chance(r, f->probability[kind]);
    *how = lum_random_below(r, range);
    f->count[kind] += yes ? 1u : 0u;
    return yes;
}

/* Flip 1 to 3 different bits. */
static void corrupt(lum_sim_packet *packet, uint32_t how)
{
    const uint32_t bits = (uint32_t)(8u * packet->len);
    lum_random r;
    lum_random_init(&r, how, 4);
    const uint32_t n = 1u + lum_random_below(&r, 3);
    const uint32_t step = 1u + lum_random_below(&r, bits / 4u);
    uint32_t bit = lum_random_below(&r, bits);
    for (uint32_t i = 0; i < n; i++) {
        packet->bytes[bit / 8u] ^= (uint8_t)(1u << (bit % 8u));
        bit = (bit + step) % bits;
    }
}

static void hold(lum_fault *f, const lum_sim_packet *packet)
{
    uint32_t ignored;
    uint32_t bits;
    uint32_t behind;
    const bool lost = strikes(f, LUM_FAULT_LOSS, 1, &ignored);
    const bool corrupted = strikes(f, LUM_FAULT_CORRUPT, UINT32_MAX, &bits);
    const bool late = strikes(f, LUM_FAULT_REORDER, LUM_FAULT_REACH, &behind);
    if (lost) {
        return;
    }
    lum_fault_held *h = &f->held[f->held_count++];
    h->packet = *packet;
    h->behind = late ? 1u + behind : 0u;
    h->on_time = !late;
    if (corrupted) {
        corrupt(&h->packet, bits);
    }
}

void lum_fault_push(lum_fault *fault, const lum_sim_packet *packet)
{
    uint32_t ignored;
    for (size_t i = 0; i < fault->held_count; i++) {
        if (fault->held[i].behind > 0) {
            fault->held[i].behind--;
        }
    }
    const bool twice = strikes(fault, LUM_FAULT_DUPLICATE, 1, &ignored);
    hold(fault, packet);
    if (twice) {
        hold(fault, packet);
    }
}

void lum_fault_flush(lum_fault *fault)
{
    for (size_t i = 0; i < fault->held_count; i++) {
        fault->held[i].behind = 0;
    }
}

/* A packet on time leaves first, so that the packets that wait for it come
 * after it. */
static size_t find_next(const lum_fault *f)
{
    size_t found = f->held_count;
    for (size_t i = f->held_count; i-- > 0;) {
        const lum_fault_held *h = &f->held[i];
        if (h->behind == 0 &&
            (h->on_time || found == f->held_count || !f->held[found].on_time)) {
            found = i;
        }
    }
    return found;
}

const lum_sim_packet *lum_fault_pull(lum_fault *fault)
{
    const size_t at = find_next(fault);
    if (at == fault->held_count) {
        return NULL;
    }
    fault->out = fault->held[at].packet;
    fault->held_count--;
    memmove(&fault->held[at], &fault->held[at + 1],
            (fault->held_count - at) * sizeof fault->held[0]);
    if (fault->out.time_ns < fault->last_ns) {
        fault->out.time_ns = fault->last_ns;
    }
    fault->last_ns = fault->out.time_ns;
    return &fault->out;
}
