#include "memory.h"

#include "setting.h"

#include "lum/host/clock_sync.h"

#include <stdio.h>
#include <string.h>

#define WRAP_NS   (INT64_C(0x100000000) * 1000)
#define DRIFT_PER INT64_C(2000) /* clocks differ by one part in so many */

struct memory_value memory_value(const struct memory *memory, lum_command_id id)
{
    struct memory_value out;
    const uint16_t value = memory->entries[id].value;
    if (id == LUM_COMMAND_LINE_MODE) {
        (void)snprintf(out.text, sizeof out.text, "%u", setting_lines(value));
    } else if (id != LUM_COMMAND_YSCAN) {
        (void)snprintf(out.text, sizeof out.text, "%u", (unsigned)value);
    } else if (memory->table.scan == MEMORY_DEGREES) {
        (void)snprintf(out.text, sizeof out.text, "%u degrees",
                       (unsigned)value);
    } else {
        (void)snprintf(out.text, sizeof out.text, "%s of %u lines",
                       memory->table.scan == MEMORY_SHAPE
                           ? setting_shapes[memory->table.shape.kind]
                           : "a table",
                       (unsigned)value);
    }
    return out;
}

/* A change of the line mode clears a table. */
static void clear_table(struct memory *memory)
{
    if (memory->table.scan != MEMORY_DEGREES) {
        memory->entries[LUM_COMMAND_YSCAN].standing = MEMORY_NOTHING;
        memory->table.scan = MEMORY_DEGREES;
    }
}

static void set_entry(struct memory *memory, lum_command_id id, uint16_t value,
                      enum memory_standing standing, int64_t utc_ns)
{
    memory->entries[id] = (struct memory_entry){standing, value, utc_ns};
}

void memory_take(struct memory *memory, const lum_command *command,
                 enum memory_standing standing, int64_t utc_ns)
{
    if (setting_name(command->id) == NULL) {
        return;
    }
    if (command->id == LUM_COMMAND_LINE_MODE) {
        memory->is_lines_set = true;
        clear_table(memory);
    } else if (command->id == LUM_COMMAND_YSCAN) {
        memory->table.scan = MEMORY_DEGREES;
    }
    set_entry(memory, command->id, command->value, standing, utc_ns);
}

void memory_take_table(struct memory *memory, const struct memory_table *table,
                       uint16_t lines, enum memory_standing standing,
                       int64_t utc_ns)
{
    memory->table = *table;
    set_entry(memory, LUM_COMMAND_YSCAN, lines, standing, utc_ns);
}

bool memory_has_any(const struct memory *memory)
{
    for (size_t i = 0; i < LUM_COMMANDS; i++) {
        if (memory->entries[i].standing != MEMORY_NOTHING) {
            return true;
        }
    }
    return memory->is_unclear;
}

static void weaken(struct memory *memory, enum memory_standing standing)
{
    for (size_t i = 0; i < LUM_COMMANDS; i++) {
        if (memory->entries[i].standing == MEMORY_DONE) {
            memory->entries[i].standing = standing;
        }
    }
}

#define BIT(id) (1u << (unsigned)(id))
#define SCAN    (BIT(LUM_COMMAND_LINE_MODE) | BIT(LUM_COMMAND_YSCAN))

/* The settings that another command set while these changes were under way, a
 * bit each. Those from the future: the calendar was set back since. Lines and a
 * table go together, since lines clear it. */
static unsigned find_contested(const struct memory *memory,
                               const struct memory *changes, int64_t now_ns)
{
    const bool has_table = memory->table.scan != MEMORY_DEGREES ||
                           changes->table.scan != MEMORY_DEGREES;
    unsigned found = 0;
    for (size_t i = 0; i < LUM_COMMANDS; i++) {
        const struct memory_entry *e = &memory->entries[i];
        if (e->standing != MEMORY_NOTHING && e->utc_ns >= changes->begun_ns &&
            e->utc_ns <= now_ns) {
            found |= BIT(i);
        }
    }
    return has_table && (found & SCAN) != 0 ? found | SCAN : found;
}

static void merge_entry(struct memory *memory, const struct memory *changes,
                        size_t i, bool is_contested)
{
    struct memory_entry *e = &memory->entries[i];
    const bool is_same =
        e->standing == MEMORY_DONE && e->value == changes->entries[i].value &&
        (i != LUM_COMMAND_YSCAN || (memory->table.scan == MEMORY_DEGREES &&
                                    changes->table.scan == MEMORY_DEGREES));
    const int64_t before_ns = e->utc_ns;
    *e = changes->entries[i];
    if (is_contested) { /* a third may have been under way with the later one */
        e->utc_ns = before_ns > e->utc_ns ? before_ns : e->utc_ns;
        e->standing = is_same ? e->standing : MEMORY_UNSURE;
    }
}

void memory_merge(struct memory *memory, const struct memory *changes,
                  int64_t now_ns)
{
    const unsigned contested = find_contested(memory, changes, now_ns);
    if (changes->is_lines_set && (contested & BIT(LUM_COMMAND_YSCAN)) == 0) {
        clear_table(memory);
    } else if (changes->is_lines_set && memory->table.scan != MEMORY_DEGREES) {
        memory->entries[LUM_COMMAND_YSCAN].standing = MEMORY_UNSURE;
    }
    if (changes->is_unclear) {
        weaken(memory, MEMORY_UNSURE);
    }
    for (size_t i = 0; i < LUM_COMMANDS; i++) {
        if (changes->entries[i].standing != MEMORY_NOTHING) {
            merge_entry(memory, changes, i, (contested & BIT(i)) != 0);
        }
    }
    if (changes->entries[LUM_COMMAND_YSCAN].standing != MEMORY_NOTHING) {
        memory->table = changes->table;
    }
}

/* Part of the clock's turn in which a restart would not show. */
static double chance_of(const struct memory_clock *before,
                        const struct memory_clock *now)
{
    const int64_t passed = now->utc_ns - before->utc_ns;
    const int64_t slack = before->error_ns + now->error_ns +
                          passed / DRIFT_PER + LUM_CLOCK_RESET_NS;
    const double chance = 2.0 * (double)slack / (double)WRAP_NS;
    return chance < 1.0 ? chance : 1.0;
}

static bool add_clock(lum_clock_sync *sync, const struct memory_clock *clock)
{
    return lum_clock_sync_add(sync, clock->utc_ns - clock->error_ns,
                              clock->utc_ns + clock->error_ns,
                              clock->clock_us) == LUM_OK;
}

enum memory_run memory_compare(const struct memory_clock *before,
                               const struct memory_clock *now, double *missed)
{
    lum_clock_sync sync;
    lum_clock_estimate estimate;
    *missed = 1.0;
    if (!before->is_known || !now->is_known ||
        now->utc_ns < before->utc_ns - LUM_CLOCK_RESET_NS) {
        return MEMORY_RUN_UNKNOWN;
    }
    *missed = chance_of(before, now);
    lum_clock_sync_init(&sync);
    if (!add_clock(&sync, before) || !add_clock(&sync, now) ||
        lum_clock_sync_estimate(&sync, &estimate) != LUM_OK) {
        return MEMORY_RUN_UNKNOWN;
    }
    if (estimate.resets != 0) {
        return MEMORY_OTHER_RUN;
    }
    return *missed <= MEMORY_MISSED_MAX ? MEMORY_SAME_RUN : MEMORY_RUN_UNKNOWN;
}

static void forget(struct memory *memory, const struct memory_clock *now)
{
    const int64_t from = memory->clock.utc_ns;
    *memory = (struct memory){
        .clock = *now, .restart_from_ns = from, .restart_to_ns = now->utc_ns};
}

enum memory_run memory_see_clock(struct memory *memory,
                                 const struct memory_clock *now, double *missed)
{
    const enum memory_run run = memory_compare(&memory->clock, now, missed);
    if (run == MEMORY_OTHER_RUN) {
        forget(memory, now);
    } else if (now->is_known) {
        if (run == MEMORY_RUN_UNKNOWN) {
            weaken(memory, MEMORY_OLD);
        }
        memory->clock = *now;
    }
    return run;
}
