#include "option_calls.h"

#include "trace.h"

#include <getopt.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

/* As the tools use it: it stops at the first word, and prints no messages ("+:"
 * and opterr = 0). */
WORLD_OWN char *world_call_optarg = NULL;
WORLD_OWN int world_call_optind = 1;
WORLD_OWN int world_call_opterr = 1;
WORLD_OWN int world_call_optopt = '?';
WORLD_OWN static const char *letters = NULL; /* left of "-abc" */

static int say_bad(int option)
{
    world_call_optopt = option;
    return '?';
}

/* The option's value is the next word. false: there is none. */
static bool take_word(int count, char *const *words)
{
    if (world_call_optind >= count) {
        return false;
    }
    world_call_optarg = words[world_call_optind++];
    return true;
}

/* The one of this name, or the only one that begins so. NULL: none; two: more
 * than one. */
static const struct option *find_long(const struct option *named,
                                      const char *name, size_t length,
                                      bool *two)
{
    const struct option *found = NULL;
    *two = false;
    for (const struct option *o = named; o->name != NULL; o++) {
        if (strncmp(o->name, name, length) != 0) {
            continue;
        }
        if (o->name[length] == '\0') {
            *two = false;
            return o;
        }
        *two = *two || found != NULL;
        found = found == NULL ? o : found;
    }
    return found;
}

static int take_long(int count, char *const *words, const struct option *named,
                     int *index)
{
    const char *word = words[world_call_optind++] + 2;
    const size_t length = strcspn(word, "=");
    bool two = false;
    const struct option *o = find_long(named, word, length, &two);
    if (o == NULL || two) {
        return say_bad(0);
    }
    const bool has_value = word[length] == '=';
    if (has_value && o->has_arg == no_argument) {
        return say_bad(o->val);
    }
    if (has_value) {
        world_call_optarg = words[world_call_optind - 1] + 2 + length + 1;
    } else if (o->has_arg == required_argument && !take_word(count, words)) {
        world_call_optopt = o->val;
        return ':';
    }
    if (index != NULL) {
        *index = (int)(o - named);
    }
    if (o->flag != NULL) {
        *o->flag = o->val;
        return 0;
    }
    return o->val;
}

/* The rest of the word is the value, or the next word. */
static int take_letter(int count, char *const *words, const char *known)
{
    const char letter = *letters++;
    const char *spec = letter == ':' ? NULL : strchr(known, letter);
    const bool takes_value = spec != NULL && spec[1] == ':';
    const char *rest = letters;
    if (*letters == '\0' || takes_value) {
        world_call_optind++;
        letters = NULL;
    }
    if (spec == NULL) {
        return say_bad((unsigned char)letter);
    }
    if (takes_value && *rest != '\0') {
        world_call_optarg = words[world_call_optind - 1] +
                            strlen(words[world_call_optind - 1]) - strlen(rest);
    } else if (takes_value && !take_word(count, words)) {
        world_call_optopt = (unsigned char)letter;
        return ':';
    }
    return (unsigned char)letter;
}

int world_call_getopt_long(int count, char *const *words, const char *known,
                           const struct option *named, int *index)
{
    if (known[0] != '+' || known[1] != ':' || world_call_opterr != 0) {
        world_fail("getopt_long() is asked in a way that the world lacks");
    }
    world_call_optarg = NULL;
    if (world_call_optind == 0) {
        world_call_optind = 1;
        letters = NULL;
    }
    if (letters != NULL) {
        return take_letter(count, words, known + 2);
    }
    const char *word =
        world_call_optind < count ? words[world_call_optind] : NULL;
    if (word == NULL || word[0] != '-' || word[1] == '\0') {
        return -1;
    }
    if (strcmp(word, "--") == 0) {
        world_call_optind++;
        return -1;
    }
    if (word[1] == '-') {
        return take_long(count, words, named, index);
    }
    letters = word + 1;
    return take_letter(count, words, known + 2);
}
