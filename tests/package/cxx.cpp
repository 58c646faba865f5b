// A program in C++ that uses every library of an installed copy. All headers are
// included by the command line (run).
#include <cstdio>

int main()
{
    static const unsigned char heartbeat[LUM_HEARTBEAT_BYTES] = {
        0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12, 8, 0, 0, 0};
    lum_layout layout;
    lum_group group;
    lum_calibration calibration;
    lum_projector projector;
    lum_clock_sync clock;
    lum_clock_estimate estimate;
    lum_sensor_options options;
    lum_sensor *sensor = nullptr;
    lum_error error;

    lum_layout_default(&layout);
    lum_calibration_default(&calibration);
    lum_clock_sync_init(&clock);
    lum_sensor_options_default(&options);
    const bool good =
        lum_packet_decode(&layout, heartbeat, sizeof heartbeat, &group) ==
            LUM_PACKET_HEARTBEAT &&
        lum_word_tof(lum_word_make(-5, true, 7)) == -5 &&
        lum_projector_init(&projector, &calibration, &layout) == LUM_OK &&
        lum_clock_sync_estimate(&clock, &estimate) == LUM_END &&
        lum_sensor_open(&options, &sensor, &error) == LUM_NET_OK &&
        lum_calibration_parse("version: 1\n", 11, "text", &calibration,
                              &error) == 0;
    lum_sensor_close(sensor);
    std::puts(good ? "C++ " LUM_VERSION : "C++ failed");
    return good ? 0 : 1;
}
