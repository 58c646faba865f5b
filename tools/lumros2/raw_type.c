#include "raw_type.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_keyhash.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Samples are a whole number of words on the wire. */
#define WORD 4u

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

struct ddsi_sertype *raw_type_new(const char *name)
{
    struct ddsi_sertype *type = calloc(1, sizeof *type);
    if (type != NULL) {
        ddsi_sertype_init(type, name, &type_ops, &sample_ops, true);
        type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
    }
    return type;
}

struct ddsi_serdata *raw_type_sample(const struct ddsi_sertype *type,
                                     const uint8_t *cdr, size_t len)
{
    struct sample *s = new_sample(type, SDK_DATA, len);
    if (s == NULL) {
        return NULL;
    }
    (void)memcpy(s->bytes, cdr, len);
    return &s->base;
}
