/* load LIBRARY CAPTURE: the library is found at run time, as Python does it.
 * Prints its frames and points. */
#include <lum/frame/reader.h>

#include <stdio.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>

static void *open_library(const char *path)
{
    return (void *)LoadLibraryA(path);
}

static FARPROC find(void *library, const char *name)
{
    return GetProcAddress((HMODULE)library, name);
}
typedef FARPROC function;
#else
#include <dlfcn.h>

typedef void *function;

static void *open_library(const char *path)
{
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}

static function find(void *library, const char *name)
{
    return dlsym(library, name);
}
#endif

static struct {
    int (*open)(const lum_reader_options *, lum_reader **, lum_error *);
    int (*next)(lum_reader *, const lum_frame **, lum_error *);
    size_t (*count)(const lum_frame *);
    void (*close)(lum_reader *);
} lum;

/* A pointer to an object becomes one to a function, which C leaves to the
 * system. */
static int take(void *library, const char *name, void *into)
{
    const function found = find(library, name);
    memcpy(into, &found, sizeof found);
    if (!found) {
        fprintf(stderr, "the library has no %s\n", name);
    }
    return found != 0;
}

static int take_all(void *library)
{
    return take(library, "lum_reader_open", &lum.open) &&
           take(library, "lum_reader_next_frame", &lum.next) &&
           take(library, "lum_frame_count", &lum.count) &&
           take(library, "lum_reader_close", &lum.close);
}

static int read_capture(const char *path)
{
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .path = path};
    lum_error error = {{0}};
    lum_reader *reader = NULL;
    const lum_frame *frame = NULL;
    unsigned long frames = 0, points = 0;
    int status = lum.open(&options, &reader, &error);
    while (status >= 0 && (status = lum.next(reader, &frame, &error)) > 0) {
        frames++;
        points += (unsigned long)lum.count(frame);
    }
    lum.close(reader);
    if (status < 0) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    printf("%lu frames, %lu points\n", frames, points);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        fprintf(stderr, "usage: load LIBRARY CAPTURE\n");
        return 2;
    }
    void *const library = open_library(argv[1]);
    if (library == NULL) {
        fprintf(stderr, "%s cannot be loaded\n", argv[1]);
        return 1;
    }
    return take_all(library) ? read_capture(argv[2]) : 1;
}
