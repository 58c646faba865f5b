/* The texts of --help. */
#ifndef LUMCTL_HELP_H
#define LUMCTL_HELP_H

/* A name with what it takes (may be NULL), and what it is for. */
void help_row(const char *name, const char *takes, const char *text);

/* What stands before and behind the rows of the commands and options. */
void help_begin(void);
void help_end(void);

/* What stands before the options of one command. */
void help_command(const char *name, const char *takes, const char *summary);

#endif
