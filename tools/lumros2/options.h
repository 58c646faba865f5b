/* What lumros2 was asked to do. */
#ifndef LUMROS2_OPTIONS_H
#define LUMROS2_OPTIONS_H

#include "../common/option_table.h"
#include "topics.h"

#include <stdbool.h>
#include <stdint.h>

struct options {
    const char *source; /* "-": standard input */
    double rate;        /* of recorded time; 0: as fast as readers take it */
    bool has_rate;
    bool loops;
    int64_t domain;  /* -1: that of ROS_DOMAIN_ID, or 0 */
    int64_t readers; /* to wait for before the first message */
    struct names names;
    struct qos qos;
    bool quiet;
    bool verbose;
};

enum option_end options_parse(int argc, char **argv, struct options *out);

#endif
