/* Would this host's firewall let the sensor's packets through? Rules of nft or
 * iptables, read from what these programs print, and walked with one packet as
 * the kernel does. A match that is not known here may hold or not. */
#ifndef LUMCTL_DOCTOR_RULES_H
#define LUMCTL_DOCTOR_RULES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define RULE_TEXT_BYTES 200u
#define RULE_NAME_BYTES 64u
#define RULES_MAX       4096u
#define RULE_CHAINS_MAX 512u
#define RULE_DEPTH_MAX  16u

/* What is asked about: to the sensor, or its answer. UDP, IPv4. */
struct rule_packet {
    bool is_out;
    uint32_t source;
    uint32_t destination;
    uint16_t source_port;      /* 0: any */
    uint16_t destination_port; /* 0: any */
    const char *device;        /* empty: not known */
};

enum rule_match {
    RULE_NO,
    RULE_MAYBE,
    RULE_YES
};

enum rule_verdict {
    RULE_NONE, /* goes on with the next rule */
    RULE_ACCEPT,
    RULE_DROP,
    RULE_JUMP,
    RULE_GOTO,
    RULE_RETURN
};

/* Where in its way a packet meets a chain; others are not of interest. */
enum rule_hook {
    RULE_NO_HOOK,
    RULE_IN,
    RULE_OUT
};

struct rule {
    uint16_t chain;
    uint8_t match;   /* an enum rule_match */
    uint8_t verdict; /* an enum rule_verdict */
    char target[RULE_NAME_BYTES];
    char text[RULE_TEXT_BYTES];
};

struct rule_chain {
    char family[16]; /* of nft: ip, inet, netdev, bridge, ... */
    char table[RULE_NAME_BYTES];
    char name[RULE_NAME_BYTES];
    uint8_t hook; /* an enum rule_hook */
    bool drops;   /* the policy */
};

/* Rules in the order they were read, those of a chain in its own. */
struct ruleset {
    struct rule_packet packet;
    size_t chain_count;
    size_t rule_count;
    bool is_cut; /* there were more than fit */
    bool is_nft;
    struct rule_chain chains[RULE_CHAINS_MAX];
    struct rule rules[RULES_MAX];
};

/* What becomes of the packet. */
enum rule_fate {
    RULE_PASSES,
    RULE_MAY_BE_DROPPED,
    RULE_IS_DROPPED
};

struct rule_finding {
    enum rule_fate fate;
    const struct rule_chain *base; /* the chain that it entered by */
    const struct rule *rule;       /* that drops; NULL: the policy does */
};

/* NULL without memory; free() it. */
struct ruleset *rules_new(const struct rule_packet *packet, bool is_nft);

/* Adds a chain, or finds the one of that name. NULL: no room. */
struct rule_chain *rules_chain(struct ruleset *set, const char *family,
                               const char *table, const char *name);

/* Adds an empty rule that always matches. NULL: no room. */
struct rule *rules_add(struct ruleset *set, const struct rule_chain *chain,
                       const char *text);

/* Output of `nft list ruleset`. */
void rules_read_nft(struct ruleset *set, FILE *in);

/* Output of iptables-save. */
void rules_read_iptables(struct ruleset *set, FILE *in);

void rules_judge(const struct ruleset *set, struct rule_finding *out);

/* Whether a part of the packet is what a value says. Both write values alike:
 * several at commas, any of which may match. */
typedef enum rule_match (*rule_matcher)(const struct rule_packet *packet,
                                        const char *value);
enum rule_match rules_match_source(const struct rule_packet *packet,
                                   const char *value);
enum rule_match rules_match_destination(const struct rule_packet *packet,
                                        const char *value);
enum rule_match rules_match_source_port(const struct rule_packet *packet,
                                        const char *value);
enum rule_match rules_match_destination_port(const struct rule_packet *packet,
                                             const char *value);
enum rule_match rules_match_protocol(const struct rule_packet *packet,
                                     const char *value);
/* The first packet that leaves begins a connection, an answer belongs to one.
 */
enum rule_match rules_match_state(const struct rule_packet *packet,
                                  const char *value);

/* wildcard: the character that stands for any ending. */
enum rule_match rules_match_device(const char *value, const char *device,
                                   char wildcard);

enum rule_match rules_not(enum rule_match match);
enum rule_match rules_and(enum rule_match a, enum rule_match b);

#endif
