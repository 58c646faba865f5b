/* The firewall of a Linux host: which rule drops the sensor's packets. */
#define _GNU_SOURCE

#include "doctor.h"
#include "doctor_rules.h"

#include "lum/base/time.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define LIMIT_NS     INT64_C(1500000000)
#define OUTPUT_BYTES (4u << 20)
#define LISTER_WORDS 3u

/* A program that prints rules, its name first. */
struct lister {
    char words[LISTER_WORDS][24];
    void (*read)(struct ruleset *set, FILE *in);
    bool is_nft;
};

enum {
    LIST_NFT,
    LIST_LEGACY,
    LIST_IPTABLES
};

static const struct lister listers[] = {
    [LIST_NFT] = {{"nft", "list", "ruleset"}, rules_read_nft, true},
    [LIST_LEGACY] = {{"iptables-legacy-save"}, rules_read_iptables, false},
    [LIST_IPTABLES] = {{"iptables-save"}, rules_read_iptables, false},
};

/* Where administrators' programs are. */
static const char *const folders[] = {"/usr/sbin", "/sbin", "/usr/bin", "/bin",
                                      "/usr/local/sbin"};

static bool find_program(const char *name, char *out, size_t room)
{
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++) {
        (void)snprintf(out, room, "%s/%.23s", folders[i], name);
        if (access(out, X_OK) == 0) {
            return true;
        }
    }
    return false;
}

/* Starts a program that writes to a descriptor. */
static bool start(const char *path, const struct lister *lister, int to,
                  pid_t *child)
{
    struct lister copy = *lister; /* arguments are not constant */
    char *arguments[LISTER_WORDS + 1u] = {NULL};
    posix_spawn_file_actions_t actions;
    for (size_t i = 0; i < LISTER_WORDS && copy.words[i][0] != '\0'; i++) {
        arguments[i] = copy.words[i];
    }
    if (posix_spawn_file_actions_init(&actions) != 0) {
        return false;
    }
    const bool is_started =
        posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDWR, 0) ==
            0 &&
        posix_spawn_file_actions_adddup2(&actions, to, 1) == 0 &&
        posix_spawn_file_actions_adddup2(&actions, 0, 2) == 0 &&
        posix_spawn(child, path, &actions, NULL, arguments, environ) == 0;
    (void)posix_spawn_file_actions_destroy(&actions);
    return is_started;
}

/* All of a pipe within the time; bounded. False: not to its end. */
static bool drain(int fd, const struct doctor *d, FILE *out)
{
    const int64_t deadline = lum_time_monotonic_ns() + LIMIT_NS;
    size_t total = 0;
    while (lum_time_monotonic_ns() < deadline && !doctor_is_cancelled(d) &&
           total < OUTPUT_BYTES) {
        struct pollfd wait = {.fd = fd, .events = POLLIN};
        char bytes[8192];
        if (poll(&wait, 1, 100) <= 0) {
            continue;
        }
        const ssize_t n = read(fd, bytes, sizeof bytes);
        if (n <= 0) {
            return n == 0;
        }
        if (fwrite(bytes, 1, (size_t)n, out) != (size_t)n) {
            return false;
        }
        total += (size_t)n;
    }
    return false;
}

static bool wait_for(pid_t child, bool is_whole)
{
    int status = 0;
    if (!is_whole) {
        (void)kill(child, SIGKILL);
    }
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return is_whole && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

static bool collect(const struct doctor *d, const char *path,
                    const struct lister *lister, FILE *out)
{
    int ends[2];
    pid_t child = 0;
    if (pipe2(ends, O_CLOEXEC) != 0) {
        return false;
    }
    const bool is_started = start(path, lister, ends[1], &child);
    (void)close(ends[1]);
    const bool is_whole = is_started && drain(ends[0], d, out);
    (void)close(ends[0]);
    return is_started && wait_for(child, is_whole);
}

/* The rules that a program prints. False: it is not there, or may not. */
static bool read_rules(const struct doctor *d, const struct lister *lister,
                       struct ruleset *set)
{
    char path[64];
    char *text = NULL;
    size_t len = 0;
    if (!find_program(lister->words[0], path, sizeof path)) {
        return false;
    }
    FILE *out = open_memstream(&text, &len);
    if (out == NULL) {
        return false;
    }
    bool is_read = collect(d, path, lister, out);
    is_read = fclose(out) == 0 && is_read;
    FILE *in = is_read && len > 0 ? fmemopen(text, len, "r") : NULL;
    if (in != NULL) {
        lister->read(set, in);
        (void)fclose(in);
    }
    free(text);
    return is_read;
}

/* Rules of the old kind stand beside those of nft. */
static bool has_legacy_rules(void)
{
    char name[32];
    FILE *f = fopen("/proc/net/ip_tables_names", "re");
    const bool has = f != NULL && fgets(name, sizeof name, f) != NULL;
    if (f != NULL) {
        (void)fclose(f);
    }
    return has;
}

static struct rule_packet packet_of(const struct doctor *d, bool is_out)
{
    struct rule_packet p = {
        .is_out = is_out,
        .source = d->sensor.address,
        .destination = d->source,
        .source_port = d->sensor.port,
        .device = d->interface,
    };
    if (is_out) {
        p.source = d->source;
        p.destination = d->sensor.address;
        p.source_port = 0;
        p.destination_port = d->sensor.port;
    }
    return p;
}

static void mend_nft(const struct doctor *d, const struct ruleset *set,
                     const struct rule_chain *base, struct doctor_finding *out)
{
    const bool is_out = set->packet.is_out;
    if (strcmp(base->table, "firewalld") == 0) {
        doctor_mend(out, "sudo firewall-cmd --zone=trusted --add-source=%s",
                    d->address);
        return;
    }
    doctor_mend(out, "sudo nft insert rule %s %s %s ip %s %s udp %s %u accept",
                base->family, base->table, base->name,
                is_out ? "daddr" : "saddr", d->address,
                is_out ? "dport" : "sport", (unsigned)d->sensor.port);
}

static void mend_iptables(const struct doctor *d, const struct ruleset *set,
                          const struct rule_chain *base,
                          struct doctor_finding *out)
{
    const bool is_out = set->packet.is_out;
    doctor_mend(out, "sudo iptables -t %s -I %s %s %s -p udp --%s %u -j ACCEPT",
                base->table, base->name, is_out ? "-d" : "-s", d->address,
                is_out ? "dport" : "sport", (unsigned)d->sensor.port);
}

static void mend(const struct doctor *d, const struct ruleset *set,
                 const struct rule_finding *found, struct doctor_finding *out)
{
    const struct rule_chain *at =
        found->rule == NULL ? found->base : &set->chains[found->rule->chain];
    if (strncmp(at->name, "ufw", 3) == 0) {
        doctor_mend(out, "sudo ufw allow proto udp from %s port %u", d->address,
                    (unsigned)d->sensor.port);
    } else if (set->is_nft) {
        mend_nft(d, set, found->base, out);
    } else {
        mend_iptables(d, set, found->base, out);
    }
}

static void say(const struct doctor *d, const struct ruleset *set,
                const struct rule_finding *found, struct doctor_finding *out)
{
    const bool is_sure = found->fate == RULE_IS_DROPPED && !set->is_cut;
    const char *way = set->packet.is_out ? "to" : "from";
    const struct rule_chain *base = found->base;
    if (found->rule == NULL) {
        (is_sure ? doctor_wrong : doctor_note)(
            out, "the policy of chain %s (table %s %s) %s packets %s %s",
            base->name, base->family, base->table,
            is_sure ? "drops" : "may drop", way, d->address);
    } else {
        const struct rule_chain *c = &set->chains[found->rule->chain];
        (is_sure ? doctor_wrong : doctor_note)(
            out, "a rule of chain %s (table %s %s) %s packets %s %s: %s",
            c->name, c->family, c->table, is_sure ? "drops" : "may drop", way,
            d->address, found->rule->text);
    }
    mend(d, set, found, out);
}

/* Both ways through the rules of one program; the worse is said. False: it
 * does not tell them. */
static bool judge(const struct doctor *d, const struct lister *lister,
                  enum rule_fate *worst, struct doctor_finding *out)
{
    bool is_read = true;
    for (int is_out = 0; is_out < 2 && is_read; is_out++) {
        const struct rule_packet packet = packet_of(d, is_out != 0);
        struct rule_finding found;
        struct ruleset *set = rules_new(&packet, lister->is_nft);
        is_read = set != NULL && read_rules(d, lister, set);
        if (is_read) {
            rules_judge(set, &found);
            if (found.fate > *worst) {
                *worst = found.fate;
                say(d, set, &found, out);
            }
        }
        free(set);
    }
    return is_read;
}

static void say_unseen(struct doctor_finding *out)
{
    char path[64];
    bool is_there = false;
    for (size_t i = 0; i < sizeof listers / sizeof listers[0]; i++) {
        is_there =
            is_there || find_program(listers[i].words[0], path, sizeof path);
    }
    if (!is_there) {
        doctor_unseen(out, "not looked at: neither nft nor iptables-save is "
                           "installed, which would show the rules");
    } else {
        doctor_unseen(out, "not looked at: only root may see the rules; sudo "
                           "lumctl doctor, or sudo nft list ruleset");
    }
}

void doctor_check_firewall(struct doctor *d, struct doctor_finding *out)
{
    enum rule_fate worst = RULE_PASSES;
    const bool has_nft = judge(d, &listers[LIST_NFT], &worst, out);
    const bool has_other =
        has_nft
            ? has_legacy_rules() && judge(d, &listers[LIST_LEGACY], &worst, out)
            : judge(d, &listers[LIST_IPTABLES], &worst, out);
    if (!has_nft && !has_other) {
        say_unseen(out);
    } else if (worst == RULE_PASSES) {
        doctor_fine(out, "no rule of this host drops packets to or from %s",
                    d->address);
    }
}
