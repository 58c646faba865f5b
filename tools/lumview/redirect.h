/* A file that leads a browser on to a URL. All users of a host see the
 * arguments of its programs: a URL with a token must not be one. */
#ifndef LUMVIEW_REDIRECT_H
#define LUMVIEW_REDIRECT_H

#define REDIRECT_FOLDER_BYTES 512u
#define REDIRECT_FILE_BYTES   (REDIRECT_FOLDER_BYTES + 16u)
/* file://, each byte of the name as three, a NUL */
#define REDIRECT_URL_BYTES (3u * REDIRECT_FILE_BYTES + 8u)

struct redirect {
    char folder[REDIRECT_FOLDER_BYTES]; /* of this user alone; "": none */
    char file[REDIRECT_FILE_BYTES];
    char url[REDIRECT_URL_BYTES]; /* file:// */
};

/* Below XDG_RUNTIME_DIR, TMPDIR or /tmp. 0, or -1: none can be written. */
int redirect_write(struct redirect *redirect, const char *to);

/* Of one that was written, or is all zero. */
void redirect_remove(struct redirect *redirect);

#endif
