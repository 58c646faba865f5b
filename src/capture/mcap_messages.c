#include "mcap_messages.h"

#include "mcap_records.h"
#include "pcap.h"

#include <stdlib.h>
#include <string.h>

/* A record beside chunks is as long as the source's window at most. */
#define MESSAGE_BYTES_MAX (((uint32_t)32 << 20) - 64u)

struct schema {
    unsigned id;
    char name[LUM_MCAP_NAME_MAX + 1u];
    char encoding[LUM_MCAP_NAME_MAX + 1u];
};

struct lum_mcap_messages {
    lum_pcap *place; /* the source, and where in it errors are */
    lum_mcap_records *records;
    struct schema schemas[LUM_MCAP_CHANNELS_KEPT_MAX];
    size_t schema_count;
    lum_mcap_messages_topic topics[LUM_MCAP_CHANNELS_KEPT_MAX];
    unsigned ids[LUM_MCAP_CHANNELS_KEPT_MAX];
    size_t topic_count;
};

/* --- Names --- */

static int too_long(const lum_mcap_messages *m, const char *what,
                    lum_error *error)
{
    return lum_pcap_fail(m->place, error,
                         "a %s has a name that is longer than %u bytes, or a "
                         "NUL in it",
                         what, LUM_MCAP_NAME_MAX);
}

static bool keep(char *out, lum_bytes_at name)
{
    if (name.len > LUM_MCAP_NAME_MAX ||
        (name.len != 0 && memchr(name.at, '\0', name.len) != NULL)) {
        return false;
    }
    if (name.len != 0) {
        memcpy(out, name.at, name.len);
    }
    out[name.len] = '\0';
    return true;
}

static int too_many(const lum_mcap_messages *m, const char *what,
                    lum_error *error)
{
    return lum_pcap_fail(m->place, error, "more than %u %s",
                         LUM_MCAP_CHANNELS_KEPT_MAX, what);
}

static int differs(const lum_mcap_messages *m, const char *what, unsigned id,
                   lum_error *error)
{
    return lum_pcap_fail(m->place, error,
                         "%s %u is described twice, differently", what, id);
}

/* --- Schemas --- */

static const struct schema *find_schema(const lum_mcap_messages *m, unsigned id)
{
    for (size_t i = 0; i < m->schema_count; i++) {
        if (m->schemas[i].id == id) {
            return &m->schemas[i];
        }
    }
    return NULL;
}

static int add_schema(lum_mcap_messages *m, const struct schema *schema,
                      lum_error *error)
{
    if (m->schema_count == LUM_MCAP_CHANNELS_KEPT_MAX) {
        return too_many(m, "schemas", error);
    }
    m->schemas[m->schema_count++] = *schema;
    return 0;
}

static int know_schema(lum_mcap_messages *m, const lum_mcap_record *record,
                       lum_error *error)
{
    struct schema schema = {.id = record->id};
    if (!keep(schema.name, record->name) ||
        !keep(schema.encoding, record->encoding)) {
        return too_long(m, "schema", error);
    }
    const struct schema *known = find_schema(m, record->id);
    if (known == NULL) {
        return add_schema(m, &schema, error);
    }
    return strcmp(known->name, schema.name) == 0 &&
                   strcmp(known->encoding, schema.encoding) == 0
               ? 0
               : differs(m, "schema", record->id, error);
}

/* --- Channels --- */

/* Its index; the number of topics: it is not known. */
static size_t find_topic(const lum_mcap_messages *m, unsigned id)
{
    size_t i = 0;
    while (i < m->topic_count && m->ids[i] != id) {
        i++;
    }
    return i;
}

static int make_topic(const lum_mcap_messages *m, const lum_mcap_record *record,
                      lum_mcap_messages_topic *out, lum_error *error)
{
    const struct schema *schema = find_schema(m, record->schema);
    *out = (lum_mcap_messages_topic){.name = ""};
    if (!keep(out->name, record->name) ||
        !keep(out->encoding, record->encoding)) {
        return too_long(m, "channel", error);
    }
    if (schema == NULL && record->schema != 0) {
        return lum_pcap_fail(m->place, error,
                             "channel %u has schema %u, which was not "
                             "described before",
                             record->id, record->schema);
    }
    if (schema != NULL) {
        memcpy(out->type, schema->name, sizeof out->type);
        memcpy(out->definition, schema->encoding, sizeof out->definition);
    }
    return 0;
}

static bool is_same(const lum_mcap_messages_topic *a,
                    const lum_mcap_messages_topic *b)
{
    return strcmp(a->name, b->name) == 0 && strcmp(a->type, b->type) == 0 &&
           strcmp(a->definition, b->definition) == 0 &&
           strcmp(a->encoding, b->encoding) == 0;
}

static int add_topic(lum_mcap_messages *m, unsigned id,
                     const lum_mcap_messages_topic *topic, lum_error *error)
{
    if (m->topic_count == LUM_MCAP_CHANNELS_KEPT_MAX) {
        return too_many(m, "channels", error);
    }
    m->ids[m->topic_count] = id;
    m->topics[m->topic_count++] = *topic;
    return 1;
}

/* 1: it is new; 0: it is known; -1. */
static int know_topic(lum_mcap_messages *m, const lum_mcap_record *record,
                      lum_error *error)
{
    lum_mcap_messages_topic topic;
    const size_t i = find_topic(m, record->id);
    if (make_topic(m, record, &topic, error) != 0) {
        return -1;
    }
    if (i == m->topic_count) {
        return add_topic(m, record->id, &topic, error);
    }
    return is_same(&topic, &m->topics[i])
               ? 0
               : differs(m, "channel", record->id, error);
}

/* --- What comes --- */

static lum_mcap_want wants(const void *context, unsigned channel)
{
    const lum_mcap_messages *m = context;
    return find_topic(m, channel) < m->topic_count ? LUM_MCAP_HAND_OUT
                                                   : LUM_MCAP_UNKNOWN;
}

static lum_mcap_event take_topic(lum_mcap_messages *m,
                                 const lum_mcap_record *record,
                                 lum_mcap_message *out, lum_error *error)
{
    const int is_new = know_topic(m, record, error);
    if (is_new < 0) {
        return LUM_MCAP_FAILED;
    }
    if (is_new == 0) {
        return LUM_MCAP_ENDED;
    }
    *out = (lum_mcap_message){.topic = &m->topics[m->topic_count - 1u],
                              .index = m->topic_count - 1u};
    return LUM_MCAP_HAS_TOPIC;
}

static lum_mcap_event take_message(const lum_mcap_messages *m,
                                   const lum_mcap_record *record,
                                   lum_mcap_message *out)
{
    const size_t i = find_topic(m, record->id);
    *out = (lum_mcap_message){.topic = &m->topics[i],
                              .index = i,
                              .log_ns = record->log_ns,
                              .bytes = record->rest.at,
                              .len = record->rest.len};
    return LUM_MCAP_HAS_MESSAGE;
}

/* LUM_MCAP_ENDED: it is nothing to be handed out. */
static lum_mcap_event take(lum_mcap_messages *m, const lum_mcap_record *record,
                           lum_mcap_message *out, lum_error *error)
{
    switch (record->kind) {
    case LUM_MCAP_IS_SCHEMA:
        return know_schema(m, record, error) == 0 ? LUM_MCAP_ENDED
                                                  : LUM_MCAP_FAILED;
    case LUM_MCAP_IS_CHANNEL:
        return take_topic(m, record, out, error);
    case LUM_MCAP_IS_METADATA:
        return LUM_MCAP_ENDED;
    case LUM_MCAP_IS_MESSAGE:
    default:
        return take_message(m, record, out);
    }
}

lum_mcap_event lum_mcap_messages_next(lum_mcap_messages *messages,
                                      lum_mcap_message *out, lum_error *error)
{
    lum_mcap_record record;
    lum_mcap_event event = LUM_MCAP_ENDED;
    while (event == LUM_MCAP_ENDED) {
        const int result =
            lum_mcap_records_next(messages->records, &record, error);
        if (result != 1) {
            return result == 0 ? LUM_MCAP_ENDED : LUM_MCAP_FAILED;
        }
        event = take(messages, &record, out, error);
    }
    return event;
}

uint64_t lum_mcap_messages_damaged(const lum_mcap_messages *messages,
                                   lum_error *error)
{
    const lum_pcap *place = messages->place;
    const char *first = "";
    const uint64_t n = lum_pcap_damaged(place, &first);
    if (n != 0) {
        lum_pcap_tell_damage(place->source->name, n, 0, first, error);
    }
    return n;
}

/* --- The start and the end --- */

static int begin(lum_mcap_messages *m, lum_source *source, lum_error *error)
{
    const lum_mcap_wanted wanted = {wants, m, MESSAGE_BYTES_MAX};
    if (!lum_mcap_is(source)) {
        return source->has_failed
                   ? lum_error_set(error, "%s", source->error.text)
                   : lum_error_set(error, "it is not an MCAP file");
    }
    m->place = lum_pcap_new(source);
    if (m->place != NULL) {
        m->records = lum_mcap_records_new(m->place, &wanted);
    }
    return m->records != NULL
               ? 0
               : lum_error_set(error, "not enough memory to read an MCAP file");
}

lum_mcap_messages *lum_mcap_messages_new(lum_source *source, lum_error *error)
{
    lum_mcap_messages *m = calloc(1, sizeof *m);
    if (m == NULL) {
        (void)lum_error_set(error, "not enough memory to read an MCAP file");
        return NULL;
    }
    if (begin(m, source, error) != 0) {
        lum_mcap_messages_free(m);
        return NULL;
    }
    return m;
}

void lum_mcap_messages_free(lum_mcap_messages *messages)
{
    if (messages == NULL) {
        return;
    }
    lum_mcap_records_free(messages->records);
    lum_pcap_free(messages->place);
    free(messages);
}
