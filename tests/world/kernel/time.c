#include "time.h"

#include "time_internal.h"

#include <stdlib.h>

/* Events are in a heap by moment, then by order of the calls. */
struct world_event {
    int64_t when_ns;
    uint64_t order;
    void (*run)(void *argument);
    void *argument;
    size_t place; /* in the heap */
};

static struct {
    int64_t now_ns;
    uint64_t orders;
    world_event **heap;
    size_t count, room;
} timeline;

int64_t world_now(void)
{
    return timeline.now_ns;
}

void world_spend(int64_t ns)
{
    timeline.now_ns += ns;
}

static bool is_before(const world_event *a, const world_event *b)
{
    return a->when_ns != b->when_ns ? a->when_ns < b->when_ns
                                    : a->order < b->order;
}

static void put(world_event *event, size_t place)
{
    timeline.heap[place] = event;
    event->place = place;
}

static void sift_up(world_event *event, size_t place)
{
    while (place > 0 && is_before(event, timeline.heap[(place - 1) / 2])) {
        put(timeline.heap[(place - 1) / 2], place);
        place = (place - 1) / 2;
    }
    put(event, place);
}

static void sift_down(world_event *event, size_t place)
{
    for (;;) {
        size_t child = 2 * place + 1;
        if (child + 1 < timeline.count &&
            is_before(timeline.heap[child + 1], timeline.heap[child])) {
            child++;
        }
        if (child >= timeline.count || is_before(event, timeline.heap[child])) {
            break;
        }
        put(timeline.heap[child], place);
        place = child;
    }
    put(event, place);
}

static void take_out(world_event *event)
{
    world_event *last = timeline.heap[--timeline.count];
    const size_t place = event->place;
    if (last != event) {
        sift_up(last, place);
        sift_down(last, last->place);
    }
}

world_event *world_at(int64_t when_ns, void (*run)(void *argument),
                      void *argument)
{
    world_event *event = malloc(sizeof *event);
    if (timeline.count == timeline.room) {
        timeline.room = timeline.room == 0 ? 64 : 2 * timeline.room;
        timeline.heap =
            realloc(timeline.heap, timeline.room * sizeof(world_event *));
    }
    if (event == NULL || timeline.heap == NULL) {
        abort();
    }
    *event =
        (world_event){when_ns > timeline.now_ns ? when_ns : timeline.now_ns,
                      timeline.orders++, run, argument, 0};
    sift_up(event, timeline.count++);
    return event;
}

void world_cancel_event(world_event *event)
{
    take_out(event);
    free(event);
}

int64_t world_next_event_ns(void)
{
    return timeline.count > 0 ? timeline.heap[0]->when_ns : WORLD_NEVER;
}

void world_jump(int64_t to_ns)
{
    if (to_ns > timeline.now_ns) {
        timeline.now_ns = to_ns;
    }
}

bool world_run_due(void)
{
    if (world_next_event_ns() > timeline.now_ns) {
        return false;
    }
    world_event *event = timeline.heap[0];
    const world_event copy = *event;
    take_out(event);
    free(event);
    copy.run(copy.argument);
    return true;
}

void world_time_reset(void)
{
    while (timeline.count > 0) {
        world_cancel_event(timeline.heap[0]);
    }
    free(timeline.heap);
    timeline.heap = NULL;
    timeline.room = 0;
    timeline.now_ns = 0;
    timeline.orders = 0;
}
