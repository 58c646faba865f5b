#include "bus.h"

#include "topics.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_keyhash.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CDR_HEAD 4u

/* Datagrams as large as IPv4 has them: small ones take several times as long.
 * What is sent again is a fragment. By key hashes Fast DDS knows at once that a
 * writer has left. A writer never waits for readers that are slow: the depth of
 * a topic bounds what is kept. */
#define SETTINGS                                                               \
    "<CycloneDDS><Domain Id=\"any\">"                                          \
    "<General><MaxMessageSize>65500B</MaxMessageSize>"                         \
    "<FragmentSize>32000B</FragmentSize></General>"                            \
    "<Internal><SocketReceiveBufferSize max=\"10MB\"/>"                        \
    "<SocketSendBufferSize max=\"2MB\"/>"                                      \
    "<GenerateKeyhash>true</GenerateKeyhash>"                                  \
    "<Watermarks><WhcHigh>2000MB</WhcHigh>"                                    \
    "<WhcHighInit>2000MB</WhcHighInit>"                                        \
    "<WhcAdaptive>false</WhcAdaptive></Watermarks></Internal>"                 \
    "</Domain></CycloneDDS>"

struct topic {
    char name[NAMES_BYTES];
    char type[NAMES_BYTES];
    enum qos_kind kind;
    uint32_t depth;
    dds_entity_t writer;
    const struct ddsi_sertype *raw;
    uint32_t pending; /* messages that some reader may not have yet */
    unsigned readers;
    struct bus_count count;
};

struct bus {
    dds_entity_t domain; /* 0: its settings are not ours */
    dds_entity_t participant;
    size_t topic_count;
    struct topic *topics[BUS_TOPICS_MAX];
};

static int fail(lum_error *error, const char *what, dds_return_t code)
{
    return lum_error_set(error, "%s: %s", what, dds_strretcode(code));
}

/* Samples are a whole number of words on the wire. */
#define WORD 4u

/* Of a type whose samples are bytes in CDR that are sent as they are: no
 * message is decoded. */
struct sample {
    struct ddsi_serdata base;
    uint32_t len;
    uint8_t *bytes; /* padded to words; NULL: of no sample */
};

/* --- Samples --- */

static struct sample *new_sample(const struct ddsi_sertype *type,
                                 enum ddsi_serdata_kind kind, size_t len)
{
    const size_t padded = (len + WORD - 1u) / WORD * WORD;
    struct sample *s = calloc(1, sizeof *s);
    uint8_t *bytes = malloc(padded + WORD);
    if (s == NULL || bytes == NULL || len > UINT32_MAX - WORD) {
        free(s);
        free(bytes);
        return NULL;
    }
    ddsi_serdata_init(&s->base, type, kind);
    s->base.hash = type->serdata_basehash;
    s->len = (uint32_t)len;
    s->bytes = bytes;
    (void)memset(bytes + len, 0, padded + WORD - len);
    return s;
}

static const struct sample *sample_of(const struct ddsi_serdata *d)
{
    return (const struct sample *)d;
}

/* Without a key all are one instance. */
static bool have_equal_keys(const struct ddsi_serdata *a,
                            const struct ddsi_serdata *b)
{
    (void)a;
    (void)b;
    return true;
}

static uint32_t size_of(const struct ddsi_serdata *d)
{
    return sample_of(d)->len;
}

/* Nothing is received. */
static struct ddsi_serdata *from_fragments(const struct ddsi_sertype *type,
                                           enum ddsi_serdata_kind kind,
                                           const struct nn_rdata *fragments,
                                           size_t size)
{
    (void)type;
    (void)kind;
    (void)fragments;
    (void)size;
    return NULL;
}

static struct ddsi_serdata *from_parts(const struct ddsi_sertype *type,
                                       enum ddsi_serdata_kind kind,
                                       ddsrt_msg_iovlen_t count,
                                       const ddsrt_iovec_t *parts, size_t size)
{
    struct sample *s = new_sample(type, kind, size);
    size_t at = 0;
    for (ddsrt_msg_iovlen_t i = 0; s != NULL && i < count && at < size; i++) {
        const size_t left = size - at;
        const size_t n = parts[i].iov_len < left ? parts[i].iov_len : left;
        (void)memcpy(s->bytes + at, parts[i].iov_base, n);
        at += n;
    }
    return s != NULL ? &s->base : NULL;
}

static struct ddsi_serdata *from_key_hash(const struct ddsi_sertype *type,
                                          const struct ddsi_keyhash *hash)
{
    (void)hash;
    struct sample *s = new_sample(type, SDK_KEY, 0);
    return s != NULL ? &s->base : NULL;
}

static struct ddsi_serdata *from_sample(const struct ddsi_sertype *type,
                                        enum ddsi_serdata_kind kind,
                                        const void *sample)
{
    (void)sample;
    struct sample *s = kind == SDK_KEY ? new_sample(type, kind, 0) : NULL;
    return s != NULL ? &s->base : NULL;
}

static void to_bytes(const struct ddsi_serdata *d, size_t at, size_t size,
                     void *out)
{
    (void)memcpy(out, sample_of(d)->bytes + at, size);
}

static struct ddsi_serdata *to_bytes_in_place(const struct ddsi_serdata *d,
                                              size_t at, size_t size,
                                              ddsrt_iovec_t *out)
{
    out->iov_base = sample_of(d)->bytes + at;
    out->iov_len = (ddsrt_iov_len_t)size;
    return ddsi_serdata_ref(d);
}

static void end_bytes_in_place(struct ddsi_serdata *d, const ddsrt_iovec_t *ref)
{
    (void)ref;
    ddsi_serdata_unref(d);
}

static bool to_sample(const struct ddsi_serdata *d, void *sample, void **at,
                      void *end)
{
    (void)d;
    (void)sample;
    (void)at;
    (void)end;
    return false;
}

/* The instance, of which there is one. */
static struct ddsi_serdata *to_instance(const struct ddsi_serdata *d)
{
    struct sample *s = new_sample(d->type, SDK_KEY, 0);
    if (s == NULL) {
        return NULL;
    }
    s->base.type = NULL;
    return &s->base;
}

static bool instance_to_sample(const struct ddsi_sertype *type,
                               const struct ddsi_serdata *d, void *sample,
                               void **at, void *end)
{
    (void)type;
    return to_sample(d, sample, at, end);
}

static void free_sample(struct ddsi_serdata *d)
{
    struct sample *s = (struct sample *)d;
    free(s->bytes);
    free(s);
}

static size_t print_sample(const struct ddsi_sertype *type,
                           const struct ddsi_serdata *d, char *out, size_t size)
{
    (void)type;
    const int n = snprintf(out, size, "%lu bytes", (unsigned long)size_of(d));
    return n > 0 ? (size_t)n : 0u;
}

static void get_key_hash(const struct ddsi_serdata *d, struct ddsi_keyhash *out,
                         bool is_forced)
{
    (void)d;
    (void)is_forced;
    (void)memset(out, 0, sizeof *out);
}

static const struct ddsi_serdata_ops sample_ops = {
    .eqkey = have_equal_keys,
    .get_size = size_of,
    .from_ser = from_fragments,
    .from_ser_iov = from_parts,
    .from_keyhash = from_key_hash,
    .from_sample = from_sample,
    .to_ser = to_bytes,
    .to_ser_ref = to_bytes_in_place,
    .to_ser_unref = end_bytes_in_place,
    .to_sample = to_sample,
    .to_untyped = to_instance,
    .untyped_to_sample = instance_to_sample,
    .free = free_sample,
    .print = print_sample,
    .get_keyhash = get_key_hash};

/* --- The type --- */

static void free_type(struct ddsi_sertype *type)
{
    ddsi_sertype_fini(type);
    free(type);
}

/* Its name, which is compared before, is all that there is. */
static bool are_equal(const struct ddsi_sertype *a,
                      const struct ddsi_sertype *b)
{
    (void)a;
    (void)b;
    return true;
}

static uint32_t hash_of(const struct ddsi_sertype *type)
{
    (void)type;
    return 0;
}

static void zero_samples(const struct ddsi_sertype *type, void *samples,
                         size_t count)
{
    (void)type;
    (void)samples;
    (void)count;
}

static void grow_samples(void **out, const struct ddsi_sertype *type, void *old,
                         size_t old_count, size_t count)
{
    (void)type;
    (void)old;
    (void)old_count;
    for (size_t i = 0; i < count; i++) {
        out[i] = NULL;
    }
}

static void free_samples(const struct ddsi_sertype *type, void **samples,
                         size_t count, dds_free_op_t operation)
{
    (void)type;
    (void)samples;
    (void)count;
    (void)operation;
}

static const struct ddsi_sertype_ops type_ops = {.version = ddsi_sertype_v0,
                                                 .free = free_type,
                                                 .zero_samples = zero_samples,
                                                 .realloc_samples =
                                                     grow_samples,
                                                 .free_samples = free_samples,
                                                 .equal = are_equal,
                                                 .hash = hash_of};

/* For dds_create_topic_sertype(), which takes it over. It has no key, and tells
 * no type information to other participants. NULL without memory. */
static struct ddsi_sertype *raw_type_new(const char *name)
{
    struct ddsi_sertype *type = calloc(1, sizeof *type);
    if (type != NULL) {
        ddsi_sertype_init(type, name, &type_ops, &sample_ops, true);
        type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
    }
    return type;
}

/* For dds_writecdr(), which takes it over. cdr: four bytes that say which CDR
 * it is, and the message; copied. NULL without memory. */
static struct ddsi_serdata *raw_type_sample(const struct ddsi_sertype *type,
                                            const uint8_t *cdr, size_t len)
{
    struct sample *s = new_sample(type, SDK_DATA, len);
    if (s == NULL) {
        return NULL;
    }
    (void)memcpy(s->bytes, cdr, len);
    return &s->base;
}

/* --- The domain --- */

static int join(struct bus *bus, unsigned domain, lum_error *error)
{
    static const char enclave[] = "enclave=/;";
    const char *uri = getenv("CYCLONEDDS_URI");
    if (uri == NULL || uri[0] == '\0') {
        bus->domain = dds_create_domain(domain, SETTINGS);
        if (bus->domain < 0) {
            return fail(error, "DDS cannot be started", bus->domain);
        }
    }
    dds_qos_t *qos = dds_create_qos();
    dds_qset_userdata(qos, enclave, sizeof enclave - 1u);
    bus->participant = dds_create_participant(domain, qos, NULL);
    dds_delete_qos(qos);
    return bus->participant >= 0
               ? 0
               : fail(error, "no domain can be joined", bus->participant);
}

int bus_open(unsigned domain, struct bus **out, lum_error *error)
{
    struct bus *bus = calloc(1, sizeof *bus);
    if (bus == NULL) {
        return lum_error_set(error, "out of memory");
    }
    if (join(bus, domain, error) != 0) {
        bus_close(bus);
        return -1;
    }
    *out = bus;
    return 0;
}

void bus_close(struct bus *bus)
{
    if (bus == NULL) {
        return;
    }
    if (bus->participant > 0) {
        (void)dds_delete(bus->participant);
    }
    if (bus->domain > 0) {
        (void)dds_delete(bus->domain);
    }
    for (size_t i = 0; i < bus->topic_count; i++) {
        free(bus->topics[i]);
    }
    free(bus);
}

/* --- Topics --- */

static dds_qos_t *make_qos(const struct topic *t)
{
    const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
    const bool is_latched = t->kind == QOS_LATCHED;
    dds_qos_t *qos = dds_create_qos();
    dds_qset_reliability(qos,
                         t->kind == QOS_SENSOR ? DDS_RELIABILITY_BEST_EFFORT
                                               : DDS_RELIABILITY_RELIABLE,
                         0);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, (int32_t)t->depth);
    dds_qset_durability(qos, is_latched ? DDS_DURABILITY_TRANSIENT_LOCAL
                                        : DDS_DURABILITY_VOLATILE);
    dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST,
                                (int32_t)t->depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
    dds_qset_data_representation(qos, 1, &xcdr1);
    return qos;
}

/* What ROS 2 from Iron on compares of a type beside its name (REP 2016):
 * SHA-256 of its description with all types in it, as JSON; of the messages
 * that lumdump writes. For others none is told. */
static const struct {
    const char *type;
    const char *hash;
} hashes[] = {
    {"sensor_msgs/msg/PointCloud2",
     "RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5"},
    {"tf2_msgs/msg/TFMessage",
     "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"},
    {"diagnostic_msgs/msg/DiagnosticArray",
     "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"},
};

static void tell_hash(dds_qos_t *qos, const char *type)
{
    char text[96];
    for (size_t i = 0; i < sizeof hashes / sizeof hashes[0]; i++) {
        if (strcmp(type, hashes[i].type) == 0) {
            const int n =
                snprintf(text, sizeof text, "typehash=%s;", hashes[i].hash);
            dds_qset_userdata(qos, text, (size_t)n);
        }
    }
}

static int make_writer(const struct bus *bus, struct topic *t, lum_error *error)
{
    char name[NAMES_BYTES];
    char type[NAMES_BYTES];
    if (!names_dds_type(t->type, type)) {
        return lum_error_set(error, "%s is not a ROS 2 type", t->type);
    }
    names_dds_topic(t->name, name);
    struct ddsi_sertype *raw = raw_type_new(type);
    if (raw == NULL) {
        return lum_error_set(error, "out of memory");
    }
    dds_qos_t *qos = make_qos(t);
    const dds_entity_t topic =
        dds_create_topic_sertype(bus->participant, name, &raw, qos, NULL, NULL);
    tell_hash(qos, t->type);
    t->raw = raw;
    t->writer = topic < 0
                    ? topic
                    : dds_create_writer(bus->participant, topic, qos, NULL);
    dds_delete_qos(qos);
    return t->writer >= 0 ? 0 : fail(error, t->name, t->writer);
}

static int add(struct bus *bus, const struct bus_topic *topic, lum_error *error)
{
    if (bus->topic_count == BUS_TOPICS_MAX) {
        return lum_error_set(error, "more than %u topics", BUS_TOPICS_MAX);
    }
    struct topic *t = calloc(1, sizeof *t);
    if (t == NULL) {
        return lum_error_set(error, "out of memory");
    }
    (void)snprintf(t->name, sizeof t->name, "%s", topic->name);
    (void)snprintf(t->type, sizeof t->type, "%s", topic->type);
    t->kind = topic->kind;
    t->depth = topic->depth;
    t->count.name = t->name;
    if (make_writer(bus, t, error) != 0) {
        free(t);
        return -1;
    }
    bus->topics[bus->topic_count++] = t;
    return 0;
}

int bus_add(struct bus *bus, const struct bus_topic *topic, size_t *index,
            lum_error *error)
{
    for (size_t i = 0; i < bus->topic_count; i++) {
        if (strcmp(bus->topics[i]->name, topic->name) == 0) {
            *index = i;
            return strcmp(bus->topics[i]->type, topic->type) == 0
                       ? 0
                       : lum_error_set(error, "%s: %.120s, but before %.120s",
                                       topic->name, topic->type,
                                       bus->topics[i]->type);
        }
    }
    *index = bus->topic_count;
    return add(bus, topic, error);
}

/* --- Messages --- */

/* In CDR as ROS 2 has it, of either byte order. */
static bool is_cdr(const uint8_t *cdr, size_t len)
{
    return len >= CDR_HEAD && cdr[0] == 0 && cdr[1] <= 1;
}

/* A reader that has not told to have all of them loses the oldest. */
static void count_pending(struct topic *t)
{
    if (t->kind == QOS_SENSOR || dds_wait_for_acks(t->writer, 0) == 0) {
        t->pending = 0;
    }
    if (t->pending == t->depth) {
        t->count.dropped++;
    } else {
        t->pending++;
    }
}

int bus_publish(struct bus *bus, size_t index, const uint8_t *cdr, size_t len,
                lum_error *error)
{
    struct topic *t = bus->topics[index];
    if (!is_cdr(cdr, len)) {
        return lum_error_set(error, "a message of %s is not in CDR", t->name);
    }
    struct ddsi_serdata *sample = raw_type_sample(t->raw, cdr, len);
    if (sample == NULL) {
        return lum_error_set(error,
                             "not enough memory for a message of %zu "
                             "bytes",
                             len);
    }
    count_pending(t);
    const dds_return_t result = dds_writecdr(t->writer, sample);
    if (result == DDS_RETCODE_TIMEOUT) {
        t->count.dropped++;
        return 0;
    }
    t->count.messages++;
    t->count.bytes += len;
    return result == 0 ? 0 : fail(error, t->name, result);
}

bool bus_wait(struct bus *bus, int ms)
{
    const dds_time_t end = dds_time() + DDS_MSECS(ms);
    for (size_t i = 0; i < bus->topic_count; i++) {
        const struct topic *t = bus->topics[i];
        const dds_time_t left = end - dds_time();
        if (t->kind != QOS_SENSOR &&
            dds_wait_for_acks(t->writer, left > 0 ? left : 0) != 0) {
            return false;
        }
    }
    return true;
}

/* --- Looking --- */

static unsigned look(struct topic *t)
{
    dds_publication_matched_status_t status = {.current_count = 0};
    return dds_get_publication_matched_status(t->writer, &status) == 0
               ? status.current_count
               : 0u;
}

unsigned bus_readers(struct bus *bus)
{
    unsigned sum = 0;
    for (size_t i = 0; i < bus->topic_count; i++) {
        sum += look(bus->topics[i]);
    }
    return sum;
}

size_t bus_topics(const struct bus *bus)
{
    return bus->topic_count;
}

struct bus_count bus_count(struct bus *bus, size_t index)
{
    struct topic *t = bus->topics[index];
    struct bus_count count = t->count;
    count.readers = look(t);
    count.has_new_count = count.readers != t->readers;
    t->readers = count.readers;
    return count;
}
