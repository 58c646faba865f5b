/* The texts of --help. */
#ifndef LUMCTL_HELP_H
#define LUMCTL_HELP_H

/* A name with its arguments (may be NULL), and its purpose. */
void help_row(const char *name, const char *takes, const char *text);

/* The text before and after the rows of the commands and options. */
extern const char help_begin[];
extern const char help_end[];

/* The text before the options of one command. */
void help_command(const char *name, const char *takes, const char *summary);

#endif
