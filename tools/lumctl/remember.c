#define _POSIX_C_SOURCE 200809L
#include "remember.h"

#include "../common/make_folder.h"
#include "../common/printable.h"
#include "ctl_session.h"
#include "refusal.h"
#include "rows_file.h"
#include "yscan/yscan_table.h"

#include "lum/base/time.h"
#include "lum/host/command_text.h"
#include "lum/wire.h"

#include "net/route.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CLOCK_NS INT64_C(500000000) /* longest wait for the sensor's clock */

/* Longest waits for another lumctl; with the one before, no heartbeat that is
 * due is late by more than a sensor allows. */
#define LOCK_NS       INT64_C(10000000000)
#define LOCK_OWNER_NS INT64_C(1000000000)

/* --- Small files in the user's folder of states, for this user alone --- */

#define STATE_PATH_BYTES 1024

/* Room for a name in the folder, or a suffix. */
#define LONG_PATH_BYTES (STATE_PATH_BYTES + 8)

#define LOOK_NS INT64_C(10000000)

static int fail(const char *path, const char *doing, lum_error *error)
{
    return lum_error_set(error, "%s: %s: %s", path, doing, strerror(errno));
}

#ifdef _WIN32
#define SEPARATORS  "\\/"
#define HOME        "LOCALAPPDATA"
#define HOME_STATES "%s/lumsdk/sensors"
#else
#define SEPARATORS  "/"
#define HOME        "HOME"
#define HOME_STATES "%s/.local/state/lumsdk/sensors"
#endif

/* Else a relative one would be another folder for each present folder. */
static bool is_absolute(const char *path)
{
    const bool has_drives = sizeof SEPARATORS > 2u;
    return path != NULL && *path != '\0' &&
           (strchr(SEPARATORS, *path) != NULL ||
            (has_drives && path[1] == ':'));
}

/* The folder, which need not be there: $XDG_STATE_HOME/lumsdk/sensors, or that
 * in ~/.local/state; on Windows in %LOCALAPPDATA%. -1 where there is no home.
 */
static int state_folder(char out[STATE_PATH_BYTES], lum_error *error)
{
    const char *state = getenv("XDG_STATE_HOME");
    const char *home = getenv(HOME);
    int n = 0;
    if (is_absolute(state)) {
        n = snprintf(out, STATE_PATH_BYTES, "%s/lumsdk/sensors", state);
    } else if (is_absolute(home)) {
        n = snprintf(out, STATE_PATH_BYTES, HOME_STATES, home);
    }
    return n > 0 && n < STATE_PATH_BYTES
               ? 0
               : lum_error_set(error, "neither XDG_STATE_HOME nor " HOME
                                      " names a folder where it could be kept");
}

/* And all above it. 0, or why the first that is not there could not be made;
 * one that may not be made, such as a drive, may be there all the same. */
static int make_folders(const char *folder)
{
    char path[STATE_PATH_BYTES];
    int code = 0;
    (void)snprintf(path, sizeof path, "%s", folder);
    for (char *at = path + 1;; at++) {
        const char was = *at;
        if (strchr(SEPARATORS, was) != NULL) { /* or the end */
            *at = '\0';
            if (make_private_folder(path) != 0 && errno != EEXIST &&
                code == 0) {
                code = errno;
            }
            *at = was;
        }
        if (was == '\0') {
            return code;
        }
    }
}

/* Makes the folder if it does not exist, and waits for the lock on it: while it
 * is held, no other lumctl changes the files. The lock of a program that was
 * stopped is not waited for without end. A descriptor to be closed, or -1. */
static int state_lock(const char *folder, int64_t wait_ns, lum_error *error)
{
    const int64_t end = lum_time_monotonic_ns() + wait_ns;
    char path[LONG_PATH_BYTES];
    const int code = make_folders(folder);
    (void)snprintf(path, sizeof path, "%s/.lock", folder);
    int lock = rows_file_open(path, true);
    while (lock < 0 && errno == EBUSY && lum_time_monotonic_ns() < end) {
        lum_time_sleep_until(lum_time_monotonic_ns() + LOOK_NS);
        lock = rows_file_open(path, true);
    }
    if (lock < 0 && errno == ENOENT && code != 0) {
        errno = code;
        (void)fail(folder, "cannot be made", error);
    } else if (lock < 0) {
        (void)(errno == EBUSY
                   ? lum_error_set(error, "%s: another lumctl is using it",
                                   path)
                   : fail(path, "cannot be opened", error));
    }
    return lock;
}

/* Reads a file of less than size bytes and ends it with a NUL: 1; 0 if it is
 * not there; -1. */
static int state_read(const char *path, char *out, size_t size,
                      lum_error *error)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return errno == ENOENT || errno == ENOTDIR
                   ? 0
                   : fail(path, "cannot be read", error);
    }
    errno = 0;
    const size_t len = fread(out, 1, size, file);
    const int result =
        ferror(file) != 0 ? fail(path, "cannot be read", error) : 1;
    (void)fclose(file);
    if (result == 1 && (len == size || memchr(out, '\0', len) != NULL)) {
        return lum_error_set(error, "%s: is not a state file of lumctl", path);
    }
    out[len < size ? len : 0] = '\0';
    return result;
}

/* Replaces a file as a whole, with the lock held: a reader sees the old one or
 * the new one. Not forced to the disk: one that is slow must not hold up the
 * heartbeats of a shell, and a file that a power failure has spoilt is passed
 * over. */
static int state_write(const char *path, const char *text, size_t len,
                       lum_error *error)
{
    char part[LONG_PATH_BYTES];
    (void)snprintf(part, sizeof part, "%s.part", path);
    const int fd = rows_file_open(part, true);
    if (fd < 0) {
        return fail(path, "cannot be written", error);
    }
    int code = rows_file_cut(fd, 0) == 0 && rows_file_put(fd, text, len) == 0
                   ? 0
                   : errno;
    code = close(fd) != 0 && code == 0 ? errno : code;
    if (code == 0 && rows_file_replace(part, path) == 0) {
        return 0;
    }
    errno = code != 0 ? code : errno;
    (void)fail(path, "cannot be written", error);
    (void)unlink(part);
    return -1;
}

/* --- What a request sets --- */

void remember_table(struct ctl *ctl, const lum_yscan_shape *shape,
                    const char *from)
{
    struct memory_table *table = &ctl->table;
    *table = (struct memory_table){.scan = shape != NULL ? MEMORY_SHAPE
                                                         : MEMORY_TABLE};
    if (shape != NULL) {
        table->shape = *shape;
    }
    if (from != NULL) {
        (void)printable((const uint8_t *)from, strlen(from), table->from,
                        sizeof table->from);
    }
}

/* The texts of all command TLVs in one, to be held against the answer; a table
 * counts as a word, as what names it refuses nothing else. */
static void gather(const struct ctl *ctl, lum_tlv_reader reader,
                   char out[TEXT_BYTES + 1])
{
    const uint16_t *numbers = ctl->layout.profile.tlv;
    lum_tlv tlv;
    size_t n = 0;
    out[0] = '\0';
    while (lum_tlv_next(&reader, &tlv) == LUM_OK && n < TEXT_BYTES) {
        if (tlv.type == numbers[LUM_TLV_COMMAND]) {
            n += (size_t)snprintf(out + n, TEXT_BYTES + 1 - n, "%s%.*s",
                                  n != 0 ? " " : "", (int)tlv.length,
                                  (const char *)tlv.value);
        } else if (tlv.type == numbers[LUM_TLV_YSCAN]) {
            n += (size_t)snprintf(out + n, TEXT_BYTES + 1 - n, "%stable",
                                  n != 0 ? " " : "");
        }
    }
}

/* A request that was sent, and its result. */
struct sent {
    struct ctl *ctl;
    const struct ctl_answer *answer; /* NULL: none came */
    bool has_unnamed; /* the answer refuses something that it does not name */
    int64_t utc_ns;
};

static enum memory_standing standing_of(const struct sent *s)
{
    return s->answer == NULL || s->has_unnamed ? MEMORY_UNSURE : MEMORY_DONE;
}

static bool is_refused(const struct sent *s, const lum_command *command)
{
    struct refusal refusal;
    char text[LUM_COMMAND_TEXT_BYTES + 1];
    size_t len = 0;
    if (s->answer == NULL ||
        lum_command_format(command, text, &len) != LUM_OK) {
        return false;
    }
    text[len] = '\0';
    return refusal_find(text, s->answer->debug, &refusal) &&
           refusal.names[0] != '\0';
}

/* What is no text of the manual may have set anything. */
static void take_text(const struct sent *s, const lum_tlv *tlv)
{
    const char *text = (const char *)tlv->value;
    size_t len = tlv->length;
    lum_command command;
    lum_result result = LUM_OK;
    while ((result = lum_command_parse(&text, &len, &command)) == LUM_OK) {
        if (!is_refused(s, &command)) {
            memory_take(&s->ctl->changes, &command, standing_of(s), s->utc_ns);
        }
    }
    s->ctl->changes.is_unclear |= result != LUM_END;
}

static void take_table(const struct sent *s, const lum_tlv *tlv)
{
    const struct memory_table unknown = {.scan = MEMORY_TABLE};
    const struct memory_table *table =
        s->ctl->table.scan != MEMORY_DEGREES ? &s->ctl->table : &unknown;
    if (s->answer != NULL && yscan_is_refused(s->answer->debug)) {
        return;
    }
    if (tlv->length < 2) {
        s->ctl->changes.is_unclear = true;
        return;
    }
    memory_take_table(&s->ctl->changes, table, (uint16_t)(tlv->length / 2u),
                      standing_of(s), s->utc_ns);
}

void remember_request(struct ctl *ctl, const void *tlvs, size_t len,
                      const struct ctl_answer *answer)
{
    const uint16_t *numbers = ctl->layout.profile.tlv;
    struct sent s = {ctl, answer, false, lum_time_utc_ns()};
    lum_tlv_reader reader = {tlvs, len};
    struct refusal refusal;
    char text[TEXT_BYTES + 1];
    lum_tlv tlv;
    if (len == 0) {
        return;
    }
    gather(ctl, reader, text);
    s.has_unnamed = answer != NULL &&
                    refusal_find(text, answer->debug, &refusal) &&
                    refusal.has_unnamed;
    while (lum_tlv_next(&reader, &tlv) == LUM_OK) {
        if (tlv.type == numbers[LUM_TLV_COMMAND]) {
            take_text(&s, &tlv);
        } else if (tlv.type == numbers[LUM_TLV_YSCAN]) {
            take_table(&s, &tlv);
        }
    }
}

/* --- The file of a sensor --- */

static void key_of(const struct ctl *ctl, lum_endpoint host,
                   struct memory_key *out)
{
    *out = (struct memory_key){.address = host.address, .port = host.port};
    if (ctl->options.interface != NULL) {
        (void)snprintf(out->interface, sizeof out->interface, "%s",
                       ctl->options.interface);
    } else if (!lum_route_interface(host.address, out->interface,
                                    sizeof out->interface)) {
        out->interface[0] = '\0';
    }
}

static int64_t lock_ns(const struct ctl *ctl)
{
    return ctl->owns ? LOCK_OWNER_NS : LOCK_NS;
}

static bool is_plain(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           (c >= '0' && c <= '9') || c == '-' || c == '.';
}

/* Any name of an interface as part of a file's name. */
static int find_path(const struct memory_key *key, const char *folder,
                     char out[STATE_PATH_BYTES], lum_error *error)
{
    const lum_endpoint host = {key->address, LUM_PORT};
    size_t n = (size_t)snprintf(out, STATE_PATH_BYTES, "%s/%s_%u_", folder,
                                session_name(host).text, (unsigned)key->port);
    for (const char *c = key->interface; *c != '\0' && n < STATE_PATH_BYTES;
         c++) {
        n += (size_t)snprintf(out + n, STATE_PATH_BYTES - n,
                              is_plain(*c) ? "%c" : "=%02x",
                              is_plain(*c) ? *c : (unsigned char)*c);
    }
    return n < STATE_PATH_BYTES
               ? 0
               : lum_error_set(error, "the name of its file would be too long");
}

/* A file that makes no sense is said and passed over: the next change replaces
 * it. */
static bool load(const struct ctl *ctl, const struct memory_key *key,
                 const char *path, struct memory *out)
{
    char text[MEMORY_TEXT_BYTES];
    lum_error error = {""};
    const int found = state_read(path, text, sizeof text, &error);
    if (found == 1 && memory_read(text, key, out, &error) == 0) {
        return true;
    }
    *out = (struct memory){.clock = {0}};
    if (found == 1) {
        ctl_note(ctl, "%s: %s; it is ignored", path, error.text);
    } else if (found < 0) {
        ctl_note(ctl, "%s; it is ignored", error.text);
    }
    return false;
}

static int save(const struct memory_key *key, const char *path,
                const struct memory *memory, lum_error *error)
{
    char text[MEMORY_TEXT_BYTES];
    const size_t len = memory_write(key, memory, text);
    return state_write(path, text, len, error);
}

/* --- Whether the sensor has restarted --- */

static void read_clock(const lum_sensor_event *event, struct memory_clock *out)
{
    const int64_t half = (event->received_ns - event->sent_ns) / 2;
    *out = (struct memory_clock){.is_known = true,
                                 .utc_ns = event->received_utc_ns - half,
                                 .clock_us = event->clock_us,
                                 .error_ns = half};
}

/* A short look: the command itself is done, and must not seem to hang. */
static void ask_clock(struct ctl *ctl, struct memory_clock *out)
{
    const int64_t end = lum_time_monotonic_ns() + CLOCK_NS;
    lum_sensor_event event = {.kind = LUM_SENSOR_IDLE};
    *out = (struct memory_clock){.is_known = false};
    if (ctl->sensor == NULL || lum_cancel_is_raised(ctl->cancel) ||
        session_request_time(ctl) != LUM_OK) {
        return;
    }
    while (lum_time_monotonic_ns() < end) {
        const lum_sensor_event_kind kind = session_wait(ctl, end, &event);
        if (kind == LUM_SENSOR_TIME) {
            read_clock(&event, out);
        }
        if (kind == LUM_SENSOR_TIME || kind == LUM_SENSOR_NO_ANSWER ||
            kind == LUM_SENSOR_CANCELLED || kind == LUM_SENSOR_FAILED) {
            return;
        }
    }
    lum_sensor_give_up(ctl->sensor);
}

/* --- What was set, into the file --- */

/* Nothing is kept of an address where nobody ever answered. */
static bool is_acknowledged(const struct memory *changes)
{
    for (size_t i = 0; i < LUM_COMMANDS; i++) {
        if (changes->entries[i].standing == MEMORY_DONE) {
            return true;
        }
    }
    return false;
}

/* Read, changed and written under the lock, since two may do so at once. */
static int merge(const struct ctl *ctl, const struct memory_clock *clock,
                 lum_error *error)
{
    struct memory_key key;
    struct memory memory;
    char folder[STATE_PATH_BYTES];
    char path[STATE_PATH_BYTES];
    double missed = 0.0;
    key_of(ctl, session_host(ctl), &key);
    const int lock = state_folder(folder, error) != 0 ||
                             find_path(&key, folder, path, error) != 0
                         ? -1
                         : state_lock(folder, lock_ns(ctl), error);
    if (lock < 0) {
        return -1;
    }
    if (!load(ctl, &key, path, &memory) && !is_acknowledged(&ctl->changes)) {
        (void)close(lock);
        return 0;
    }
    const bool had_any = memory_has_any(&memory);
    if (memory_see_clock(&memory, clock, &missed) == MEMORY_OTHER_RUN &&
        had_any) {
        ctl_note(ctl,
                 "the clock of %s has started again since its settings were "
                 "remembered: it has restarted, and the old settings are gone",
                 session_name(session_host(ctl)).text);
    }
    memory_merge(&memory, &ctl->changes, lum_time_utc_ns());
    const int result = save(&key, path, &memory, error);
    (void)close(lock);
    return result;
}

void remember_changes(struct ctl *ctl)
{
    struct memory_clock clock = {.is_known = false};
    lum_error error = {""};
    if (memory_has_any(&ctl->changes)) {
        if (is_acknowledged(&ctl->changes)) {
            ask_clock(ctl, &clock);
        }
        if (merge(ctl, &clock, &error) != 0) {
            ctl_note(ctl, "what was set is not remembered for lumctl show: %s",
                     error.text);
        }
    }
    ctl->changes = (struct memory){.clock = {0}};
    ctl->table = (struct memory_table){.scan = MEMORY_DEGREES};
}

/* --- A sensor with a new address --- */

static int move_file(const struct ctl *ctl, const char *folder,
                     const struct memory_key *from, const struct memory_key *to,
                     lum_error *error)
{
    struct memory memory;
    char old[STATE_PATH_BYTES];
    char new[STATE_PATH_BYTES];
    if (find_path(from, folder, old, error) != 0 ||
        find_path(to, folder, new, error) != 0) {
        return -1;
    }
    if (strcmp(old, new) == 0) {
        return 0;
    }
    if (!load(ctl, from, old, &memory)) {
        (void)unlink(new);
        return 0;
    }
    if (save(to, new, &memory, error) != 0) {
        return -1;
    }
    (void)unlink(old);
    return 0;
}

void remember_move(const struct ctl *ctl, lum_endpoint from, lum_endpoint to)
{
    struct memory_key old;
    struct memory_key new;
    char folder[STATE_PATH_BYTES];
    lum_error error = {""};
    key_of(ctl, from, &old);
    key_of(ctl, to, &new);
    const int lock = state_folder(folder, &error) == 0
                         ? state_lock(folder, lock_ns(ctl), &error)
                         : -1;
    int result = -1;
    if (lock >= 0) {
        result = move_file(ctl, folder, &old, &new, &error);
        (void)close(lock);
    }
    if (result != 0) {
        ctl_note(ctl,
                 "what is remembered for lumctl show was not moved to the new "
                 "address: %s",
                 error.text);
    }
}

/* --- What is remembered, for show and save --- */

static enum exit_status ask(struct ctl *ctl, struct memory_clock *out)
{
    lum_sensor_event event;
    enum exit_status status = ctl_open(ctl, false);
    *out = (struct memory_clock){.is_known = false};
    if (status != EXIT_DONE) {
        return status;
    }
    if (session_request_time(ctl) != LUM_OK) {
        return ctl_complain(EXIT_FAILED, "the request cannot be made");
    }
    status = session_finish(ctl, &event);
    if (status == EXIT_DONE) {
        read_clock(&event, out);
    }
    return status;
}

/* Compares the remembered settings with the clock, and stores the result. A
 * failure to store does no harm: the next comparison uses the older reading. */
static void see(const struct ctl *ctl, const char *folder, const char *path,
                struct remembered *out)
{
    lum_error error = {""};
    const int lock =
        out->clock.is_known ? state_lock(folder, lock_ns(ctl), &error) : -1;
    if (lock >= 0) {
        out->has_file = load(ctl, &out->key, path, &out->memory);
    }
    out->run = memory_see_clock(&out->memory, &out->clock, &out->missed);
    if (lock >= 0) {
        (void)save(&out->key, path, &out->memory, &error);
        (void)close(lock);
    }
}

enum exit_status remember_look(struct ctl *ctl, struct remembered *out)
{
    char folder[STATE_PATH_BYTES];
    char path[STATE_PATH_BYTES];
    lum_error error = {""};
    *out = (struct remembered){.run = MEMORY_RUN_UNKNOWN, .missed = 1.0};
    const enum exit_status status = ask(ctl, &out->clock);
    key_of(ctl, session_host(ctl), &out->key);
    out->has_answered = out->clock.is_known;
    if (state_folder(folder, &error) != 0 ||
        find_path(&out->key, folder, path, &error) != 0) {
        return status != EXIT_DONE
                   ? status
                   : ctl_complain(EXIT_FAILED, "nothing can be remembered: %s",
                                  error.text);
    }
    out->has_file = load(ctl, &out->key, path, &out->memory);
    if (out->has_file) {
        see(ctl, folder, path, out);
    }
    return status;
}
