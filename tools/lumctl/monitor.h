/* What is known of a sensor that is looked at again and again, and how that is
 * written: a line for people, JSON, CSV, and a page for Prometheus. */
#ifndef LUMCTL_MONITOR_H
#define LUMCTL_MONITOR_H

#include "ctl.h"
#include "file_writer.h"
#include "losses.h"
#include "watch.h"

#include "lum/host/clock_sync.h"

struct monitor_hazards {
    uint16_t now;        /* of the last status */
    uint16_t since;      /* of any status since the row before */
    uint16_t ever;       /* and since the beginning */
    uint64_t count;      /* times that a hazard began */
    int64_t seen_utc_ns; /* the last time that one was seen; 0: never */
};

struct monitor_rows {
    int64_t due_ns;             /* when the next one is */
    struct file_writer *writer; /* NULL: no files */
    bool prints;                /* to standard output */
    bool has_any;               /* was written */
    uint64_t unprinted;         /* nobody read them */
};

struct monitor {
    struct ctl *ctl;
    bool asks; /* for the status; else the laser session does (watch.looks) */
    int64_t clock_ns;      /* when the clock is asked for next */
    bool knows;            /* a request has ended */
    bool answers;          /* the last one with an answer */
    int64_t answered_ns;   /* monotonic; 0: never */
    int64_t round_trip_ns; /* of the last answer; 0: not known */
    bool has_status;
    uint16_t status; /* the last */
    bool was_up;     /* at the row before */
    bool was_owned;  /* at the status before */
    struct monitor_hazards hazards;
    lum_clock_sync sync;
    lum_sensor_counters begun; /* an owner's: a shell has counted before */
    struct losses *losses;     /* an owner's; NULL: none is */
    struct monitor_rows rows;
};

/* Begins to look at the session's sensor, as its options say. Complains. */
enum exit_status monitor_begin(struct monitor *m, struct ctl *ctl, bool asks);

/* Asks for the clock now and then, and if it is said so, for the status. For
 * struct watch, with *m as context. */
lum_result monitor_ask(struct ctl *ctl, void *context);
#define MONITOR_ASK_NS INT64_C(250000000)

/* Takes an event, and writes a row where one is due. False: nobody reads. */
bool monitor_take(struct monitor *m, const lum_sensor_event *event);

/* Whether what --until waits for is so. */
bool monitor_is_met(const struct monitor *m);

/* Ends the files, and says what is missing in them. status: of the command so
 * far. EXIT_HAZARD if that is EXIT_DONE or EXIT_NO_ANSWER and the last status
 * has a hazard, or, with --every or --until hazard, any had. */
enum exit_status monitor_end(struct monitor *m, enum exit_status status);

/* status_command.c */

/* Prints a line, or a JSON object, with the time: if has_status is false, the
 * sensor does not answer. was_up: the line before showed the laser up. False if
 * nobody reads. */
bool status_log(const struct ctl *ctl, bool was_up, bool has_status,
                uint16_t status);

/* sample.c */

/* What a row says, at one time. */
struct sample {
    const char *sensor;
    int64_t utc_ns;
    const struct monitor *monitor;
    bool is_owned;
    double age_s; /* of the last answer; below 0: there is none */
    bool has_clock;
    lum_clock_estimate clock;
    int64_t utc_offset_ns; /* of the sensor's clock to UTC */
    bool has_counts;       /* the session owns the sensor */
    lum_sensor_counters session;
    struct loss_counts losses;
};

extern const char sample_csv_header[];

#define SAMPLE_ROW_BYTES  FILE_WRITER_ROW_BYTES
#define SAMPLE_PAGE_BYTES 16384
void sample_text(const struct sample *s, char out[SAMPLE_ROW_BYTES]);
void sample_csv(const struct sample *s, char out[SAMPLE_ROW_BYTES]);
void sample_json(const struct sample *s, FILE *out);
void sample_page(const struct sample *s, char out[SAMPLE_PAGE_BYTES]);

#endif
