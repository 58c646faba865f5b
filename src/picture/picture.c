#include "lum/picture/picture.h"

#include "base/sized.h"
#include "cloud/writer_internal.h"
#include "picture_internal.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH  1600u
#define HEIGHT 1200u

/* Of a picture of that size, in pixels. */
#define MARGIN  20.0f
#define TITLE   88.0f /* what is above the scene */
#define LABELS  58.0f /* for elevations, left of the image of both eyes */
#define BETWEEN 52.0f /* from the scene to that, for a caption */
#define BELOW   48.0f /* for azimuths */
#define BAR     28.0f /* the colour scale */
#define NUMBER  96.0f /* its numbers */

/* Of texts, so that they can be read. */
#define SMALLEST 0.5f

/* What a picture is made of. */
typedef struct picture {
    int width;
    int height;
    lum_picture_colour colour;
    unsigned label; /* place of the labels among the caller's own columns */
    char title[160];
    char note[320];
    bool has_frame; /* these are known: */
    int64_t first;  /* frame */
    int64_t last;
    int64_t begin_ns; /* of the first, since 1970; 0: unknown */
    bool has_pose;
    lum_pose pose; /* of the sensor, in the frame of the points */
    lum_dots dots;
} picture;

/* --- The points --- */

static int refuse(const lum_writer *writer, const char *why, lum_error *error)
{
    errno = EINVAL;
    return lum_error_set(error, "%s: %s", lum_sink_name(writer->sink), why);
}

static bool is_side(uint32_t n)
{
    return n == 0 || (n >= LUM_PICTURE_SIDE_MIN && n <= LUM_PICTURE_SIDE_MAX);
}

/* The letters of a picture are those of ASCII. */
static void copy_text(char *out, size_t size, const char *text)
{
    (void)snprintf(out, size, "%s", text != NULL ? text : "");
    for (; *out != '\0'; out++) {
        *out = *out < ' ' || *out > '~' ? '?' : *out;
    }
}

static bool find_label(const lum_extras *extras, unsigned *out)
{
    for (*out = 0; *out < extras->count; (*out)++) {
        if (strcmp(extras->name[*out], "label") == 0) {
            return extras->type[*out] != LUM_NUMBER_U64 &&
                   extras->type[*out] != LUM_NUMBER_I64;
        }
    }
    return false;
}

static int take_options(const lum_writer *writer, picture *p, lum_error *error)
{
    lum_picture_options o = {.struct_size = sizeof o};
    const lum_picture_options *given = writer->options.drawing;
    if (given != NULL &&
        lum_sized_take(&o, sizeof o, given, "the options of a picture",
                       "lum_picture_options", error) != 0) {
        return -1;
    }
    if (!is_side(o.width) || !is_side(o.height)) {
        return refuse(writer, "a picture has 640 to 8000 pixels each way",
                      error);
    }
    if ((unsigned)o.colour > LUM_PICTURE_LABEL) {
        return refuse(writer, "no such colours", error);
    }
    if (o.colour == LUM_PICTURE_LABEL &&
        !find_label(&writer->extras, &p->label)) {
        return refuse(writer,
                      "colours of labels need a column label, of floats or of "
                      "integers of at most 32 bits",
                      error);
    }
    p->width = (int)(o.width != 0 ? o.width : WIDTH);
    p->height = (int)(o.height != 0 ? o.height : HEIGHT);
    p->colour = o.colour;
    copy_text(p->title, sizeof p->title, o.title);
    copy_text(p->note, sizeof p->note, o.note);
    p->has_pose = o.pose != NULL;
    p->pose = p->has_pose ? *o.pose : lum_pose_identity();
    return 0;
}

static int begin(lum_writer *writer, lum_error *error)
{
    picture *p = lum_writer_new_state(writer, sizeof *p, error);
    if (p == NULL) {
        return -1;
    }
    p->dots.step = 1;
    return take_options(writer, p, error);
}

static int begin_frame(lum_writer *writer, int64_t utc_ns, lum_error *error)
{
    picture *p = writer->state;
    (void)error;
    if (!p->has_frame) {
        p->begin_ns = utc_ns > 0 ? utc_ns : 0;
    }
    return 0;
}

/* The value as a number. */
static float label_of(const lum_writer *writer, const lum_line_samples *line,
                      size_t i)
{
    const picture *p = writer->state;
    char text[LUM_NUMBER_ROOM];
    *lum_number_print(text, (lum_number_type)writer->extras.type[p->label],
                      line->extra[p->label], i) = '\0';
    return strtof(text, NULL);
}

static float value_of(const lum_writer *writer, const lum_line_samples *line,
                      size_t i)
{
    const lum_sample *s = &line->samples[i];
    switch (((const picture *)writer->state)->colour) {
    case LUM_PICTURE_HEIGHT:
        return s->z;
    case LUM_PICTURE_PULSE_WIDTH:
        return s->pulse_width;
    case LUM_PICTURE_LABEL:
        return label_of(writer, line, i);
    case LUM_PICTURE_RANGE:
    default:
        return s->range;
    }
}

static int add(lum_writer *writer, const lum_line_samples *line,
               lum_error *error)
{
    picture *p = writer->state;
    p->first = p->has_frame ? p->first : line->frame;
    p->last = line->frame;
    p->has_frame = true;
    for (size_t i = 0; i < line->count; i++) {
        const lum_sample *s = &line->samples[i];
        const lum_dot dot = {s->x, s->y, s->z, s->range,
                             value_of(writer, line, i)};
        if (lum_dots_add(&p->dots, &dot) != 0) {
            errno = ENOMEM;
            return lum_error_set(error, "%s: no memory for the picture",
                                 lum_sink_name(writer->sink));
        }
    }
    return 0;
}

/* --- Texts --- */

/* A number with separated thousands. */
static void put_number(char *text, size_t size, uint64_t number)
{
    char digits[24];
    size_t n = 0;
    const int length = snprintf(digits, sizeof digits, "%" PRIu64, number);
    for (int i = 0; i < length && n + 2 < size; i++) {
        if (i > 0 && (length - i) % 3 == 0) {
            text[n++] = ',';
        }
        text[n++] = digits[i];
    }
    text[n] = '\0';
}

/* A time since 1970 as text; its date by Howard Hinnant's days from civil. */
static void put_time(char *text, size_t size, int64_t ns)
{
    const int64_t ms = ns / 1000000;
    const int64_t second = ms / 1000;
    const int64_t days = second / 86400 + 719468;
    const int64_t era = days / 146097;
    const int64_t day = days - era * 146097;
    const int64_t year = (day - day / 1460 + day / 36524 - day / 146096) / 365;
    const int64_t of_year = day - (365 * year + year / 4 - year / 100);
    const int64_t month = (5 * of_year + 2) / 153;
    const int rest = (int)(second - (days - 719468) * 86400);
    (void)snprintf(text, size, "%04d-%02d-%02d %02d:%02d:%02d.%03d UTC",
                   (int)(year + era * 400 + (month >= 10 ? 1 : 0)),
                   (int)(month < 10 ? month + 3 : month - 9),
                   (int)(of_year - (153 * month + 2) / 5 + 1), rest / 3600,
                   rest / 60 % 60, rest % 60, (int)(ms - second * 1000));
}

static void put_frames(char *text, size_t size, const picture *p)
{
    const char *comma = p->title[0] != '\0' ? ", " : "";
    if (!p->has_frame) {
        (void)snprintf(text, size, "%s%sno points", p->title, comma);
    } else if (p->first == p->last) {
        (void)snprintf(text, size, "%s%sframe %" PRId64, p->title, comma,
                       p->first);
    } else {
        (void)snprintf(text, size, "%s%sframes %" PRId64 " to %" PRId64,
                       p->title, comma, p->first, p->last);
    }
}

static void draw_titles(const lum_drawing *d, const picture *p)
{
    const int left = lum_pixels(d, MARGIN);
    const int right = p->width - left;
    char text[512];
    char number[40];
    put_frames(text, sizeof text, p);
    lum_write(d, 28.0f, LUM_ALIGN_LEFT, left, lum_pixels(d, 30.0f), 0.0f, text);
    if (p->has_frame && p->begin_ns != 0) {
        put_time(text, sizeof text, p->begin_ns);
        lum_write(d, 22.0f, LUM_ALIGN_RIGHT, right, lum_pixels(d, 30.0f), 0.0f,
                  text);
    }
    put_number(number, sizeof number, p->dots.all);
    (void)snprintf(text, sizeof text, "%s point%s%s%s", number,
                   p->dots.all == 1 ? "" : "s", p->note[0] != '\0' ? ", " : "",
                   p->note);
    lum_write(d, 18.0f, LUM_ALIGN_LEFT, left, lum_pixels(d, 64.0f), 0.0f, text);
}

/* Above a box: its title at the left, its units at the right. */
static void draw_caption(const lum_drawing *d, lum_box box, const char *name,
                         const char *units)
{
    const int y = box.y - lum_pixels(d, 16.0f);
    lum_write(d, 18.0f, LUM_ALIGN_LEFT, box.x, y, 0.0f, name);
    lum_write(d, 16.0f, LUM_ALIGN_RIGHT, box.x + box.width, y, 0.0f, units);
}

/* --- The parts --- */

/* At the lower end, as wide as there is room: a degree is as long as it is
 * high. */
static lum_box place_panorama(const lum_drawing *d, const picture *p,
                              const lum_image_view *v)
{
    const int left = lum_pixels(d, MARGIN + LABELS);
    const int room = p->width - left - lum_pixels(d, MARGIN);
    const float degrees = v->left_deg - v->right_deg;
    const float up = v->top_deg - v->bottom_deg;
    const float most = 0.5f * (float)p->height / up;
    const float scale = fminf((float)room / degrees, most);
    const int width = (int)(degrees * scale);
    const int height = (int)fmaxf(up * scale, 1.0f);
    return (lum_box){left + (room - width) / 2,
                     p->height - lum_pixels(d, BELOW) - height, width, height};
}

static lum_box place_ground(const lum_drawing *d, const picture *p,
                            lum_box panorama)
{
    const int x = lum_pixels(d, MARGIN);
    const int y = lum_pixels(d, TITLE + 24.0f);
    const int width =
        p->width - x - lum_pixels(d, 2.0f * MARGIN + BAR + NUMBER);
    return (lum_box){x, y, width, panorama.y - lum_pixels(d, BETWEEN) - y};
}

static lum_box place_bar(const lum_drawing *d, const picture *p, lum_box ground)
{
    const int edge = lum_pixels(d, 10.0f);
    return (lum_box){p->width - lum_pixels(d, MARGIN + BAR + NUMBER),
                     ground.y + edge, lum_pixels(d, BAR),
                     ground.height - 2 * edge};
}

/* As seen from the sensor; the points are where they were afterwards. */
static lum_box draw_panorama(const lum_drawing *d, picture *p)
{
    const lum_pose inverse = lum_pose_inverse(&p->pose);
    if (p->has_pose) {
        lum_dots_move(&p->dots, &inverse);
    }
    const lum_image_view view = lum_panorama_view(&p->dots);
    const lum_box box = place_panorama(d, p, &view);
    draw_caption(d, box, "As both eyes see it",
                 "azimuth and elevation in degrees");
    lum_draw_panorama(d, box, &view);
    if (p->has_pose) {
        lum_dots_move(&p->dots, &p->pose);
    }
    return box;
}

static void draw(lum_canvas *canvas, picture *p)
{
    static const char *const names[] = {[LUM_PICTURE_RANGE] = "Range",
                                        [LUM_PICTURE_HEIGHT] = "Height",
                                        [LUM_PICTURE_PULSE_WIDTH] =
                                            "Pulse width",
                                        [LUM_PICTURE_LABEL] = "Label"};
    const lum_drawing d = {canvas, &p->dots, lum_scale_of(p->colour, &p->dots),
                           fmaxf(fminf((float)p->width / (float)WIDTH,
                                       (float)p->height / (float)HEIGHT),
                                 SMALLEST)};
    lum_canvas_fill(canvas, (lum_box){0, 0, p->width, p->height}, lum_paper);
    const lum_box ground = place_ground(&d, p, draw_panorama(&d, p));
    const lum_box bar = place_bar(&d, p, ground);
    draw_titles(&d, p);
    draw_caption(&d, ground, "From above", "x up, y to the left");
    lum_draw_ground(&d, ground);
    draw_caption(&d, (lum_box){bar.x, ground.y, 0, 0}, names[p->colour], "");
    lum_draw_scale(&d, bar);
}

static int finish(lum_writer *writer, lum_error *error)
{
    picture *p = writer->state;
    lum_canvas *canvas = lum_canvas_new(p->width, p->height);
    if (canvas == NULL) {
        lum_error_set(error, "%s: no memory for the picture",
                      lum_sink_name(writer->sink));
        errno = ENOMEM;
        return -1;
    }
    draw(canvas, p);
    const int result = lum_canvas_write(canvas, writer->sink, error);
    const int code = errno;
    lum_canvas_free(canvas);
    errno = code;
    return result;
}

static void release(lum_writer *writer)
{
    picture *p = writer->state;
    lum_dots_free(&p->dots);
}

static const lum_format_ops png = {.name = "PNG",
                                   .ending = ".png",
                                   .begin = begin,
                                   .add = add,
                                   .begin_frame = begin_frame,
                                   .finish = finish,
                                   .release = release};

const lum_format_ops *lum_picture_format(void)
{
    return &png;
}
