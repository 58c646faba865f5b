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

/* Writes what the command that ends has changed. That this fails is a note, and
 * no failure of the command. */
void remember_changes(struct ctl *ctl);

/* The sensor has another address now, and what is known of it goes along. */
void remember_move(const struct ctl *ctl, lum_endpoint from, lum_endpoint to);

/* What is known of the sensor that commands talk to, held against its clock,
 * which is asked for. */
struct remembered {
    struct memory_key key;
    struct memory memory;
    bool has_file;
    bool has_answered;   /* the sensor has */
    enum memory_run run; /* since memory.clock of the file */
    double missed;       /* chance that a restart would not have shown */
};

/* EXIT_DONE; else as ctl_request(), with *out filled in all the same. */
enum exit_status remember_look(struct ctl *ctl, struct remembered *out);

#endif
