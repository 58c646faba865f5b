/* Elevations from a file, one on each line. */
#include "yscan_shape.h"

#include "../../common/input_files.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#define LINE_BYTES 256

struct csv {
    FILE *file;
    const char *name;
    unsigned long line; /* of the file, from 1 */
    bool past_header;
    char text[LINE_BYTES];
};

/* Takes a comment and white space off. Returns the rest, inside text. */
static char *bare(char *text)
{
    static const char blanks[] = " \t\r\n";
    text[strcspn(text, "#")] = '\0';
    text += strspn(text, blanks);
    size_t len = strlen(text);
    while (len > 0 && strchr(blanks, text[len - 1]) != NULL) {
        len--;
    }
    text[len] = '\0';
    return text;
}

/* The first line that holds something may be a header. */
static bool is_header(struct csv *csv, const char *text)
{
    const bool is_first = !csv->past_header;
    csv->past_header = true;
    return is_first && strpbrk(text, "abcdefghijklmnopqrstuvwxyz"
                                     "ABCDEFGHIJKLMNOPQRSTUVWXYZ") == text;
}

/* Reads up to the next elevation; *is_end when none is left. */
static enum exit_status read_elevation(struct csv *csv, int32_t *udeg,
                                       bool *is_end)
{
    while (fgets(csv->text, sizeof csv->text, csv->file) != NULL) {
        csv->line++;
        if (strlen(csv->text) + 1 == sizeof csv->text) {
            return ctl_complain(EXIT_BAD, "%s:%lu: longer than %d characters",
                                csv->name, csv->line, LINE_BYTES - 2);
        }
        const char *text = bare(csv->text);
        if (*text == '\0' || is_header(csv, text)) {
            continue;
        }
        if (!yscan_parse_degrees(text, udeg)) {
            return ctl_complain(EXIT_BAD,
                                "%s:%lu: '%.40s' is not an elevation: a number "
                                "of degrees from -90 to 90, one a line",
                                csv->name, csv->line, text);
        }
        return EXIT_DONE;
    }
    *is_end = true;
    return EXIT_DONE;
}

static enum exit_status complain_count(const char *name, size_t count,
                                       size_t lines)
{
    return ctl_complain(EXIT_BAD,
                        "%s: %lu elevations; %lu lines need one each (--lines "
                        "640 or 64 says how many)",
                        name, (unsigned long)count, (unsigned long)lines);
}

static enum exit_status read_all(struct csv *csv, int32_t *udeg, size_t lines)
{
    bool is_end = false;
    size_t count = 0;
    for (;;) {
        int32_t value = 0;
        const enum exit_status status = read_elevation(csv, &value, &is_end);
        if (status != EXIT_DONE) {
            return status;
        }
        if (is_end) {
            break;
        }
        if (count < lines) {
            udeg[count] = value;
        }
        count++;
    }
    if (ferror(csv->file) != 0) {
        return ctl_complain(EXIT_BAD, "%s: cannot be read: %s", csv->name,
                            strerror(errno));
    }
    return count == lines ? EXIT_DONE : complain_count(csv->name, count, lines);
}

enum exit_status yscan_read_csv(const char *path, int32_t *udeg, size_t lines)
{
    const bool is_stdin = strcmp(path, "-") == 0;
    struct csv csv = {.name = is_stdin ? "<stdin>" : path};
    lum_error error = {""};
    if (input_files_check(&(struct input_file){path, "the list of elevations"},
                          1, "-", &error) != 0) {
        return ctl_complain(EXIT_BAD, "%s", error.text);
    }
    csv.file = is_stdin ? stdin : fopen(path, "r");
    if (csv.file == NULL) {
        return ctl_complain(EXIT_BAD, "%s: cannot be read: %s", path,
                            strerror(errno));
    }
    const enum exit_status status = read_all(&csv, udeg, lines);
    if (!is_stdin) {
        (void)fclose(csv.file);
    }
    return status;
}
