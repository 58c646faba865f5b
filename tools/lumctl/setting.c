#include "setting.h"

#include "yscan/yscan_table.h"

const struct setting settings[SETTINGS] = {
    {LUM_COMMAND_LINE_MODE, "lines"},
    {LUM_COMMAND_YSCAN, "yscan"},
    {LUM_COMMAND_POWER, "power"},
    {LUM_COMMAND_THRESHOLD_GREEN, "threshold green"},
    {LUM_COMMAND_THRESHOLD_BLUE, "threshold blue"},
    {LUM_COMMAND_HOLDOFF, "holdoff"},
    {LUM_COMMAND_OFFSET_GREEN, "offset green"},
    {LUM_COMMAND_OFFSET_BLUE, "offset blue"},
};

const char *const setting_shapes[SETTING_SHAPES] = {
    [LUM_YSCAN_UNIFORM] = "uniform",
    [LUM_YSCAN_GAUSSIAN] = "gaussian",
    [LUM_YSCAN_REGIONS] = "regions",
};

const char *setting_name(lum_command_id id)
{
    for (size_t i = 0; i < SETTINGS; i++) {
        if (settings[i].id == id) {
            return settings[i].name;
        }
    }
    return NULL;
}

unsigned setting_lines(uint16_t mode)
{
    return mode == 0 ? YSCAN_LINES : YSCAN_LINES_FEW;
}
