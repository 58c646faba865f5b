/* Prints what the dissector takes from the C code, as a Lua table. */
#include "lum/calibration.h"
#include "lum/command.h"
#include "lum/group.h"
#include "lum/host/laser_name.h"
#include "lum/laser.h"
#include "lum/packet.h"
#include "lum/profile.h"
#include "lum/wire.h"

#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

struct number {
    const char *name;
    int64_t value;
};

static const char *const commands[LUM_COMMANDS] = {
    [LUM_COMMAND_LASER_ON] = "laser on",
    [LUM_COMMAND_LASER_OFF] = "laser off",
    [LUM_COMMAND_POWER] = "power",
    [LUM_COMMAND_THRESHOLD_GREEN] = "threshold green",
    [LUM_COMMAND_THRESHOLD_BLUE] = "threshold blue",
    [LUM_COMMAND_LINE_MODE] = "line mode",
    [LUM_COMMAND_YSCAN] = "Y scan",
    [LUM_COMMAND_HOLDOFF] = "holdoff",
    [LUM_COMMAND_OFFSET_GREEN] = "offset green",
    [LUM_COMMAND_OFFSET_BLUE] = "offset blue",
};

static const char *const fields[LUM_GROUP_FIELDS] = {
    [LUM_FIELD_TAG] = "tag",
    [LUM_FIELD_EYE] = "eye",
    [LUM_FIELD_LINE] = "line",
    [LUM_FIELD_NUM_SAMPLES] = "num_samples",
    [LUM_FIELD_FIRST_SAMPLE_INDEX] = "first_sample_index",
    [LUM_FIELD_TIMESTAMP] = "timestamp",
};

static const char *const tlvs[LUM_TLV_USES] = {
    [LUM_TLV_COMMAND] = "command",
    [LUM_TLV_STATUS] = "status",
    [LUM_TLV_DEBUG] = "debug",
    [LUM_TLV_YSCAN] = "yscan",
};

static const char *const eyes[LUM_EYES] = {
    [LUM_EYE_BLUE] = "blue",
    [LUM_EYE_GREEN] = "green",
};

/* A name of a table. What the table lacks ends the build. */
static const char *name_of(const char *const names[], unsigned i)
{
    if (names[i] == NULL) {
        (void)fprintf(stderr, "tables.c: a table has no name for %u\n", i);
        exit(EXIT_FAILURE);
    }
    return names[i];
}

static void print_numbers(const char *indent, const struct number *rows,
                          size_t n)
{
    for (size_t i = 0; i < n; i++) {
        printf("%s%s = %" PRId64 ",\n", indent, rows[i].name, rows[i].value);
    }
}

#define PRINT_NUMBERS(indent, rows)                                            \
    print_numbers(indent, rows, sizeof(rows) / sizeof(rows)[0])

/* What precedes the type's byte is the magic, what follows it is reserved. */
static void print_header(void)
{
    uint8_t zero[LUM_HEADER_BYTES];
    uint8_t ones[LUM_HEADER_BYTES];
    unsigned at = 0;
    lum_header_encode(zero, 0);
    lum_header_encode(ones, 0xff);
    while (at + 1 < LUM_HEADER_BYTES && zero[at] == ones[at]) {
        at++;
    }
    printf("    magic = \"");
    for (unsigned i = 0; i < at; i++) {
        printf("%02x", (unsigned)zero[i]);
    }
    printf("\",\n    type_at = %u,\n", at);
}

static void print_wire(void)
{
    const struct number rows[] = {
        {"port", LUM_PORT},
        {"header_bytes", LUM_HEADER_BYTES},
        {"tlv_head_bytes", LUM_TLV_HEAD_BYTES},
        {"sample_bytes", LUM_SAMPLE_BYTES},
        {"line_pixels", LUM_LINE_PIXELS},
    };
    const struct number types[] = {
        {"set_ip", LUM_TYPE_SET_IP},
        {"timestamp", LUM_TYPE_TIMESTAMP},
        {"tlv", LUM_TYPE_TLV},
        {"heartbeat", LUM_TYPE_HEARTBEAT},
    };
    const struct number bytes[] = {
        {"set_ip", LUM_SET_IP_BYTES},
        {"timestamp", LUM_TIMESTAMP_BYTES},
        {"tlv", LUM_TLV_PACKET_BYTES},
        {"heartbeat", LUM_HEARTBEAT_BYTES},
    };
    const struct number tags[] = {
        {"angles", LUM_TAG_ANGLES},
        {"ranges", LUM_TAG_RANGES},
    };
    const struct number word[] = {
        {"pixel", LUM_WORD_PIXEL},
        {"rising", LUM_WORD_RISING},
        {"zero", LUM_WORD_ZERO},
        {"tof_max", LUM_TOF_MAX},
    };
    PRINT_NUMBERS("    ", rows);
    printf("    types = {\n");
    PRINT_NUMBERS("        ", types);
    printf("    },\n    bytes = {\n");
    PRINT_NUMBERS("        ", bytes);
    printf("    },\n    tags = {\n");
    PRINT_NUMBERS("        ", tags);
    printf("    },\n    word = {\n");
    PRINT_NUMBERS("        ", word);
    printf("    },\n");
}

static void print_commands(void)
{
    printf("    commands = {\n");
    for (unsigned i = 0; i < LUM_COMMANDS; i++) {
        const lum_command_spec *c = &lum_command_specs[i];
        printf("        {name = \"%s\", letter = \"%c\", has_value = %s, "
               "min = %u, max = %u, step = %u},\n",
               name_of(commands, i), c->letter, c->has_value ? "true" : "false",
               (unsigned)c->min, (unsigned)c->max, (unsigned)c->step);
    }
    printf("    },\n");
}

static void print_laser(void)
{
    const struct number masks[] = {
        {"hazards", LUM_LASER_HAZARDS},
        {"all_down", LUM_LASER_ALL_DOWN},
        {"on", LUM_LASER_TLV_CMD_ON},
    };
    printf("    laser = {\n");
    PRINT_NUMBERS("        ", masks);
    printf("        bits = {\n");
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        printf("            {mask = 0x%04x, name = \"%s\"},\n", 1u << bit,
               lum_laser_bit_name(bit));
    }
    printf("        },\n    },\n");
}

static void print_named(const char *table, const char *const names[],
                        const uint32_t *values, unsigned n)
{
    printf("        %s = {", table);
    for (unsigned i = 0; i < n; i++) {
        printf("%s%s = %" PRIu32, i > 0 ? ", " : "", name_of(names, i),
               values[i]);
    }
    printf("},\n");
}

static const char *order_of(uint8_t byte_order)
{
    return byte_order == LUM_ORDER_LITTLE ? "little" : "big";
}

static void print_profile(void)
{
    lum_profile p;
    uint32_t uses[LUM_TLV_USES];
    lum_profile_default(&p);
    for (unsigned i = 0; i < LUM_TLV_USES; i++) {
        uses[i] = p.tlv[i];
    }
    const struct number rows[] = {
        {"data_packet_type", p.data_packet_type},
        {"samples", p.samples_at},
        {"angle_lsb_pdeg", (int64_t)p.angle_lsb_pdeg},
        {"unit_ns", p.clock_unit_ns},
    };
    printf("    profile = {\n");
    PRINT_NUMBERS("        ", rows);
    printf("        set_ip_order = \"%s\",\n",
           p.set_ip_order == LUM_SET_IP_NETWORK ? "network" : "little");
    printf("        angle_order = \"%s\",\n",
           p.angle_order == LUM_AZIMUTH_ELEVATION ? "azimuth_elevation"
                                                  : "elevation_azimuth");
    printf("        sample_order = \"%s\",\n", order_of(p.sample_order));
    printf("        group = {\n");
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        printf(
            "            %s = {at = %u, bytes = %u, order = \"%s\", low = %u, "
            "bits = %u},\n",
            name_of(fields, f), (unsigned)p.group[f].at,
            (unsigned)p.group[f].bytes, order_of(p.group[f].order),
            (unsigned)p.group[f].low, (unsigned)p.group[f].bits);
    }
    printf("        },\n");
    print_named("eye_values", eyes, p.eye_values, LUM_EYES);
    print_named("tlv", tlvs, uses, LUM_TLV_USES);
    printf("    },\n");
}

static void print_calibration(void)
{
    lum_calibration c;
    lum_calibration_default(&c);
    printf("    calibration = {\n");
    printf("        speed_of_light = %" PRIu32 ",\n", c.speed_of_light);
    printf("        tof_lsb_fs = %" PRIu32 ",\n", c.tof_lsb_fs);
    for (unsigned i = 0; i < LUM_EYES; i++) {
        const lum_eye_calibration *e = &c.eye[i];
        const struct number rows[] = {
            {"tof_offset_fs", e->tof_offset_fs},
            {"azimuth_center_udeg", e->azimuth_center_udeg},
            {"azimuth_width_udeg", e->azimuth_width_udeg},
            {"elevation_min_udeg", e->elevation_min_udeg},
            {"elevation_max_udeg", e->elevation_max_udeg},
        };
        printf("        %s = {\n", name_of(eyes, i));
        PRINT_NUMBERS("            ", rows);
        printf("        },\n");
    }
    printf("    },\n");
}

int main(void)
{
    printf("-- Printed by lum_wireshark_tables from the tables of the C code;"
           " not to be edited.\nlocal tables = {\n");
    print_header();
    print_wire();
    print_commands();
    print_laser();
    print_profile();
    print_calibration();
    printf("}\n\n");
    return fflush(stdout) == 0 && !ferror(stdout) ? EXIT_SUCCESS : EXIT_FAILURE;
}
