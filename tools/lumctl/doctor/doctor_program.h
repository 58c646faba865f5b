/* Another program of this Linux host, with pipes to it and from it. It always
 * ends when this one does. */
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

/* The folders of programs for administrators, whatever PATH says. */
bool program_find(const char *name, char path[PROGRAM_PATH_BYTES]);

struct program program_none(void);

/* arguments[0] is its name. False: it is not there, or cannot be started. */
bool program_start(struct program *p, char *const arguments[]);

/* All that it prints, within a second and a half. False: it did not end in this
 * time, or there is no memory. */
bool program_read(struct program *p, FILE *out);

/* Ends its input, and the program. */
void program_end(struct program *p);

#endif
