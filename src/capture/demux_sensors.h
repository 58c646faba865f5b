/** @file
 * The sensors of a demultiplexer: which address is one, what each sent, and its
 * assembler. Internal to it. */
#ifndef LUM_CAPTURE_DEMUX_SENSORS_H
#define LUM_CAPTURE_DEMUX_SENSORS_H

#include "demux_members.h"
#include "demux_state.h"
#include "joined.h"
#include "lum/capture/demux.h"
#include "trial.h"

#include <stdio.h>
#include <string.h>

/* Addresses that are counted separately, each on each of its interfaces;
 * further ones are counted together. */
#define LUM_DEMUX_ADDRESSES_MAX LUM_DEMUX_ORIGINS_MAX

/** The latest record of a sensor's data. All bytes 0: there was none. */
typedef struct lum_order {
    bool has_newest;
    int64_t newest_ns;
    uint64_t newest_ticks;
    uint64_t ahead;  /**< records since time last went on by a break */
    uint64_t behind; /**< in a row, in order, each a break behind those */
    int64_t last_ns; /**< of the last one behind */
} lum_order;

/** An assembler with its storage. */
typedef struct lum_demux_assembly {
    lum_assembler assembler;
    lum_line_slot *slots;
    uint32_t *words;
    lum_reach *reach;
} lum_demux_assembly;

/** An address, on an interface where that is known. */
typedef struct lum_demux_entry {
    uint32_t address;
    char interface[LUM_INTERFACE_BYTES]; /* empty: it is not known */
    struct lum_demux_entry *sensor; /* whose data it brings: itself, or the same
                               on another interface; NULL: that is not known
                               (origin is 0), or it is one sensor too many */
    lum_trial *trial;               /* that is to tell; NULL: there is none */
    struct lum_demux_entry *like;   /* the sensor that it may be */
    bool has_clock;
    uint64_t clock;               /* of a sensor's packet that was given last */
    lum_recent *recent;           /* of a sensor; or NULL */
    uint32_t sent;                /* packets of a sensor */
    lum_demux_mixture neighbours; /* of these, with those next to them */
    bool is_waiting;              /* data of it is held */
    bool is_further;     /* another sensor with this address came before */
    bool is_beside;      /* one whose interface no member has */
    uint32_t origin;     /* its number among those that are known, from 1 on */
    uint64_t since;      /* lum_demux_origin.since */
    size_t sensor_index; /* valid if it is one */
    const lum_layout *layout; /* its data's; that of its sensor, once known */
    lum_demux_counters counters;
    lum_demux_assembly *assembly;
    lum_order order;
} lum_demux_entry;

/** The packet at hand. */
typedef struct lum_demux_packet {
    lum_packet_kind kind;
    lum_group group;      /* of data */
    size_t len;           /* of the whole datagram */
    bool is_pending;      /* its group waits for an assembler */
    int64_t time_ns;      /* when that came */
    int64_t behind_ns;    /* how far that stands behind later records */
    uint64_t lost_before; /* late and stray, before it */
} lum_demux_packet;

/** What is kept of data that is held until it is known whose it is. */
typedef struct lum_demux_trials {
    size_t open;      /* entries that have one */
    lum_queue *queue; /* what is held while one is open; or NULL */
    bool has_given;   /* of the queue, for the last record */
    bool is_unsure;   /* lum_demux_is_unsure() */
    lum_stand stand;  /* of the last record, if it is on trial */
} lum_demux_trials;

/** Who is told of packets that were taken or dropped. */
typedef struct lum_demux_watch_state {
    lum_demux_watcher watcher; /* NULL: nobody */
    void *context;
} lum_demux_watch_state;

struct lum_demux {
    lum_demux_options options;
    lum_demux_members members;
    /* the last: all the rest */
    lum_demux_entry addresses[LUM_DEMUX_ADDRESSES_MAX + 1];
    size_t address_count;
    size_t sensors[LUM_DEMUX_SENSORS_MAX]; /* indices of addresses */
    size_t sensor_count;
    uint32_t origin_count; /* entries of which it is known whose data they
                              bring */
    uint32_t held;         /* a bit for each sensor whose data is passed over */
    lum_demux_trials trials;
    uint64_t record;                     /* the number of the record at hand */
    char interface[LUM_INTERFACE_BYTES]; /* of the records to come */
    uint64_t other;
    lum_joined joined; /* of the record at hand */
    lum_demux_packet packet;
    lum_demux_entry *current;
    lum_demux_entry *last; /* whose record was pushed last; NULL: nobody's */
    bool is_flushing;
    size_t flushing;
    lum_demux_watch_state watch;
};

static inline void lum_demux_set_text(char *to, const char *text)
{
    (void)snprintf(to, LUM_INTERFACE_BYTES, "%s", text != NULL ? text : "");
}

static inline lum_demux_entry *lum_demux_sensor_at(const lum_demux *demux,
                                                   size_t sensor)
{
    return (lum_demux_entry *)&demux->addresses[demux->sensors[sensor]];
}

/** An assembler with its storage. NULL without memory. */
lum_demux_assembly *lum_demux_new_assembly(const lum_demux_options *options,
                                           const lum_layout *layout);

/** Free what was held. */
void lum_demux_free_queue(lum_demux *demux);

/** Free all that it holds, but not itself. */
void lum_demux_clear(lum_demux *demux);

/** The entry of an address on the present interface, made if there is room;
 * else that of all the rest. */
lum_demux_entry *lum_demux_find_address(lum_demux *demux, uint32_t address);

/** The first sensor with an address; NULL: there is none. */
lum_demux_entry *lum_demux_find_sensor(const lum_demux *demux,
                                       uint32_t address);

/** Whether the data of an entry may be that of a sensor: their address and
 * their layout are the same. */
static inline bool lum_demux_may_be(const lum_demux_entry *entry,
                                    const lum_demux_entry *sensor)
{
    return entry->address == sensor->address && entry->layout == sensor->layout;
}

/** Say whose data an entry brings; NULL: that of a sensor too many. */
void lum_demux_set_sensor(lum_demux *demux, lum_demux_entry *entry,
                          lum_demux_entry *sensor);

/** Whether the entry is, or can become, a sensor. */
bool lum_demux_admit_sensor(lum_demux *demux, lum_demux_entry *entry);

/** An address with data gets its own entry. It replaces an address that has
 * sent none, whose counts are added to the rest. */
lum_demux_entry *lum_demux_claim_address(lum_demux *demux, uint32_t address);

/** Count the packet at hand. */
void lum_demux_count_packet(const lum_demux *demux, const lum_record *record,
                            lum_demux_counters *c);

/** Count the packet of data at hand. */
void lum_demux_count_data(const lum_demux *demux, const lum_record *record,
                          lum_demux_counters *c);

/** Follow a record of data. Where some records stand a break or more ahead of
 * more others that follow them, these others are in order: the few that stand
 * too early are counted by as many of those.
 * @param field    of the sensor's clock.
 * @param unit_ns  of its ticks.
 * @param break_ns how long no data comes in a break.
 * @return how far it stands behind a later one, in ns, where it is behind by
 *         about as much by the sensor's clock: a step of the host's clock, or
 *         the network, leaves these apart. Without a sensor's clock by its time
 *         alone. 0: it is in order. */
int64_t lum_order_behind_ns(lum_order *order, const lum_field *field,
                            uint32_t unit_ns, int64_t break_ns, int64_t time_ns,
                            const lum_group *group);

/** Whether data of a sensor is assembled. */
bool lum_demux_takes(const lum_demux *demux, const lum_demux_entry *sensor);

/** What packets of an entry are compared by. */
lum_measure lum_demux_measure(const lum_demux *demux,
                              const lum_demux_entry *entry);

/** The group at hand, from an entry whose sensor is known, waits for its
 * assembler, or is counted as late.
 * @return LUM_OK, or LUM_E_SPACE without memory. */
lum_result lum_demux_give(lum_demux *demux, lum_demux_entry *entry,
                          int64_t time_ns);

/** The group at hand was assembled: count it if it stood out of order, behind
 * by more than reassembly takes, and was dropped or taken for a jump of the
 * clock. */
void lum_demux_judge_order(lum_demux *demux);

#endif
