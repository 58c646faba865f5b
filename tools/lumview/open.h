/* A browser for a person. */
#ifndef LUMVIEW_OPEN_H
#define LUMVIEW_OPEN_H

#include <stdbool.h>

/* Start $BROWSER, or else the desktop's own, with a URL, which stays as it
 * is, and do not wait for it. False: there is none to start, or no screen for
 * it. */
bool open_browser(char *url);

#endif
