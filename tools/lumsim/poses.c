#include "poses.h"

#include "cloud/sink.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#define LINE_BYTES 512
#define SECOND_NS  INT64_C(1000000000)

struct poses {
    lum_sink *sink;
};

int poses_open(const char *path, struct poses **out, lum_error *error)
{
    static const char head[] =
        "# Where the sensor is in the frame of the scene when each line "
        "begins, and at the end.\n# seconds x y z qx qy qz qw\n";
    struct poses *p = calloc(1, sizeof *p);
    if (p == NULL) {
        return lum_error_set(error, "%s: not enough memory", path);
    }
    if (lum_sink_open(path, &p->sink, error) != 0 ||
        lum_sink_write(p->sink, head, sizeof head - 1, error) != 0) {
        poses_abort(p);
        return -1;
    }
    *out = p;
    return 0;
}

int poses_add(struct poses *poses, int64_t time_ns, const lum_pose *pose,
              lum_error *error)
{
    char text[LINE_BYTES];
    const double *at = pose->at;
    const double *turn = pose->turn;
    const int n = snprintf(text, sizeof text,
                           "%" PRId64 ".%09" PRId64
                           " %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n",
                           time_ns / SECOND_NS, time_ns % SECOND_NS, at[0],
                           at[1], at[2], turn[0], turn[1], turn[2], turn[3]);
    return lum_sink_write(poses->sink, text, (size_t)n, error);
}

int poses_close(struct poses *poses, lum_error *error)
{
    const int result = lum_sink_close(poses->sink, error);
    free(poses);
    return result;
}

void poses_abort(struct poses *poses)
{
    if (poses != NULL) {
        lum_sink_abort(poses->sink);
        free(poses);
    }
}
