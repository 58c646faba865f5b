#include "ring.h"

#include "shared.h"

void ring_init(ring *r)
{
    r->committed = 0;
    r->dropped = 0;
    r->released = 0;
}

ring_slot *ring_claim(ring *r)
{
    ring_slot *const slot = &r->slots[r->committed % RING_SLOTS];

    if (r->committed - shared_load(&r->released) >= RING_SLOTS) {
        shared_store(&r->dropped, r->dropped + 1u);
        return NULL;
    }
    slot->begin = 0;
    return slot;
}

void ring_commit(ring *r)
{
    shared_store(&r->committed, r->committed + 1u);
}

const ring_slot *ring_front(const ring *r)
{
    if (shared_load(&r->committed) == r->released) {
        return NULL;
    }
    return &r->slots[r->released % RING_SLOTS];
}

void ring_release(ring *r)
{
    shared_store(&r->released, r->released + 1u);
}

uint32_t ring_dropped(const ring *r)
{
    return shared_load(&r->dropped);
}
