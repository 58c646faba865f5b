/* Reassembly by docs/protocol.md, section 6, rules 1 to 6, written simply and
 * independently of the core: marks and sums represent the contents of a line,
 * and frames are left out. A test that drives an assembler passes each event to
 * the model and compares. */
#ifndef LUM_TESTS_FUZZ_MODEL_H
#define LUM_TESTS_FUZZ_MODEL_H

#include "lum/assembler.h"

/* What a line holds: sums do not depend on the order. */
struct content {
    uint64_t words;
    uint64_t word_sum;
    uint64_t angles;
    uint64_t angle_sum;
};

struct model_line {
    uint32_t number;
    uint32_t accepted; /* packets */
    int64_t clock_us;
    int64_t low_clock_us;
    int64_t arrival; /* of the first packet */
    int64_t last_arrival;
    uint64_t sent; /* words of accepted packets, bad ones too */
    uint64_t end;  /* of them, by their own count */
    struct content content;
    uint32_t angle_marks[LUM_PIXEL_MARK_WORDS];
    uint32_t word_marks[LUM_PIXEL_MARK_WORDS];
};

struct model_closed {
    int64_t clock_us;
    uint32_t number;
};

struct model_eye {
    struct model_line open[LUM_OPEN_LINES_MAX]; /* in order of opening */
    unsigned open_count;
    struct model_closed closed[LUM_REORDER_MAX]; /* the last, newest first */
    unsigned closed_count;
    bool has_low;
    bool has_newest;
    bool has_candidate;
    int64_t low_clock_us;
    int64_t newest_us;
    int64_t candidate_us;
};

enum model_place {
    MODEL_STRAY,
    MODEL_LATE,
    MODEL_BREAK,
    MODEL_NEW,
    MODEL_OPEN
};

struct model {
    lum_assembler_config config;
    uint32_t line_span_us;
    unsigned clock_bits;
    uint32_t unit_ns;
    uint64_t ticks;        /* of the last packet but strays */
    uint64_t packet_ticks; /* of the packet at hand */
    struct model_eye eye[LUM_EYES];
    /* of the packet at hand */
    enum model_place place;
    int64_t packet_us;
    unsigned to_close; /* number of its eye's lines before it */
    unsigned target;   /* MODEL_OPEN: which line */
};

void model_init(struct model *m, const lum_assembler_config *config,
                const lum_layout *layout);

/* A new packet: the lines that have to close, and the line that it belongs to
 * then. */
void model_judge(struct model *m, const lum_group *group);

/* The line that closes: its eye, and how many were opened before it. */
struct model_line model_close(struct model *m, unsigned eye, unsigned index);

/* A packet all of whose lines have closed. Returns what a push has to; bad
 * counts the words that were skipped. */
lum_result model_finish(struct model *m, const lum_group *group,
                        int64_t arrival, uint64_t *bad);

/* The first line whose last packet came before: in eye and index. */
bool model_find_idle(const struct model *m, int64_t before, unsigned *eye,
                     unsigned *index);

/* A flush came to its end. */
void model_end(struct model *m);

/* The contents of a line must be those of the model, and in order. */
bool model_agrees(const struct model_line *expected, const lum_line *line);

#endif
