/* Opens a URL in a browser for a person. */
#ifndef LUMVIEW_BROWSER_H
#define LUMVIEW_BROWSER_H

#include <stdbool.h>

#define BROWSER_FOLDER_BYTES 512u
#define BROWSER_FILE_BYTES   (BROWSER_FOLDER_BYTES + 16u)
/* file://, each byte of the name as three, a NUL */
#define BROWSER_URL_BYTES (3u * BROWSER_FILE_BYTES + 8u)

/* A file that leads a browser on to a secret URL. All bytes 0: none. */
struct browser {
    char folder[BROWSER_FOLDER_BYTES]; /* of this user alone; "": none */
    char file[BROWSER_FILE_BYTES];
    char url[BROWSER_URL_BYTES]; /* file:// */
};

/* Start $BROWSER, or else the desktop's own, with a URL, which stays as it is,
 * and do not wait for it. All users of a host see the arguments of its
 * programs: a secret URL goes by a file, below XDG_RUNTIME_DIR, TMPDIR or /tmp.
 * False: there is none to start, no screen for it, or no place for a file. */
bool browser_open(struct browser *browser, char *url, bool is_secret);

/* Remove the file, if there is one. */
void browser_forget(struct browser *browser);

#endif
