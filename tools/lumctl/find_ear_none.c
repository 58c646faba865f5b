#include "find.h"

struct find_ear {
    int nothing;
};

struct find_ear *find_ear_open(const struct host_interface *interface,
                               uint16_t port)
{
    (void)interface;
    (void)port;
    return NULL;
}

bool find_ear_take(struct find_ear *ear, struct find_heard *out)
{
    (void)ear;
    (void)out;
    return false;
}

void find_ear_close(struct find_ear *ear)
{
    (void)ear;
}
