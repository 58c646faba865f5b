#define _DEFAULT_SOURCE /* mkdtemp(), seteuid() */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/claim.h"
#include "base/outfile.h"
#include "base/outfile_io.h"
#include "lumdump/retention.h"

#include <dirent.h>
#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define S       INT64_C(1000000000)
#define START   (INT64_C(1795000000) * S)
#define LEDGER  ".r.pcap.kept.lumsdk"
#define BYTES   100u
#define NOBODY  65534u
#define NAME_OF "r-%04u.pcap"

static const struct rotation no_limit = {.ns = INT64_C(1) << 60};

static char folder[] = "/tmp/test_retention_XXXXXX";

/* --- Files --- */

static void put(const char *name, size_t bytes)
{
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    for (size_t i = 0; i < bytes; i++) {
        assert_int_equal(fputc('x', file), 'x');
    }
    assert_int_equal(fclose(file), 0);
}

static void put_text(const char *name, const char *text)
{
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static const char *name_of(unsigned number)
{
    static char name[64];
    (void)snprintf(name, sizeof name, NAME_OF, number);
    return name;
}

static bool is_there(unsigned number)
{
    return access(name_of(number), F_OK) == 0;
}

/* Files, those of the dot too. */
static unsigned count_files(void)
{
    DIR *directory = opendir(".");
    unsigned n = 0;
    assert_non_null(directory);
    for (struct dirent *e = readdir(directory); e != NULL;
         e = readdir(directory)) {
        n += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    }
    assert_int_equal(closedir(directory), 0);
    return n;
}

static int setup(void **state)
{
    (void)state;
    (void)strcpy(folder, "/tmp/test_retention_XXXXXX");
    return mkdtemp(folder) == NULL || chdir(folder) != 0;
}

static int teardown(void **state)
{
    DIR *directory = opendir(".");
    (void)state;
    for (struct dirent *e = readdir(directory); e != NULL;
         e = readdir(directory)) {
        if (unlink(e->d_name) != 0) {
            (void)rmdir(e->d_name);
        }
    }
    (void)closedir(directory);
    return chdir("/") != 0 || rmdir(folder) != 0;
}

/* --- A disk that is slow --- */

#define DISK_WAIT_S 5

static struct {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    bool is_slow;
    bool is_syncing;
} disk = {PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, false, false};

/* In place of the system's: waits until the disk is no longer slow, but not for
 * ever. */
int fsync(int fd)
{
    const struct timespec end = {.tv_sec = time(NULL) + DISK_WAIT_S};
    int code = 0;
    (void)fd;
    (void)pthread_mutex_lock(&disk.lock);
    disk.is_syncing = true;
    (void)pthread_cond_broadcast(&disk.changed);
    while (disk.is_slow && code == 0) {
        code = pthread_cond_timedwait(&disk.changed, &disk.lock, &end);
    }
    disk.is_slow = false;
    disk.is_syncing = false;
    (void)pthread_mutex_unlock(&disk.lock);
    return 0;
}

static void make_slow(bool is_slow)
{
    (void)pthread_mutex_lock(&disk.lock);
    disk.is_slow = is_slow;
    (void)pthread_cond_broadcast(&disk.changed);
    (void)pthread_mutex_unlock(&disk.lock);
}

static void wait_for_sync(void)
{
    (void)pthread_mutex_lock(&disk.lock);
    while (!disk.is_syncing) {
        (void)pthread_cond_wait(&disk.changed, &disk.lock);
    }
    (void)pthread_mutex_unlock(&disk.lock);
}

static bool is_syncing(void)
{
    (void)pthread_mutex_lock(&disk.lock);
    const bool result = disk.is_syncing;
    (void)pthread_mutex_unlock(&disk.lock);
    return result;
}

/* --- Runs --- */

static struct retention *open_with(struct rotation limit)
{
    struct retention *retention = NULL;
    lum_error error = {""};
    if (retention_open("r.pcap", &limit, &retention, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return retention;
}

static unsigned begin(struct retention *retention)
{
    unsigned number = 0;
    assert_int_equal(retention_begin(retention, &number, NULL), 0);
    return number;
}

static void finish(struct retention *retention, unsigned number, int64_t second)
{
    assert_int_equal(
        retention_finish(retention, number, START + second * S, NULL), 0);
}

/* Files of BYTES, a second after the other. */
static void record(struct retention *retention, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        const unsigned number = begin(retention);
        assert_false(is_there(number));
        put(name_of(number), BYTES);
        finish(retention, number, number);
    }
}

/* The list as a run leaves it that is killed. */
static char *take_list(void)
{
    char *text = calloc(1, 4096);
    FILE *file = fopen(LEDGER, "rb");
    assert_non_null(text);
    assert_non_null(file);
    assert_true(fread(text, 1, 4095, file) > 0);
    assert_int_equal(fclose(file), 0);
    return text;
}

static void close_killed(struct retention *retention)
{
    char *text = take_list();
    retention_close(retention);
    put_text(LEDGER, text);
    free(text);
}

static uint64_t removed_by(struct retention *retention)
{
    struct retention_counts counts;
    retention_count(retention, &counts);
    assert_true(counts.is_used);
    return counts.removed;
}

/* --- Limits --- */

static void a_size_leaves_room_for_the_file_that_is_written(void **state)
{
    struct retention *retention =
        open_with((struct rotation){.bytes = 4u * BYTES});
    (void)state;
    record(retention, 3);
    assert_int_equal(removed_by(retention), 0);
    record(retention, 1);
    assert_int_equal(removed_by(retention), 1);
    assert_false(is_there(1));
    assert_true(is_there(2));
    record(retention, 10);
    assert_int_equal(count_files(), 4); /* with the list */
    assert_true(is_there(12));
    retention_close(retention);
}

static void a_larger_file_takes_the_place_of_several(void **state)
{
    struct retention *retention =
        open_with((struct rotation){.bytes = 10u * BYTES});
    (void)state;
    record(retention, 8);
    const unsigned number = begin(retention);
    put(name_of(number), 4u * BYTES);
    finish(retention, number, 9);
    assert_false(is_there(6)); /* 4 and 2 times 1, and 4 to come */
    assert_true(is_there(7));
    retention_close(retention);
}

static void the_newest_whole_file_stays(void **state)
{
    struct retention *retention = open_with((struct rotation){.bytes = 1});
    (void)state;
    record(retention, 3);
    assert_true(is_there(3));
    assert_int_equal(removed_by(retention), 2);
    retention_close(retention);
    retention = open_with((struct rotation){.ns = 1});
    assert_true(is_there(3));
    retention_close(retention);
}

static void age_is_that_of_the_data(void **state)
{
    struct retention *retention = open_with((struct rotation){.ns = 3 * S});
    (void)state;
    record(retention, 4);
    assert_int_equal(removed_by(retention),
                     0); /* exactly as old as it may be */
    record(retention, 1);
    assert_false(is_there(1));
    assert_true(is_there(2));
    const unsigned number = begin(retention);
    put(name_of(number), BYTES);
    assert_int_equal(
        retention_finish(retention, number, START + 5 * S + 1, NULL), 0);
    assert_false(is_there(2));
    assert_true(is_there(3));
    retention_close(retention);
}

static void a_clock_that_went_back_removes_nothing(void **state)
{
    struct retention *retention = open_with((struct rotation){.ns = 3 * S});
    (void)state;
    record(retention, 3);
    const unsigned number = begin(retention);
    put(name_of(number), BYTES);
    assert_int_equal(retention_finish(retention, number, INT64_MIN, NULL), 0);
    assert_int_equal(removed_by(retention), 0);
    retention_close(retention);
}

/* --- Restarts --- */

static void a_restart_goes_on_and_removes_the_old_ones(void **state)
{
    struct retention *retention = open_with(no_limit);
    (void)state;
    record(retention, 5);
    retention_close(retention);
    retention = open_with((struct rotation){.bytes = 3u * BYTES});
    assert_int_equal(removed_by(retention), 3);
    assert_int_equal(begin(retention), 6);
    retention_close(retention);
}

static void a_number_that_was_not_used_is_used_again(void **state)
{
    struct retention *retention = NULL;
    (void)state;
    for (int i = 0; i < 3; i++) {
        retention = open_with(no_limit);
        assert_int_equal(begin(retention), 1);
        retention_close(retention);
    }
    close_killed(open_with(no_limit));
    retention = open_with(no_limit);
    assert_int_equal(begin(retention), 2); /* whose it is was not known */
    retention_close(retention);
}

static void a_file_of_a_killed_run_is_ours(void **state)
{
    struct retention *retention = open_with(no_limit);
    (void)state;
    assert_int_equal(begin(retention), 1);
    put(name_of(1), BYTES);
    close_killed(retention);
    retention = open_with((struct rotation){.bytes = 2u * BYTES});
    record(retention, 1);
    assert_false(is_there(1));
    assert_true(is_there(2));
    retention_close(retention);
}

/* The unfinished file is as lum_outfile_open() makes it, without its lock, as
 * after a kill. */
static void an_unfinished_file_goes_and_what_has_its_name_stays(void **state)
{
    struct retention *retention = open_with(no_limit);
    (void)state;
    assert_int_equal(begin(retention), 1);
    put(name_of(1), BYTES); /* by others */
    put("r-0001.pcap.0123456789ab.part", 5);
    put_text(".r-0001.pcap.lumsdk", "lumsdk\nprocess 1\nunfinished "
                                    "r-0001.pcap.0123456789ab.part\n");
    close_killed(retention);
    retention = open_with((struct rotation){.bytes = 1});
    record(retention, 2);
    assert_true(is_there(1));
    assert_false(is_there(2));
    retention_close(retention);
    assert_int_equal(count_files(), 3);
}

static void a_run_that_still_writes_keeps_its_file(void **state)
{
    struct retention *retention = open_with(no_limit);
    lum_outfile file;
    (void)state;
    assert_int_equal(begin(retention), 1);
    assert_int_equal(
        lum_outfile_open(name_of(1), LUM_OUTFILE_WHOLE, &file, NULL), 0);
    close_killed(retention);
    retention = open_with((struct rotation){.bytes = 1});
    assert_int_equal(access(file.part, F_OK), 0);
    record(retention, 2);
    assert_int_equal(lum_outfile_finish(&file, NULL), 0);
    lum_outfile_discard(&file);
    record(retention, 1);
    assert_true(is_there(1));
    retention_close(retention);
}

/* --- Files of others --- */

static void no_file_of_others_is_removed_or_replaced(void **state)
{
    static const char *const others[] = {
        "r-0001.pcap", "r-0003.pcap", "r-0009.pcap",  "r-2.pcap",
        "r-.pcap",     "r-x.pcap",    "r-0001.pcapx", "q-0002.pcap",
        "r.pcap",      "xr-0012.pcap"};
    static const unsigned free_numbers[] = {2, 4, 5, 6, 7, 8, 10};
    const size_t n = sizeof others / sizeof others[0];
    (void)state;
    for (size_t i = 0; i < n; i++) {
        put(others[i], 7);
    }
    struct retention *retention = open_with((struct rotation){.bytes = 1});
    for (unsigned i = 0; i < sizeof free_numbers / sizeof free_numbers[0];
         i++) {
        assert_int_equal(begin(retention), free_numbers[i]);
    }
    put(name_of(11), 7);
    assert_int_equal(begin(retention), 12);
    put(name_of(12), BYTES);
    finish(retention, 12, 1);
    assert_true(retention_is_planned(retention) ||
                retention_plan(retention, NULL) == 0);
    put(name_of(13), 7); /* what was planned */
    assert_false(retention_is_planned(retention));
    record(retention, 2);
    assert_false(is_there(12));
    assert_true(is_there(11));
    assert_true(is_there(13));
    assert_true(is_there(15));
    retention_close(retention);
    for (size_t i = 0; i < n; i++) {
        struct stat status;
        assert_int_equal(stat(others[i], &status), 0);
        assert_int_equal(status.st_size, 7);
    }
}

static void a_file_that_others_changed_is_left_and_told_once(void **state)
{
    struct retention *retention = open_with(no_limit);
    lum_error note = {""};
    (void)state;
    record(retention, 5);
    retention_close(retention);
    put(name_of(1), BYTES + 1u);
    put(name_of(2), BYTES - 1u);
    assert_int_equal(unlink(name_of(3)), 0);
    assert_int_equal(unlink(name_of(4)), 0);
    assert_int_equal(symlink("r-0005.pcap", "r-0004.pcap"), 0);
    retention = open_with((struct rotation){.bytes = 1});
    assert_int_equal(removed_by(retention), 0);
    assert_true(retention_take_note(retention, &note));
    assert_non_null(strstr(note.text, "r-0001.pcap: others have changed it"));
    assert_false(retention_take_note(retention, &note));
    assert_true(is_there(1));
    assert_true(is_there(2));
    assert_true(is_there(4));
    retention_close(retention);
    retention = open_with((struct rotation){.bytes = 1});
    assert_false(
        retention_take_note(retention, &note)); /* they are forgotten */
    retention_close(retention);
}

static void a_file_that_cannot_be_removed_is_tried_again(void **state)
{
    struct retention_counts counts;
    lum_error note = {""};
    (void)state;
    const bool is_root = geteuid() == 0; /* whom no folder refuses */
    if (is_root && (chown(".", NOBODY, NOBODY) != 0 || seteuid(NOBODY) != 0)) {
        skip();
    }
    struct retention *retention =
        open_with((struct rotation){.bytes = 2u * BYTES});
    record(retention, 1);
    const unsigned number = begin(retention);
    put(name_of(number), BYTES);
    assert_int_equal(chmod(".", S_IRUSR | S_IXUSR), 0);
    (void)!retention_finish(retention, number, START, NULL);
    assert_int_equal(chmod(".", S_IRWXU), 0);
    retention_count(retention, &counts);
    assert_int_equal(counts.stuck, 1);
    assert_true(retention_take_note(retention, &note));
    assert_non_null(strstr(note.text, "cannot remove it"));
    record(retention, 1);
    retention_count(retention, &counts);
    assert_int_equal(counts.stuck, 0);
    assert_int_equal(counts.removed, 2);
    retention_close(retention);
    assert_true(!is_root || seteuid(0) == 0);
}

/* --- Two threads --- */

static void *finish_second(void *argument)
{
    return retention_finish(argument, 2, START, NULL) == 0 ? argument : NULL;
}

static void a_planned_number_does_not_wait_for_the_disk(void **state)
{
    struct retention_counts counts;
    lum_error note = {""};
    pthread_t thread;
    void *result = NULL;
    (void)state;
    struct retention *retention = open_with((struct rotation){.bytes = 1});
    record(retention, 1);
    put(name_of(1), BYTES + 1u); /* by others */
    assert_int_equal(retention_plan(retention, NULL), 0);
    put(name_of(begin(retention)), BYTES);
    assert_int_equal(retention_plan(retention, NULL), 0);
    make_slow(true);
    assert_int_equal(pthread_create(&thread, NULL, finish_second, retention),
                     0);
    wait_for_sync();
    assert_true(retention_is_planned(retention));
    assert_int_equal(begin(retention), 3);
    assert_false(retention_is_planned(retention));
    assert_true(retention_take_note(retention, &note));
    retention_count(retention, &counts);
    assert_true(is_syncing()); /* nothing of this has waited */
    make_slow(false);
    assert_int_equal(pthread_join(thread, &result), 0);
    assert_ptr_equal(result, retention);
    retention_close(retention);
}

/* --- The list --- */

static void a_list_that_is_something_else_is_refused(void **state)
{
    struct retention *retention = NULL;
    lum_error error = {""};
    (void)state;
    put_text(LEDGER, "lumsdk\n");
    assert_int_equal(retention_open("r.pcap", &no_limit, &retention, &error),
                     -1);
    assert_int_equal(errno, EEXIST);
    assert_non_null(strstr(error.text, LEDGER));
    assert_int_equal(unlink(LEDGER), 0);
    put_text("other", "lumdump keep 1\nend\n");
    assert_int_equal(symlink("other", LEDGER), 0);
    assert_int_equal(retention_open("r.pcap", &no_limit, &retention, &error),
                     -1);
    assert_int_equal(unlink(LEDGER), 0);
    assert_int_equal(mkdir(LEDGER, S_IRWXU), 0);
    assert_int_equal(retention_open("r.pcap", &no_limit, &retention, &error),
                     -1);
    assert_int_equal(errno, EEXIST);
}

/* However it was cut, what it lists no more stays, and numbers go on. */
static void a_damaged_list_removes_nothing_but_what_it_has(void **state)
{
    struct retention *retention = open_with(no_limit);
    (void)state;
    record(retention, 3);
    close_killed(retention);
    char *text = take_list();
    for (size_t len = 0; len < strlen(text); len++) {
        lum_error note = {""};
        FILE *file = fopen(LEDGER, "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(text, 1, len, file), len);
        assert_int_equal(fclose(file), 0);
        retention = open_with(no_limit);
        assert_true(retention_take_note(retention, &note));
        assert_non_null(strstr(note.text, "is damaged"));
        assert_int_equal(begin(retention), 4);
        retention_close(retention);
        assert_int_equal(count_files(), 4);
    }
    free(text);
}

static void numbers_follow_the_list_and_no_name_of_others(void **state)
{
    (void)state;
    put("r-20261128.pcap", 1);
    put("r-999999999.pcap", 1);
    put("r-99999999999999999999999.pcap", 1);
    struct retention *retention = open_with(no_limit);
    record(retention, 3);
    retention_close(retention);
    put(name_of(4), 1);
    retention = open_with(no_limit);
    assert_int_equal(begin(retention), 5);
    retention_close(retention);
}

static void a_lost_list_lets_no_file_be_replaced(void **state)
{
    (void)state;
    struct retention *retention = open_with((struct rotation){.bytes = 300});
    record(retention, 9);
    retention_close(retention);
    assert_int_equal(unlink(LEDGER), 0);
    retention = open_with((struct rotation){.bytes = 300});
    record(retention, 12); /* asserts that none is there */
    assert_true(is_there(8));
    assert_true(is_there(9));
    assert_true(is_there(14));
    assert_int_equal(count_files(), 5);
    retention_close(retention);
}

static void numbers_end(void **state)
{
    struct retention *retention = NULL;
    lum_error error = {""};
    (void)state;
    put_text(LEDGER, "lumdump keep 1\n999999999 1 1\nend\n");
    assert_int_equal(retention_open("r.pcap", &no_limit, &retention, &error),
                     -1);
    assert_non_null(strstr(error.text, "used up"));
}

static void names_may_be_odd(void **state)
{
    static const char *const names[] = {"./a b\"'-1.x.pcap", "a b-1",
                                        ".hidden",           "-.pcap",
                                        "a\nb.pcap",         "\xff\xfe.pcap"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        for (unsigned number = 1; number < 4; number++) {
            struct retention *retention = NULL;
            assert_int_equal(
                retention_open(names[i], &no_limit, &retention, NULL), 0);
            assert_int_equal(begin(retention), 1);
            retention_close(retention);
        }
    }
}

static void a_name_or_a_folder_that_cannot_be_is_refused(void **state)
{
    static char name[5000];
    struct retention *retention = NULL;
    lum_error error = {""};
    (void)state;
    memset(name, 'n', sizeof name - 1u);
    assert_int_equal(retention_open(name, &no_limit, &retention, &error), -1);
    assert_int_equal(retention_open("no/r.pcap", &no_limit, &retention, &error),
                     -1);
    assert_non_null(strstr(error.text, "does not exist"));
}

#define TEST(fact) cmocka_unit_test_setup_teardown(fact, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_size_leaves_room_for_the_file_that_is_written),
        TEST(a_larger_file_takes_the_place_of_several),
        TEST(the_newest_whole_file_stays),
        TEST(age_is_that_of_the_data),
        TEST(a_clock_that_went_back_removes_nothing),
        TEST(a_restart_goes_on_and_removes_the_old_ones),
        TEST(a_number_that_was_not_used_is_used_again),
        TEST(a_file_of_a_killed_run_is_ours),
        TEST(an_unfinished_file_goes_and_what_has_its_name_stays),
        TEST(a_run_that_still_writes_keeps_its_file),
        TEST(no_file_of_others_is_removed_or_replaced),
        TEST(a_file_that_others_changed_is_left_and_told_once),
        TEST(a_file_that_cannot_be_removed_is_tried_again),
        TEST(a_planned_number_does_not_wait_for_the_disk),
        TEST(a_list_that_is_something_else_is_refused),
        TEST(a_damaged_list_removes_nothing_but_what_it_has),
        TEST(numbers_follow_the_list_and_no_name_of_others),
        TEST(a_lost_list_lets_no_file_be_replaced),
        TEST(numbers_end),
        TEST(names_may_be_odd),
        TEST(a_name_or_a_folder_that_cannot_be_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
