/* What the tests of writing and of reading a command hold them against. */
#ifndef LUM_TEST_COMMAND_TABLE_H
#define LUM_TEST_COMMAND_TABLE_H

#include "lum/command.h"

/* The manual's table, written down a second time. */
static const struct {
    lum_command_id id;
    char letter;
    int min, max, step; /* min -1: no value */
} table[] = {
    {LUM_COMMAND_LASER_ON, 'u', -1, -1, 1},
    {LUM_COMMAND_LASER_OFF, 'd', -1, -1, 1},
    {LUM_COMMAND_POWER, 'p', 0, 100, 1},
    {LUM_COMMAND_THRESHOLD_GREEN, 'g', 0, 100, 1},
    {LUM_COMMAND_THRESHOLD_BLUE, 'b', 0, 100, 1},
    {LUM_COMMAND_LINE_MODE, 'f', 0, 1, 1},
    {LUM_COMMAND_YSCAN, 'y', 11, 30, 1},
    {LUM_COMMAND_HOLDOFF, 'h', 150, 250, 10},
    {LUM_COMMAND_OFFSET_GREEN, 'G', 0, 30, 1},
    {LUM_COMMAND_OFFSET_BLUE, 'B', 0, 30, 1},
};

#endif
