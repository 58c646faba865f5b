#include "../common/number.h"
#include "files.h"
#include "lum/capture/capture.h"
#include "lum/packet.h"
#include "lum/wire.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SENSORS_MAX 8u /* that are named */

struct recording {
    char *path;
    lum_layout layout;
    lum_capture *capture;
    uint32_t sensor;
};

/* Who sent data, in the order they first did. */
struct senders {
    uint32_t address[SENSORS_MAX];
    size_t count;
};

/* The sensor whose data this is; 0: it is none. */
static uint32_t sender_of(const lum_layout *layout, const lum_record *record)
{
    lum_group group;
    if (!lum_record_is_datagram(record) ||
        (record->source_port != LUM_PORT &&
         record->destination_port != LUM_PORT) ||
        lum_packet_decode(layout, record->payload, record->len, &group) !=
            LUM_PACKET_DATA) {
        return 0;
    }
    return record->source_port == LUM_PORT ? record->source
                                           : record->destination;
}

static void note_sender(struct senders *senders, uint32_t address)
{
    for (size_t i = 0; i < senders->count; i++) {
        if (senders->address[i] == address) {
            return;
        }
    }
    if (senders->count < SENSORS_MAX) {
        senders->address[senders->count++] = address;
    }
}

static void note_packet(struct recording_facts *facts, const lum_record *record)
{
    if (facts->packets == 0 || record->time_ns < facts->first_ns) {
        facts->first_ns = record->time_ns;
    }
    if (facts->packets == 0 || record->time_ns > facts->last_ns) {
        facts->last_ns = record->time_ns;
    }
    if (record->len > facts->longest) {
        facts->longest = record->len;
    }
    facts->packets++;
}

/* The sensor's facts; those of all senders if sensor is 0. */
static int look_through(lum_capture *capture, const lum_layout *layout,
                        uint32_t sensor, struct senders *senders,
                        struct recording_facts *facts)
{
    lum_record record;
    int result;
    while ((result = lum_capture_next(capture, &record, NULL)) > 0) {
        const uint32_t sender = sender_of(layout, &record);
        if (sender != 0) {
            note_sender(senders, sender);
            if (sensor == 0 || sender == sensor) {
                note_packet(facts, &record);
            }
        }
    }
    return result;
}

static int refuse_several(const char *path, const struct senders *senders,
                          lum_error *error)
{
    char names[SENSORS_MAX * 18] = "";
    char name[16];
    size_t len = 0;
    for (size_t i = 0; i < senders->count; i++) {
        len += (size_t)snprintf(
            names + len, sizeof names - len, "%s%s", i > 0 ? ", " : "",
            number_format_address(senders->address[i], name));
    }
    return lum_error_set(error,
                         "%s: data of several sensors: %s; choose one by "
                         "--sensor ADDRESS",
                         path, names);
}

static int refuse_empty(const char *path, const struct senders *senders,
                        uint32_t sensor, lum_error *error)
{
    char wanted[16];
    char there[16];
    if (senders->count > 0) {
        return lum_error_set(error, "%s: no data of %s; there is data of %s",
                             path, number_format_address(sensor, wanted),
                             number_format_address(senders->address[0], there));
    }
    return lum_error_set(
        error,
        "%s: not one data packet of a sensor; 'lumdump %s' shows what is there",
        path, path);
}

static int examine(struct recording *r, struct recording_facts *facts,
                   lum_error *error)
{
    struct senders senders = {.count = 0};
    facts->is_cut_off =
        look_through(r->capture, &r->layout, r->sensor, &senders, facts) < 0;
    (void)lum_capture_damaged(r->capture, &facts->damage);
    if (facts->packets == 0) {
        return refuse_empty(r->path, &senders, r->sensor, error);
    }
    if (r->sensor == 0 && senders.count > 1) {
        return refuse_several(r->path, &senders, error);
    }
    if (r->sensor == 0) {
        r->sensor = senders.address[0];
    }
    facts->sensor = r->sensor;
    return 0;
}

static struct recording *make(const char *path, const lum_layout *layout,
                              uint32_t sensor)
{
    const size_t size = strlen(path) + 1;
    struct recording *r = calloc(1, sizeof *r);
    if (r == NULL) {
        return NULL;
    }
    r->path = malloc(size);
    if (r->path == NULL) {
        free(r);
        return NULL;
    }
    memcpy(r->path, path, size);
    r->layout = *layout;
    r->sensor = sensor;
    return r;
}

int recording_open(const char *path, const lum_layout *layout, uint32_t sensor,
                   struct recording **out, struct recording_facts *facts,
                   lum_error *error)
{
    *facts = (struct recording_facts){0};
    if (strcmp(path, "-") == 0) {
        return lum_error_set(error, "--replay: standard input can be read only "
                                    "once; give a file");
    }
    struct recording *r = make(path, layout, sensor);
    if (r == NULL) {
        return lum_error_set(error, "%s: not enough memory", path);
    }
    if (lum_capture_open(path, &r->capture, error) != 0 ||
        examine(r, facts, error) != 0) {
        recording_close(r);
        return -1;
    }
    *out = r;
    return 0;
}

int recording_next(struct recording *recording, struct recorded *out,
                   lum_error *error)
{
    lum_record record;
    if (recording->capture == NULL) {
        return lum_error_set(error, "%s is not open", recording->path);
    }
    while (lum_capture_next(recording->capture, &record, NULL) > 0) {
        if (sender_of(&recording->layout, &record) == recording->sensor) {
            *out = (struct recorded){.time_ns = record.time_ns,
                                     .bytes = record.payload,
                                     .len = record.len};
            return 1;
        }
    }
    return 0;
}

int recording_rewind(struct recording *recording, lum_error *error)
{
    lum_capture_close(recording->capture);
    recording->capture = NULL;
    return lum_capture_open(recording->path, &recording->capture, error);
}

void recording_close(struct recording *recording)
{
    if (recording != NULL) {
        lum_capture_close(recording->capture);
        free(recording->path);
        free(recording);
    }
}
