/* The licences of the program and of its parts. */
#ifndef LUMVIEW_LICENSES_H
#define LUMVIEW_LICENSES_H

/* To standard output, whose state shows whether it succeeded. */
void licenses_print(void);

#endif
