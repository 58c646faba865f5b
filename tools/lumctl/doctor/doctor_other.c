/* Fewer checks of this host, for systems whose kernel does not say as much as
 * Linux: only what the net library can do everywhere. */
#include "doctor.h"
#include "doctor_knock.h"

#include "lum/wire.h"

#include <stddef.h>

void doctor_check_interface(struct doctor *d, struct doctor_finding *out)
{
    d->is_local = d->sensor.address >> 24 == 127u;
    if (d->is_local) {
        doctor_fine(out, "%s is this host itself", d->address);
        return;
    }
    doctor_unseen(
        out, "not looked at on this system; one of the host's interfaces needs "
             "an address in the sensor's subnet, such as 10.42.0.1/24");
}

/* A datagram that cannot leave has no route. */
void doctor_check_route(struct doctor *d, struct doctor_finding *out)
{
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .interface_name =
                                            d->ctl->options.interface};
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    const lum_timestamp request = {1, 0};
    const lum_outgoing datagram = {packet, sizeof packet, d->sensor};
    lum_socket *socket = NULL;
    lum_error error = {""};
    lum_timestamp_encode(packet, &request);
    if (lum_socket_open(&options, &socket, &error) != LUM_NET_OK ||
        lum_socket_send(socket, &datagram, &error) != LUM_NET_OK) {
        doctor_wrong(out, "%s", error.text);
        doctor_lack(d, DOCTOR_NEEDS_ROUTE, "no route");
    } else {
        doctor_fine(out, "a packet leaves for %s", d->address);
    }
    lum_socket_close(socket);
}

void doctor_check_arp(struct doctor *d, struct doctor_finding *out)
{
    if (d->is_local) {
        doctor_fine(out, "not needed: %s is on this host", d->address);
        return;
    }
    doctor_unseen(out,
                  "not looked at on this system; arp -a shows whether "
                  "anybody has %s",
                  d->address);
}

void doctor_check_port(struct doctor *d, struct doctor_finding *out)
{
    doctor_unseen(out,
                  "not looked at on this system; netstat -an -p udp shows "
                  "who has port %u",
                  (unsigned)d->sensor.port);
}

void doctor_check_firewall(struct doctor *d, struct doctor_finding *out)
{
    doctor_unseen(out,
                  "not looked at on this system; its firewall has to let "
                  "UDP from %s port %u in",
                  d->address, (unsigned)d->sensor.port);
}

void doctor_check_mtu(struct doctor *d, struct doctor_finding *out)
{
    (void)d;
    doctor_unseen(out, "not looked at on this system; the interface has to "
                       "take packets of 1500 bytes");
}

void doctor_fix_watch(const struct doctor *d, struct doctor_finding *out,
                      const char *filter, const char *why)
{
    (void)d;
    doctor_fix(out, "dumpcap -f \"%s\" -P -w - | tshark -r -    # %s", filter,
               why);
}

size_t doctor_buffer_payload(size_t granted)
{
    return granted;
}

void doctor_fix_buffer(struct doctor_finding *out)
{
    doctor_fix(out,
               "raise the system's limit for UDP receive buffers to %u "
               "bytes (kern.ipc.maxsockbuf on BSD and macOS)",
               LUM_SOCKET_RECEIVE_BUFFER);
}

uint16_t knock_other_port(lum_endpoint to, const char *interface)
{
    (void)to;
    (void)interface;
    return 0;
}

bool knock_reaches(lum_endpoint to, const char *interface)
{
    (void)to;
    (void)interface;
    return false;
}

int capture_open(const char *interface, lum_endpoint sensor, uint16_t to_port)
{
    (void)interface;
    (void)sensor;
    (void)to_port;
    return -1;
}

uint64_t capture_end(int fd)
{
    (void)fd;
    return 0;
}
