/* What tests of the gateway share: a gateway, the clock of its machine, and a
 * sensor that answers and shows lines. */
#ifndef LUM_TEST_GATEWAY_RIG_H
#define LUM_TEST_GATEWAY_RIG_H

#include "gateway.h"

#include "lum/assembler.h"
#include "lum/calibration.h"
#include "lum/group.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define BLUE  (1u << LUM_EYE_BLUE)
#define GREEN (1u << LUM_EYE_GREEN)
#define BOTH  (BLUE | GREEN)
#define MM(x) ((x)*LUM_FIXED_PER_MM)

#define NEAR_TOF 2564 /* 5 m straight ahead */
#define FAR_TOF  20512
#define HITS     5u
#define STEP     25u /* from line to line */
#define LINES    14u
#define FRAME    (LINES * STEP)
#define HOLD     1600u
#define SILENCE  500u
#define SENT_MAX 4096u

#define PACKET_MAX 250u /* samples; a quarter of a line */

struct sent {
    uint32_t ms;
    uint32_t sequence;
    uint8_t type;
};

/* A gateway, the clock of its machine, and a sensor. */
struct rig {
    gateway gateway; /* first: it has to be aligned */
    void *memory;
    gateway_config config;
    gateway_output output;
    lum_calibration calibration;
    lum_layout layout;
    uint32_t now;
    uint32_t line;
    uint32_t boot_us; /* by how much the sensor's clock is ahead of now */
    bool refuses;
    bool is_mute; /* the sensor does not answer requests for its clock */
    size_t sent_count;
    struct sent sent[SENT_MAX];
    size_t lines;
    size_t points;
    size_t frames;
    int64_t frame;
    zone_sight sight; /* of that frame */
};

bool receive(struct rig *r, const void *bytes, size_t len);

uint32_t sensor_clock(const struct rig *r);

void tell_clock(struct rig *r, uint32_t sequence, uint32_t clock_us);

struct rig *rig_new(void);

void rig_free(struct rig *r);

lum_result rig_init(struct rig *r);

struct rig *rig_at(uint32_t now);

/* Knows the sensor's clock, before it asks. */
struct rig *rig_informed(uint32_t now);

/* n samples alike, of a line's pixels from first on. */
void put(struct rig *r, unsigned eye, uint8_t tag, int32_t tof, bool rising,
         uint32_t first, uint32_t n);

void put_angles(struct rig *r, unsigned eye);

void next_line(struct rig *r);

/* A line of some eyes, with n returns straight ahead, and no others. */
void show(struct rig *r, unsigned eyes, int32_t tof, uint32_t n);

/* More lines, each with a return outside the zone, until the lines before them
 * are handed out. */
void show_out(struct rig *r);

/* Time passes; some eyes see something outside the zone. */
void pass(struct rig *r, uint32_t ms, unsigned eyes);

void next_frame(struct rig *r);

uint32_t reasons(const struct rig *r);

/* A rig that goes. */
struct rig *rig_going(uint32_t now);

/* A tick each step, and a round of the main loop. */
void run(struct rig *r, uint32_t ms, uint32_t step);

/* The timer runs, the main loop does not. */
void hang(struct rig *r, uint32_t ms);

#endif
