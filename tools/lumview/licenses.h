/* The permissions that come with what is in the program. */
#ifndef LUMVIEW_LICENSES_H
#define LUMVIEW_LICENSES_H

/* To standard output, whose state tells whether it went well. */
void licenses_print(void);

#endif
