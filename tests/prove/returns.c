/* Returns of a line: any words, every count up to 4, words and results ending
 * where their memory ends. */
#include "lum/returns.h"
#include "unknown.h"

#define MOST 4u

static uint32_t words[MOST];
static lum_return out[MOST];

static void compute(uint32_t n)
{
    lum_returns_compute(words + (MOST - n), n, out + (MOST - n));
}

void main(void)
{
    any_bytes(words, sizeof words);
    const uint32_t n = any_u32(0, MOST);
    //@ split n;
    compute(n);
}
