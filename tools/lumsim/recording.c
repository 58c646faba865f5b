/* The data packets of one sensor of a capture, for --replay. */
#include "../common/number.h"
#include "base/text.h"
#include "lum/assembler.h"
#include "lum/capture/capture.h"
#include "lum/capture/demux.h"
#include "named_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct recording {
    const char *path;
    lum_capture *capture;
    lum_demux *demux; /* tells whose a packet is; the first look through the
                         capture teaches it the sensors */
    bool is_cut_off;
};

/* 1 if it is data of the sensor; 0; -1 without memory. */
static int is_wanted(const struct recording *r, const lum_record *record)
{
    lum_packet_kind kind = LUM_PACKET_KINDS;
    lum_result result;
    lum_demux_set_interface(r->demux, lum_capture_interface(r->capture));
    do {
        result = lum_demux_push(r->demux, record, &kind);
    } while (result > 0);
    return result < 0
               ? -1
               : kind == LUM_PACKET_DATA && lum_demux_is_wanted(r->demux);
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

/* 1 with a packet of the sensor; 0 at the end, or where it cannot be read any
 * further; -1 with the reason in error. */
static int find_next(struct recording *r, lum_record *out, lum_error *error)
{
    int result = 0;
    int wanted = 0;
    while (wanted == 0 &&
           (result = lum_capture_next(r->capture, out, NULL)) > 0) {
        wanted = is_wanted(r, out);
    }
    r->is_cut_off = wanted == 0 && result < 0;
    return wanted < 0 ? lum_error_set(error, "%s: not enough memory", r->path)
                      : wanted;
}

/* The sensor's facts; those of all if none was named. */
static int look_through(struct recording *r, struct recording_facts *facts,
                        lum_error *error)
{
    lum_record record;
    int result;
    while ((result = find_next(r, &record, error)) > 0) {
        note_packet(facts, &record);
    }
    facts->is_cut_off = r->is_cut_off;
    while (result == 0 && lum_demux_flush(r->demux) > 0) {
    }
    return result;
}

static void list_sensors(const lum_demux *demux, char *out, size_t room)
{
    char name[LUM_SENSOR_NAME_BYTES];
    out[0] = '\0';
    for (size_t i = 0; i < lum_demux_sensor_count(demux); i++) {
        lum_text_add(out, room, "%s%s", i > 0 ? ", " : "",
                     lum_demux_name(demux, i, name));
    }
}

static int examine(struct recording *r, const struct replayed_sensor *sensor,
                   struct recording_facts *facts, lum_error *error)
{
    char names[LUM_ERROR_BYTES / 2u];
    if (look_through(r, facts, error) != 0) {
        return -1;
    }
    (void)lum_capture_damaged(r->capture, &facts->damage);
    list_sensors(r->demux, names, sizeof names);
    if (names[0] == '\0') {
        return lum_error_set(error,
                             "%s: not one data packet of a sensor; 'lumdump "
                             "%s' shows what is there",
                             r->path, r->path);
    }
    if (facts->packets == 0) {
        return lum_error_set(
            error, "%s: no data of %s%s%s; there is data of %s", r->path,
            number_address(sensor->address).text,
            sensor->interface[0] != '\0' ? "%" : "", sensor->interface, names);
    }
    return sensor->address != 0 || lum_demux_sensor_count(r->demux) == 1
               ? 0
               : lum_error_set(error,
                               "%s: data of several sensors: %s; choose one by "
                               "--sensor ADDRESS",
                               r->path, names);
}

static lum_demux *make_demux(const lum_layout *layout,
                             const struct replayed_sensor *sensor)
{
    lum_demux *demux = NULL;
    lum_demux_options o = {.struct_size = sizeof o,
                           .layout = *layout,
                           .has_sensor = sensor->address != 0,
                           .sensor = sensor->address,
                           .port = sensor->port};
    o.sensor_interface =
        sensor->interface[0] != '\0' ? sensor->interface : NULL;
    lum_assembler_config_default(&o.config);
    return lum_demux_new(&o, &demux, NULL) == 0 ? demux : NULL;
}

static struct recording *make(const char *path, const lum_layout *layout,
                              const struct replayed_sensor *sensor)
{
    struct recording *r = calloc(1, sizeof *r);
    if (r == NULL) {
        return NULL;
    }
    r->path = path;
    r->demux = make_demux(layout, sensor);
    if (r->demux == NULL) {
        recording_close(r);
        return NULL;
    }
    return r;
}

int recording_open(const char *path, const lum_layout *layout,
                   const struct replayed_sensor *sensor, struct recording **out,
                   struct recording_facts *facts, lum_error *error)
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
        examine(r, sensor, facts, error) != 0) {
        recording_close(r);
        return -1;
    }
    *out = r;
    return 0;
}

bool recording_remark(const struct recording *recording, size_t i,
                      lum_error *out)
{
    return lum_capture_remark(recording->capture, recording->demux, 0, i, out);
}

int recording_next(struct recording *recording, struct recorded *out,
                   lum_error *error)
{
    lum_record record;
    if (recording->capture == NULL) {
        return lum_error_set(error, "%s is not open", recording->path);
    }
    const int result = find_next(recording, &record, error);
    if (result > 0) {
        *out = (struct recorded){.time_ns = record.time_ns,
                                 .bytes = record.payload,
                                 .len = record.len};
    }
    return result;
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
        lum_demux_free(recording->demux);
        free(recording);
    }
}
