/* The settings that were acknowledged in this run and in those before, kept in
 * a small file for each sensor: by its address, its port and the interface. */
#ifndef LUMCTL_REMEMBER_H
#define LUMCTL_REMEMBER_H

#include "ctl.h"
#include "memory.h"

/* What the Y-scan table that is sent next was made from. shape NULL: from
 * elevations one by one. from: a file of those, or the calibration, or NULL. */
void remember_table(struct ctl *ctl, const lum_yscan_shape *shape,
                    const char *from);

/* Takes the TLVs of a request that was sent. answer NULL: none came. */
void remember_request(struct ctl *ctl, const void *tlvs, size_t len,
                      const struct ctl_answer *answer);

/* Writes the changes of the command that ends. If this fails, there is a note;
 * the command does not fail. */
void remember_changes(struct ctl *ctl);

/* The sensor has another address now; its settings move there. */
void remember_move(const struct ctl *ctl, lum_endpoint from, lum_endpoint to);

/* The known settings of the sensor that commands talk to, compared with its
 * clock, which is asked for. */
struct remembered {
    struct memory_key key;
    struct memory memory;
    bool has_file;
    bool has_answered;         /* the sensor has, */
    struct memory_clock clock; /* with this */
    enum memory_run run;       /* since memory.clock of the file */
    double missed;             /* chance that a restart would not have shown */
};

/* EXIT_DONE; else as ctl_request(), with *out filled in all the same. */
enum exit_status remember_look(struct ctl *ctl, struct remembered *out);

#endif
