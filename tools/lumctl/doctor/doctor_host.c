/* What Linux says about this host, besides its interfaces. */
#include "doctor.h"

#include "doctor_capture.h"
#include "doctor_knock.h"
#include "doctor_trace.h"
#include "doctor_way.h"

#include <unistd.h>

#define MTU_MIN 1500u

void doctor_check_mtu(struct doctor *d, struct doctor_finding *out)
{
    const unsigned mtu = way_mtu(d->interface);
    if (mtu == 0) {
        doctor_unseen(out, "not looked at: the kernel does not tell that of %s",
                      d->interface);
    } else if (mtu < MTU_MIN) {
        doctor_wrong(out,
                     "%s takes packets of %u bytes at most; the sensor's need "
                     "%u",
                     d->interface, mtu, MTU_MIN);
        doctor_fix(out, "sudo ip link set dev %s mtu %u", d->interface,
                   MTU_MIN);
    } else {
        doctor_fine(out, "%s takes packets of %u bytes", d->interface, mtu);
    }
}

void doctor_fix_watch(const struct doctor *d, struct doctor_finding *out,
                      const char *filter, const char *why)
{
    doctor_fix(out, "sudo tcpdump -ni %s '%s'    # %s",
               d->interface[0] != '\0' ? d->interface : "any", filter, why);
}

/* The kernel doubles the requested size, for its own overhead. */
size_t doctor_buffer_payload(size_t granted)
{
    return granted / 2u;
}

void doctor_fix_buffer(struct doctor_finding *out)
{
    doctor_fix(out, "sudo sysctl -w net.core.rmem_max=%u",
               LUM_SOCKET_RECEIVE_BUFFER);
}

int doctor_can_trace(lum_error *error)
{
    return trace_allowed(error);
}

uint16_t doctor_other_port(const struct doctor *d)
{
    return knock_other_port(d->sensor, d->ctl->options.interface);
}

bool doctor_answers_at(const struct doctor *d, uint16_t port)
{
    const lum_endpoint there = {d->sensor.address, port};
    return knock_reaches(there, d->ctl->options.interface);
}

int doctor_count_begin(const struct doctor *d, uint16_t to_port)
{
    return d->interface[0] == '\0'
               ? -1
               : capture_open(d->interface, d->sensor, to_port);
}

uint64_t doctor_count_end(int counter)
{
    const uint64_t n = counter >= 0 ? capture_count(counter) : 0;
    if (counter >= 0) {
        (void)close(counter);
    }
    return n;
}
