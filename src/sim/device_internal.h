/** @file
 * What the parts of the simulated sensor share. */
#ifndef LUM_SIM_DEVICE_INTERNAL_H
#define LUM_SIM_DEVICE_INTERNAL_H

#include "device.h"

#include "lum/wire.h"

#include <stddef.h>
#include <stdint.h>

/** Change the status; notes when the laser comes up. */
void lum_device_set_status(lum_device *device, uint16_t status, int64_t now_ns);

/** One more piece of the note, cut where it has to be. */
void lum_device_note(lum_device_effects *fx, const char *text);

/** Write the head of a TLV packet and the status into the reply; also again,
 * over that of an answer that has more. */
void lum_device_put_status(const lum_device *device, uint32_t sequence,
                           lum_device_effects *fx, lum_tlv_writer *writer);

/** Take a TLV packet and make its answer. */
void lum_device_answer(lum_device *device, int64_t now_ns, const void *bytes,
                       size_t len, lum_device_effects *out);

#endif
