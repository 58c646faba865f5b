/* Standard I/O as processes call it. A FILE of the system is never used: what
 * they hold is a stream of stdio.c. */
#ifndef WORLD_STDIO_CALLS_H
#define WORLD_STDIO_CALLS_H

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

extern FILE *world_call_stdin;
extern FILE *world_call_stdout;
extern FILE *world_call_stderr;

FILE *world_call_fopen64(const char *path, const char *mode);
FILE *world_call_fdopen(int fd, const char *mode);
FILE *world_call_tmpfile64(void);
FILE *world_call_open_memstream(char **text, size_t *len);
int world_call_fclose(FILE *file);
int world_call_fflush(FILE *file);
int world_call_setvbuf(FILE *file, char *buffer, int mode, size_t size);
int world_call_fileno(FILE *file);
int world_call_ferror(FILE *file);
int world_call_feof(FILE *file);
void world_call_clearerr(FILE *file);
void world_call_rewind(FILE *file);
int world_call_fseek(FILE *file, long offset, int whence);
long world_call_ftell(FILE *file);

size_t world_call_fwrite(const void *bytes, size_t size, size_t count,
                         FILE *file);
int world_call_fputs(const char *text, FILE *file);
int world_call_puts(const char *text);
int world_call_fputc(int c, FILE *file);
int world_call_putc(int c, FILE *file);
int world_call_putchar(int c);
int world_call_vfprintf(FILE *file, const char *format, va_list arguments);
__attribute__((format(printf, 2, 3))) int world_call_fprintf(FILE *file,
                                                             const char *format,
                                                             ...);
__attribute__((format(printf, 1, 2))) int world_call_printf(const char *format,
                                                            ...);
void world_call_perror(const char *text);

size_t world_call_fread(void *out, size_t size, size_t count, FILE *file);
char *world_call_fgets(char *out, int room, FILE *file);
int world_call_fgetc(FILE *file);
int world_call_getc(FILE *file);

#endif
