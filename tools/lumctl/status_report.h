/* The sensor's status in words, and other things for people's eyes. */
#ifndef LUMCTL_STATUS_REPORT_H
#define LUMCTL_STATUS_REPORT_H

#include "../common/json.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* What a bit of a status means, and what to do; "" where there is nothing. */
struct report_bit {
    const char *meaning;
    unsigned rank; /* of several, the lowest is done first; 0: it is no fault
                      of the sensor */
    const char *fix;
};
struct report_bit report_bit(unsigned bit);

/* Behind a status: what put a laser down that was up, or what will follow. */
const char *report_cause(uint16_t status, bool was_up);

/* HEARTBEAT_TIMEOUT is the only hazard. */
bool report_lacks_heartbeats(uint16_t status);

/* Nobody sends heartbeats, and nobody should. Here and below is_owned (from
 * session_is_owned()) says that some session has to send them. */
bool report_is_idle(uint16_t status, bool is_owned);

/* A hazard other than idleness. */
bool report_has_hazard(uint16_t status, bool is_owned);

/* "laser down: FAN_PWM_BAD, TLV_CMD_ON", hazards first. */
struct report_line {
    char text[400];
};
struct report_line report_line(uint16_t status, bool is_owned);

/* The text after "laser down": ", idle", that the owner is silent, or
 * nothing. */
const char *report_aside(uint16_t status, bool is_owned);

/* A line for each bit, hazards first, with what it means and what to do. */
void report_status(FILE *out, uint16_t status, bool is_owned, bool in_colour);

/* The keys status, status_hex, bits, hazards (none while idle), laser, idle. */
void report_json(struct json *json, uint16_t status, bool is_owned);

/* The key round_trip_ms; null where it is 0, which is not known. */
void report_json_trip(struct json *json, int64_t round_trip_ns);

/* Each line of the sensor's texts. */
void report_debug(FILE *out, const char *text);

/* Lines of a text as an array. */
void report_json_lines(struct json *json, const char *key, const char *text);

/* 2026-11-21T12:34:56.789Z */
struct report_utc {
    char text[64];
};
struct report_utc report_utc(int64_t utc_ns);

/* Flushes the output. False if nobody reads it any more, which is not a
 * failure, or if it cannot be written. */
bool report_flush(void);

/* Whether a stream is a terminal, and whether it may be coloured. */
bool report_is_terminal(FILE *stream);
bool report_may_colour(FILE *stream);

#endif
