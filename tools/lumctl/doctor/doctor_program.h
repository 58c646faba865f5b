/* Another program of this Linux host that is talked to, and that ends with
 * this one whatever happens. */
#ifndef LUMCTL_DOCTOR_PROGRAM_H
#define LUMCTL_DOCTOR_PROGRAM_H

#include <stdbool.h>
#include <stdio.h>
#include <sys/types.h>

#define PROGRAM_PATH_BYTES 64u

struct program {
    pid_t process; /* 0: none */
    int in;        /* to it */
    int out;       /* from it; its errors too */
};

/* Where administrators' programs are, whatever PATH says. */
bool program_find(const char *name, char path[PROGRAM_PATH_BYTES]);

struct program program_none(void);

/* arguments[0] is its name. False: it is not there, or cannot be started. */
bool program_start(struct program *p, char *const arguments[]);

/* All that it prints, within a second and a half. False: it did not end by
 * then, or memory is short. */
bool program_read(struct program *p, FILE *out);

/* Ends its input, and the program. */
void program_end(struct program *p);

#endif
