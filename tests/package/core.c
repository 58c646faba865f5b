/* Links the core of an installed copy. */
#include <lum/command.h>
#include <lum/packet.h>
#include <lum/version.h>

#include <stdio.h>

int main(void)
{
    static const unsigned char heartbeat[12] = {
        0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12, 8, 0, 0, 0};
    lum_layout layout;
    lum_group group;

    lum_layout_default(&layout);
    (void)puts("core " LUM_VERSION);
    return lum_packet_decode(&layout, heartbeat, sizeof heartbeat, &group) !=
           LUM_PACKET_HEARTBEAT;
}
