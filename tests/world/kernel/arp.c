#define _GNU_SOURCE
#include "arp.h"

#include "time.h"

#include <arpa/inet.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <string.h>

/* RFC 826, for IPv4 on Ethernet. */
#define AT_OPERATION  6u
#define AT_SENDER_MAC 8u
#define AT_SENDER     14u
#define AT_TARGET_MAC 18u
#define AT_TARGET     24u
#define QUESTION      1u
#define ANSWER        2u
#define ANSWER_NS     (5 * WORLD_US) /* to make one, at most */

static uint32_t read_address(const uint8_t *from)
{
    uint32_t wire = 0;
    memcpy(&wire, from, sizeof wire);
    return ntohl(wire);
}

static void put_address(uint8_t *to, uint32_t address)
{
    const uint32_t wire = htonl(address);
    memcpy(to, &wire, sizeof wire);
}

static void begin(uint8_t packet[WORLD_ARP_BYTES], uint8_t operation,
                  const world_interface *from)
{
    static const uint8_t kind[AT_OPERATION] = {0, 1, 8, 0, 6, 4};
    memset(packet, 0, WORLD_ARP_BYTES);
    memcpy(packet, kind, sizeof kind);
    packet[AT_OPERATION + 1u] = operation;
    memcpy(packet + AT_SENDER_MAC, from->mac, sizeof from->mac);
}

static void arrive(void *argument);

/* A datagram without a number carries it. */
static void carry(world_interface *from, world_interface *to,
                  const uint8_t *packet, bool is_for_all, int64_t after_ns)
{
    int64_t ns = 0;
    if (!world_link_passes(from, to, &ns)) {
        return;
    }
    world_datagram *carrier = world_datagram_new(WORLD_ARP_BYTES);
    memcpy(carrier->bytes, packet, WORLD_ARP_BYTES);
    carrier->out_at = from;
    carrier->in_at = to;
    carrier->private.is_broadcast = is_for_all;
    (void)world_at(world_now() + after_ns + ns, arrive, carrier);
}

static bool has_address(const world_host *host, uint32_t address)
{
    return address >> 24 != 127u && world_net_owner(host, address) != NULL;
}

/* Who comes first of two with one address is a matter of chance. */
static void answer(world_interface *at, world_interface *to,
                   const uint8_t *question)
{
    uint8_t packet[WORLD_ARP_BYTES];
    begin(packet, ANSWER, at);
    memcpy(packet + AT_SENDER, question + AT_TARGET, 4);
    memcpy(packet + AT_TARGET_MAC, question + AT_SENDER_MAC, 10);
    carry(at, to, packet, false,
          world_random_between(&at->arp_random, 0, ANSWER_NS));
}

static void arrive(void *argument)
{
    world_datagram *carrier = argument;
    world_interface *at = carrier->in_at;
    const uint8_t *packet = carrier->bytes;
    const uint32_t sender = read_address(packet + AT_SENDER);
    if (at->is_up && at->has_carrier) {
        world_packet_hear(at, carrier->out_at, ETH_P_ARP,
                          carrier->private.is_broadcast ? PACKET_BROADCAST
                                                        : PACKET_HOST,
                          packet, WORLD_ARP_BYTES);
        if (packet[AT_OPERATION + 1u] == ANSWER) {
            world_neighbour_answered(at, sender, carrier->out_at);
        } else if (has_address(at->host, read_address(packet + AT_TARGET))) {
            world_neighbour_learn(at, sender, carrier->out_at);
            answer(at, carrier->out_at, packet);
        }
    }
    world_datagram_free(carrier);
}

/* Those that would not notice it are left out. */
void world_arp_send(world_interface *from, const uint8_t *packet)
{
    const uint32_t target = read_address(packet + AT_TARGET);
    for (world_interface *i = from->segment->interfaces; i != NULL;
         i = i->next_of_segment) {
        if (i != from &&
            (has_address(i->host, target) || world_packet_listens(i->host))) {
            carry(from, i, packet, true, 0);
        }
    }
}

void world_arp_ask(world_interface *from, uint32_t source, uint32_t target)
{
    uint8_t packet[WORLD_ARP_BYTES];
    begin(packet, QUESTION, from);
    put_address(packet + AT_SENDER, source);
    put_address(packet + AT_TARGET, target);
    world_arp_send(from, packet);
}
