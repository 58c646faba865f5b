#include "watch.h"

lum_keeper_view watch_look(const lum_keeper *keeper)
{
    lum_keeper_view view = {.struct_size = sizeof view};
    (void)lum_keeper_look(keeper, &view);
    return view;
}

/* Before the first data the run says itself what is missing. */
static bool is_told(const lum_news *news, bool has_data)
{
    const lum_news_kind kind = news->kind;
    const bool is_missing =
        kind == LUM_NEWS_NO_ANSWER ||
        (kind >= LUM_NEWS_NO_ANSWER_YET && kind <= LUM_NEWS_UNKNOWN_LAYOUT);
    return lum_news_weigh(kind) != LUM_NEWS_INFO && (!is_missing || has_data);
}

void watch_tell(lum_keeper *keeper, struct say *say)
{
    lum_news news = {.struct_size = sizeof news};
    while (lum_keeper_next(keeper, &news)) {
        char text[LUM_ERROR_BYTES];
        if (is_told(&news, watch_look(keeper).has_data)) {
            say_warn(say, "%s%s", lum_news_tell(&news, text, sizeof text),
                     lum_news_is_dark(news.kind) ? "; the recording continues"
                                                 : "");
        }
    }
}

void watch_darkness(const lum_keeper *keeper, char *out, size_t room)
{
    lum_news news = {.struct_size = sizeof news};
    if (lum_keeper_darkness(keeper, &news)) {
        (void)lum_news_tell(&news, out, room);
    }
}
