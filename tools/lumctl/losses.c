#include "losses.h"

#include "lum/frame/framer.h"
#include "lum/wire.h"

#include <stdlib.h>

struct losses {
    lum_framer *framer; /* to lines, without points */
    uint64_t failed;    /* datagrams for which there was no memory */
};

struct losses *losses_new(const lum_layout *layout, lum_error *error)
{
    struct losses *l = calloc(1, sizeof *l);
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .layout = layout,
                                        .records_are_single = true,
                                        .wants = LUM_WANT_LINES};
    if (l == NULL) {
        (void)lum_error_set(error, "out of memory");
        return NULL;
    }
    if (lum_framer_new(&options, &l->framer, error) != 0 ||
        lum_framer_set_views(l->framer, NULL, 0, error) != 0) {
        losses_free(l);
        return NULL;
    }
    return l;
}

void losses_free(struct losses *losses)
{
    if (losses != NULL) {
        lum_framer_free(losses->framer);
        free(losses);
    }
}

/* On the sensor's side, the port is the one that all sensors have, whatever
 * port a relay uses. */
void losses_take(struct losses *losses, lum_endpoint sensor,
                 const lum_received *datagram)
{
    const lum_record record = {.time_ns = datagram->utc_ns,
                               .payload = datagram->bytes,
                               .len = datagram->len,
                               .source = sensor.address,
                               .source_port = LUM_PORT,
                               .kind = LUM_RECORD_DATAGRAM};
    lum_framer_event event = LUM_FRAMER_NONE;
    do {
        event = lum_framer_push(losses->framer, &record, NULL);
    } while (event != LUM_FRAMER_NONE && event != LUM_FRAMER_FAILED);
    losses->failed += event == LUM_FRAMER_FAILED ? 1u : 0u;
}

void losses_end(struct losses *losses)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    do {
        event = lum_framer_flush(losses->framer);
    } while (event != LUM_FRAMER_NONE && event != LUM_FRAMER_FAILED);
}

void losses_count(const struct losses *losses, struct loss_counts *out)
{
    lum_demux_counters c = {.struct_size = sizeof c};
    lum_framer_counters f = {.struct_size = sizeof f};
    const lum_demux *demux = lum_framer_demux(losses->framer);
    lum_demux_total(demux, &c);
    if (lum_demux_sensor_count(demux) > 0) {
        (void)lum_framer_count(losses->framer, 0, &f);
    }
    *out = (struct loss_counts){
        .packets = c.packets[LUM_PACKET_DATA],
        .lines = c.assembly.lines,
        .lines_incomplete = c.assembly.lines_missing_angles - f.under_way.lines,
        .lines_missing = f.lines_missing - f.missing_under_way,
        .words_lost = c.assembly.lost_words - f.under_way.words,
        .refused = lum_framer_refused(&c, &f) + losses->failed};
}
