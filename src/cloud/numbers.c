#include "numbers.h"

#include "decimal.h"
#include "le.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of PLY's two names, those that Open3D knows: it knows uint16, but not uint or
 * ushort. */
const lum_number_spec lum_number_types[LUM_NUMBER_TYPES] = {
    [LUM_NUMBER_U8] = {"u8", "uchar", "uint8", 'U', 1, 2, 1},
    [LUM_NUMBER_U16] = {"u16", "uint16", "ushort", 'U', 2, 4, 3},
    [LUM_NUMBER_U32] = {"u32", "uint", "uint32", 'U', 4, 6, 5},
    [LUM_NUMBER_U64] = {"u64", NULL, NULL, '\0', 8, 0, 7},
    [LUM_NUMBER_I8] = {"i8", "char", "int8", 'I', 1, 1, 2},
    [LUM_NUMBER_I16] = {"i16", "short", "int16", 'I', 2, 3, 4},
    [LUM_NUMBER_I32] = {"i32", "int", "int32", 'I', 4, 5, 6},
    [LUM_NUMBER_I64] = {"i64", NULL, NULL, '\0', 8, 0, 8},
    [LUM_NUMBER_F32] = {"f32", "float", "float32", 'F', 4, 7, 9},
    [LUM_NUMBER_F64] = {"f64", "double", "float64", 'F', 8, 8, 10},
};

/* An unsigned number of 1, 2, 4 or 8 bytes in memory. */
static uint64_t load(const unsigned char *p, size_t bytes)
{
    uint8_t one = p[0];
    uint16_t two;
    uint32_t four;
    uint64_t eight;
    if (bytes == sizeof one) {
        return one;
    }
    if (bytes == sizeof two) {
        memcpy(&two, p, sizeof two);
        return two;
    }
    if (bytes == sizeof four) {
        memcpy(&four, p, sizeof four);
        return four;
    }
    memcpy(&eight, p, sizeof eight);
    return eight;
}

static uint64_t bits_of(lum_number_type type, const void *values, size_t i)
{
    const size_t bytes = lum_number_types[type].bytes;
    return load((const unsigned char *)values + i * bytes, bytes);
}

unsigned char *lum_number_put(unsigned char *p, lum_number_type type,
                              const void *values, size_t i)
{
    const uint64_t bits = bits_of(type, values, i);
    switch (lum_number_types[type].bytes) {
    case 1:
        return lum_put_u8(p, (uint8_t)bits);
    case 2:
        return lum_put_le16(p, (uint16_t)bits);
    case 4:
        return lum_put_le32(p, (uint32_t)bits);
    default:
        return lum_put_le64(p, bits);
    }
}

static int64_t signed_of(uint64_t bits, size_t bytes)
{
    const uint64_t sign = UINT64_C(1) << (8u * bytes - 1u);
    const uint64_t value = (bits ^ sign) - sign;
    int64_t v;
    memcpy(&v, &value, sizeof v);
    return v;
}

static double real_of(lum_number_type type, uint64_t bits)
{
    const uint32_t low = (uint32_t)(bits & UINT32_MAX);
    float single;
    double v;
    memcpy(&single, &low, sizeof single);
    memcpy(&v, &bits, sizeof v);
    return type == LUM_NUMBER_F32 ? (double)single : v;
}

/* The program may have set another point, even one of several bytes. */
static char *set_point(char *p, char *end)
{
    char *at = p + strspn(p, "-+0123456789einf");
    char *rest = at + strcspn(at, "0123456789");
    if (at == rest) {
        return end;
    }
    *at = '.';
    memmove(at + 1, rest, (size_t)(end - rest));
    return end - (rest - at - 1);
}

/* Nearly all numbers of people have few digits. */
static char *print_real(char *p, lum_number_type type, double v)
{
    const int most = type == LUM_NUMBER_F32 ? 9 : 17;
    if (!(fabs(v) <= HUGE_VAL)) { /* isnan() of a double warns on Windows */
        memcpy(p, "nan", 4);
        return p + 3;
    }
    int n = 0;
    for (int digits = most == 9 ? 6 : 15; digits <= most; digits++) {
        n = snprintf(p, LUM_NUMBER_ROOM, "%.*g", digits, v);
        const double again = strtod(p, NULL);
        const bool is_same =
            type == LUM_NUMBER_F32 ? (float)again == (float)v : again == v;
        digits = is_same ? most : digits;
    }
    return set_point(p, p + n);
}

char *lum_number_print(char *p, lum_number_type type, const void *values,
                       size_t i)
{
    const uint64_t bits = bits_of(type, values, i);
    if (type >= LUM_NUMBER_F32) {
        return print_real(p, type, real_of(type, bits));
    }
    return type >= LUM_NUMBER_I8
               ? lum_put_i64(p, signed_of(bits, lum_number_types[type].bytes))
               : lum_put_u64(p, bits);
}
