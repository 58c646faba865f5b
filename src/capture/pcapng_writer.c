#include "pcapng_writer.h"

#include "link.h"
#include "pcapng_sections.h"

#include <string.h>

enum {
    SECTION_BYTES = 24, /* before the options */
    INTERFACE_BYTES = 16,
    OPTION_BYTES = 4, /* before the value */
    /* of the options and the block */
    END_BYTES = OPTION_BYTES + LUM_PCAPNG_TRAILER_BYTES,
    BYTE_ORDER = 0x1a2b3c4d,
    VERSION = 1,
    OPTION_APPLICATION = 4,
    OPTION_NAME = 2,
    OPTION_RESOLUTION = 9,
    NANOSECONDS = 9 /* 10^-9 */
};

static size_t option_bytes(const char *text)
{
    return OPTION_BYTES + lum_pcapng_padded(strlen(text));
}

static size_t section_bytes(const lum_capture_writer_options *o)
{
    size_t n = SECTION_BYTES + END_BYTES;
    n += o->application != NULL ? option_bytes(o->application) : 0u;
    for (size_t i = 0; i < o->comment_count; i++) {
        n += option_bytes(o->comments[i]);
    }
    return n;
}

/* An interface without a name has an empty one here. */
static size_t interface_bytes(const char *name)
{
    const size_t named = *name != '\0' ? option_bytes(name) : 0u;
    return INTERFACE_BYTES + named + OPTION_BYTES + 4u + END_BYTES;
}

static size_t interface_count(const lum_capture_writer_options *o)
{
    return o->interface_count > 0 ? o->interface_count : 1u;
}

static const char *interface_name(const lum_capture_writer_options *o, size_t i)
{
    return o->interface_count > 0 ? o->interfaces[i] : "";
}

static bool has_good_interfaces(const lum_capture_writer_options *o)
{
    if (o->interface_count > LUM_CAPTURE_INTERFACES_MAX) {
        return false;
    }
    for (size_t i = 0; i < o->interface_count; i++) {
        if (strlen(o->interfaces[i]) >= LUM_INTERFACE_BYTES) {
            return false;
        }
    }
    return true;
}

size_t lum_pcapng_start_bytes(const lum_capture_writer_options *options)
{
    const lum_capture_writer_options *o = options;
    if (o->comment_count > LUM_CAPTURE_COMMENTS_MAX ||
        (o->application != NULL &&
         strlen(o->application) > LUM_CAPTURE_COMMENT_BYTES_MAX) ||
        !has_good_interfaces(o)) {
        return 0;
    }
    for (size_t i = 0; i < o->comment_count; i++) {
        if (strlen(o->comments[i]) > LUM_CAPTURE_COMMENT_BYTES_MAX) {
            return 0;
        }
    }
    size_t n = section_bytes(o);
    for (size_t i = 0; i < interface_count(o); i++) {
        n += interface_bytes(interface_name(o, i));
    }
    return n;
}

static uint8_t *put_option(uint8_t *p, unsigned code, const void *value,
                           size_t len)
{
    store_le16(p, code);
    store_le16(p + 2, (uint32_t)len);
    memset(p + OPTION_BYTES, 0, lum_pcapng_padded(len));
    memcpy(p + OPTION_BYTES, value, len);
    return p + OPTION_BYTES + lum_pcapng_padded(len);
}

static uint8_t *put_end(uint8_t *p, size_t len)
{
    memset(p, 0, OPTION_BYTES);
    store_le32(p + OPTION_BYTES, (uint32_t)len);
    return p + END_BYTES;
}

static uint8_t *put_section(uint8_t *p, const lum_capture_writer_options *o)
{
    const size_t len = section_bytes(o);
    store_le32(p, LUM_PCAPNG_SECTION);
    store_le32(p + 4, (uint32_t)len);
    store_le32(p + 8, BYTE_ORDER);
    store_le16(p + 12, VERSION);
    store_le16(p + 14, 0);
    memset(p + 16, 0xff, 8); /* its length is not known */
    p += SECTION_BYTES;
    if (o->application != NULL) {
        p = put_option(p, OPTION_APPLICATION, o->application,
                       strlen(o->application));
    }
    for (size_t i = 0; i < o->comment_count; i++) {
        p = put_option(p, LUM_PCAP_COMMENT, o->comments[i],
                       strlen(o->comments[i]));
    }
    return put_end(p, len);
}

static uint8_t *put_interface(uint8_t *p, const char *name, uint32_t snap)
{
    const uint8_t resolution = NANOSECONDS;
    store_le32(p, LUM_PCAPNG_INTERFACE);
    store_le32(p + 4, (uint32_t)interface_bytes(name));
    store_le16(p + 8, LINKTYPE_ETHERNET);
    store_le16(p + 10, 0);
    store_le32(p + 12, snap);
    p += INTERFACE_BYTES;
    if (*name != '\0') {
        p = put_option(p, OPTION_NAME, name, strlen(name));
    }
    p = put_option(p, OPTION_RESOLUTION, &resolution, 1);
    return put_end(p, interface_bytes(name));
}

void lum_pcapng_put_start(uint8_t *out,
                          const lum_capture_writer_options *options,
                          uint32_t snap)
{
    uint8_t *p = put_section(out, options);
    for (size_t i = 0; i < interface_count(options); i++) {
        p = put_interface(p, interface_name(options, i), snap);
    }
}

size_t lum_pcapng_put_around(uint8_t *block, uint32_t interface,
                             int64_t time_ns, uint32_t len)
{
    const uint64_t time = (uint64_t)time_ns;
    const size_t tail = LUM_PCAPNG_HEAD_BYTES + lum_pcapng_padded(len);
    const size_t all = tail + LUM_PCAPNG_TRAILER_BYTES;
    store_le32(block, LUM_PCAPNG_ENHANCED_PACKET);
    store_le32(block + 4, (uint32_t)all);
    store_le32(block + 8, interface);
    store_le32(block + 12, (uint32_t)(time >> 32));
    store_le32(block + 16, (uint32_t)(time & UINT32_MAX));
    store_le32(block + 20, len);
    store_le32(block + 24, len);
    memset(block + LUM_PCAPNG_HEAD_BYTES + len, 0,
           lum_pcapng_padded(len) - len);
    store_le32(block + tail, (uint32_t)all);
    return all;
}
