#include "normal.h"

#define CELLS_OF_SIGMA 32
#define CELLS          (LUM_NORMAL_SIGMAS * CELLS_OF_SIGMA)
#define CELL           (LUM_NORMAL_ONE / CELLS_OF_SIGMA)

/* Share of the bell between its middle and k / 32 sigma, in units of 2^-33. */
static const uint32_t share[CELLS + 1] = {
    0u,          107072825u,  214041147u,  320800767u,  427248098u,
    533280464u,  638796397u,  743695931u,  847880881u,  951255124u,
    1053724858u, 1155198862u, 1255588735u, 1354809125u, 1452777945u,
    1549416569u, 1644650019u, 1738407131u, 1830620702u, 1921227625u,
    2010168999u, 2097390230u, 2182841104u, 2266475846u, 2348253162u,
    2428136261u, 2506092859u, 2582095164u, 2656119850u, 2728148006u,
    2798165078u, 2866160788u, 2932129042u, 2996067829u, 3057979099u,
    3117868636u, 3175745916u, 3231623959u, 3285519171u, 3337451178u,
    3387442651u, 3435519133u, 3481708856u, 3526042553u, 3568553272u,
    3609276190u, 3648248417u, 3685508816u, 3721097807u, 3755057189u,
    3787429955u, 3818260112u, 3847592512u, 3875472680u, 3901946650u,
    3927060812u, 3950861759u, 3973396142u, 3994710539u, 4014851322u,
    4033864537u, 4051795791u, 4068690151u, 4084592039u, 4099545151u,
    4113592371u, 4126775700u, 4139136192u, 4150713892u, 4161547791u,
    4171675779u, 4181134611u, 4189959875u, 4198185974u, 4205846100u,
    4212972234u, 4219595129u, 4225744316u, 4231448105u, 4236733593u,
    4241626677u, 4246152069u, 4250333314u, 4254192813u, 4257751848u,
    4261030606u, 4264048212u, 4266822755u, 4269371325u, 4271710040u,
    4273854086u, 4275817748u, 4277614447u, 4279256775u, 4280756530u,
    4282124753u, 4283371760u, 4284507182u, 4285539994u, 4286478553u,
    4287330627u, 4288103431u, 4288803655u, 4289437496u, 4290010689u,
    4290528529u, 4290995906u, 4291417326u, 4291796936u, 4292138552u,
    4292445675u, 4292721519u, 4292969027u, 4293190895u, 4293389583u,
    4293567340u, 4293726216u, 4293868077u, 4293994623u, 4294107396u,
    4294207797u, 4294297097u, 4294376445u, 4294446882u, 4294509346u,
    4294564688u, 4294613670u, 4294656982u, 4294695242u, 4294729007u,
    4294758776u, 4294784995u, 4294808067u, 4294828348u, 4294846159u,
    4294861786u, 4294875482u, 4294887476u, 4294897967u, 4294907136u,
    4294915141u, 4294922123u, 4294928208u, 4294933504u, 4294938110u,
    4294942112u, 4294945586u, 4294948598u, 4294951207u, 4294953465u,
    4294955418u, 4294957104u, 4294958559u, 4294959814u, 4294960894u,
    4294961824u, 4294962623u, 4294963309u, 4294963897u, 4294964402u,
    4294964834u, 4294965203u, 4294965519u, 4294965788u, 4294966018u,
    4294966214u, 4294966381u, 4294966522u, 4294966643u, 4294966745u,
    4294966832u, 4294966905u, 4294966967u, 4294967020u, 4294967064u,
    4294967101u, 4294967133u, 4294967159u, 4294967182u, 4294967201u,
    4294967216u, 4294967230u, 4294967241u, 4294967250u, 4294967258u,
    4294967264u, 4294967270u, 4294967274u, 4294967278u, 4294967281u,
    4294967284u, 4294967286u, 4294967288u,
};

/* Within a cell the cumulative bends away from its chord: by the density's
 * slope, which is -x times the density. In units of a sigma along the chord;
 * at is where, counted from the cell's beginning. */
static int64_t bend(int64_t cell, int64_t at)
{
    return (2 * cell + 1) * at * (CELL - at) /
           (4 * CELLS_OF_SIGMA * LUM_NORMAL_ONE);
}

static int64_t cumulative_of_half(int64_t x)
{
    if (x >= LUM_NORMAL_SIGMAS * LUM_NORMAL_ONE) {
        return share[CELLS];
    }
    const int64_t cell = x / CELL;
    const int64_t at = x % CELL;
    const int64_t height = (int64_t)share[cell + 1] - share[cell];
    return share[cell] + height * (at + bend(cell, at)) / CELL;
}

int64_t lum_normal_cumulative(int64_t x)
{
    return x < 0 ? -cumulative_of_half(-x) : cumulative_of_half(x);
}

/* The last cell that begins at or below u. */
static int64_t find_cell(int64_t u)
{
    int64_t low = 0;
    int64_t high = CELLS;
    while (high - low > 1) {
        const int64_t middle = (low + high) / 2;
        if (share[middle] <= u) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

static int64_t quantile_of_half(int64_t u)
{
    if (u >= share[CELLS]) {
        return LUM_NORMAL_SIGMAS * LUM_NORMAL_ONE;
    }
    const int64_t cell = find_cell(u);
    const int64_t height = (int64_t)share[cell + 1] - share[cell];
    const int64_t at = (u - share[cell]) * CELL / height;
    return cell * CELL + at - bend(cell, at);
}

int64_t lum_normal_quantile(int64_t u)
{
    return u < 0 ? -quantile_of_half(-u) : quantile_of_half(u);
}
