#include "crowd.h"

bool crowd_has_room(const struct crowd *crowd, uint32_t address)
{
    size_t all = 0;
    size_t own = 0;
    for (size_t i = 0; i < CROWD_MAX; i++) {
        const struct crowd_place *place = &crowd->places[i];
        all += place->is_taken ? 1u : 0u;
        own += place->is_taken && place->address == address ? 1u : 0u;
    }
    return all < CROWD_MAX && own < CROWD_PEER_MAX;
}

struct crowd_place *crowd_enter(struct crowd *crowd, uint32_t address)
{
    for (size_t i = 0; i < CROWD_MAX; i++) {
        if (!crowd->places[i].is_taken) {
            crowd->places[i] = (struct crowd_place){address, true};
            return &crowd->places[i];
        }
    }
    return NULL;
}
