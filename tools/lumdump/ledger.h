/* The list of the files that --keep may remove, and its text:
 *
 *     lumdump keep 1
 *     16 1048576 1700000600000000000
 *     17 begun
 *     end
 *
 * A line is a file's number, its bytes, and the time of its last data in ns
 * since 1970; or a number under which this output may have begun a file. */
#ifndef LUMDUMP_LEDGER_H
#define LUMDUMP_LEDGER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LEDGER_NUMBER_MAX 999999999u

struct ledger_file {
    unsigned number; /* from 1 */
    bool is_whole;   /* only then the rest is known */
    uint64_t bytes;
    int64_t last_ns;
};

/* By rising numbers. All zero: an empty one. */
struct ledger {
    struct ledger_file *files;
    size_t count;
    size_t room;
};

enum ledger_text {
    LEDGER_WHOLE,
    LEDGER_DAMAGED, /* the files before the damage are there */
    LEDGER_FOREIGN, /* it is no ledger */
    LEDGER_NO_MEMORY
};

/* ledger: an empty one, to be freed whatever the result. */
enum ledger_text ledger_read(struct ledger *ledger, const char *text,
                             size_t len);

/* Its text, to be freed. NULL: there is no memory. */
char *ledger_write(const struct ledger *ledger, size_t *len);

/* A number above all others. False: it is not, or there is no memory. */
bool ledger_add(struct ledger *ledger, const struct ledger_file *file);

/* NULL: it is not there. */
struct ledger_file *ledger_find(const struct ledger *ledger, unsigned number);

/* Forget it, if it is there. */
void ledger_forget(struct ledger *ledger, unsigned number);

/* The highest number; 0: none. */
unsigned ledger_top(const struct ledger *ledger);

void ledger_free(struct ledger *ledger);

#endif
