#define _GNU_SOURCE
#include "disk.h"

#include "disk_internal.h"
#include "pipe_internal.h"
#include "time.h"
#include "trace.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define EVERYONE 0777u

static world_disk *disks;

static void *must(void *memory)
{
    if (memory == NULL) {
        abort();
    }
    return memory;
}

/* --- Inodes --- */

disk_inode *disk_inode_new(world_disk *disk, mode_t mode, uid_t uid)
{
    disk_inode *inode = must(calloc(1, sizeof *inode));
    inode->disk = disk;
    inode->number = ++disk->numbers;
    inode->refs = 1;
    inode->mode = mode;
    inode->uid = uid;
    inode->parent = inode;
    inode->next = disk->inodes;
    disk->inodes = inode;
    disk_touch(inode);
    return inode;
}

disk_inode *disk_inode_use(disk_inode *inode)
{
    inode->refs++;
    return inode;
}

void disk_touch(disk_inode *inode)
{
    inode->changed_ns = world_host_utc_ns(inode->disk->host);
}

/* What a cut or the user brings back may need more than there is. */
static void take_room(uint64_t *room, uint64_t bytes)
{
    *room -= bytes < *room ? bytes : *room;
}

void disk_settle_room(disk_inode *inode)
{
    const bool has_no_room = inode->links == 0 && inode->opens == 0;
    uint64_t *room = &inode->disk->fault.room;
    if (has_no_room && !inode->has_no_room) {
        *room += (uint64_t)inode->size;
    } else if (!has_no_room && inode->has_no_room) {
        take_room(room, (uint64_t)inode->size);
    }
    inode->has_no_room = has_no_room;
}

static void free_page(disk_page *page)
{
    if (page->durable != page->now) {
        free(page->durable);
    }
    free(page->now);
    *page = (disk_page){NULL, NULL, false};
}

static void free_content(disk_inode *inode)
{
    for (size_t i = 0; i < inode->page_room; i++) {
        free_page(&inode->pages[i]);
    }
    free(inode->pages);
    free(inode->target);
    pipe_body_free(inode->pipe);
}

/* Of a folder, its names hold others. */
static void free_inode(disk_inode *inode)
{
    disk_inode **at = &inode->disk->inodes;
    while (*at != inode) {
        at = &(*at)->next;
    }
    *at = inode->next;
    disk_names_clear(&inode->names);
    disk_names_clear(&inode->durable_names);
    free_content(inode);
    free(inode);
}

void disk_inode_drop(disk_inode *inode)
{
    inode->refs--;
    if (inode->refs == 0) {
        free_inode(inode);
    }
}

int disk_may(const disk_inode *inode, int rights)
{
    const unsigned bits = (unsigned)inode->mode;
    const unsigned has = inode->uid == WORLD_UID ? bits >> 6u & 7u : bits & 7u;
    return ((unsigned)rights & ~has) == 0 ? 0 : EACCES;
}

/* --- Bytes --- */

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

size_t disk_read_at(const disk_inode *inode, void *out, size_t size, int64_t at)
{
    uint8_t *to = out;
    if (at >= inode->size) {
        return 0;
    }
    const size_t whole = least(size, (size_t)(inode->size - at));
    for (size_t left = whole; left > 0;) {
        const size_t number = (size_t)at / DISK_PAGE;
        const size_t from = (size_t)at % DISK_PAGE;
        const size_t n = least(left, DISK_PAGE - from);
        const uint8_t *page =
            number < inode->page_room ? inode->pages[number].now : NULL;
        if (page != NULL) {
            memcpy(to, page + from, n);
        } else {
            memset(to, 0, n);
        }
        to += n;
        at += (int64_t)n;
        left -= n;
    }
    return whole;
}

/* A page whose present bytes can be changed. */
static disk_page *dirty_page(disk_inode *inode, size_t number)
{
    if (number >= inode->page_room) {
        size_t room = inode->page_room == 0 ? 4 : inode->page_room;
        while (room <= number) {
            room *= 2;
        }
        inode->pages = must(realloc(inode->pages, room * sizeof(disk_page)));
        memset(inode->pages + inode->page_room, 0,
               (room - inode->page_room) * sizeof(disk_page));
        inode->page_room = room;
    }
    disk_page *page = &inode->pages[number];
    if (page->now == NULL) {
        page->now = must(calloc(1, DISK_PAGE));
    } else if (page->now == page->durable) {
        page->now = memcpy(must(malloc(DISK_PAGE)), page->durable, DISK_PAGE);
    }
    page->is_lost = false;
    return page;
}

/* A recording that nobody ends must not take the memory of the machine. */
#define FILE_MOST ((int64_t)2 << 30)

/* How far a file may grow; what it has is its own. */
static int64_t grow(disk_inode *inode, int64_t wanted)
{
    struct disk_fault *fault = &inode->disk->fault;
    const uint64_t more =
        wanted > inode->size ? (uint64_t)(wanted - inode->size) : 0;
    if (fault->is_limited && more > fault->room) {
        wanted = inode->size + (int64_t)fault->room;
        world_met("fault:disk-full");
        WORLD_TRACE("the disk is full");
    }
    if (wanted > FILE_MOST) {
        world_fail("a file of more than 2 GiB: what should have ended it?");
    }
    if (wanted > inode->size) {
        take_room(&fault->room, (uint64_t)(wanted - inode->size));
        inode->size = wanted;
    }
    return wanted;
}

size_t disk_write_at(disk_inode *inode, const void *bytes, size_t size,
                     int64_t at)
{
    const uint8_t *from = bytes;
    if (size == 0) {
        return 0;
    }
    const int64_t end = grow(inode, at + (int64_t)size);
    const size_t whole = end > at ? least(size, (size_t)(end - at)) : 0;
    for (size_t left = whole; left > 0;) {
        const size_t into = (size_t)at % DISK_PAGE;
        const size_t n = least(left, DISK_PAGE - into);
        disk_page *page = dirty_page(inode, (size_t)at / DISK_PAGE);
        memcpy(page->now + into, from, n);
        from += n;
        at += (int64_t)n;
        left -= n;
    }
    disk_touch(inode);
    return whole;
}

/* Of pages behind a new end nothing is left; the last one ends in zeros. */
static void cut_pages(disk_inode *inode, int64_t size)
{
    const size_t kept = ((size_t)size + DISK_PAGE - 1u) / DISK_PAGE;
    for (size_t i = kept; i < inode->page_room; i++) {
        disk_page *page = &inode->pages[i];
        if (page->now != page->durable) {
            free(page->now);
        }
        page->now = NULL;
    }
    if (size % DISK_PAGE != 0 && kept <= inode->page_room &&
        inode->pages[kept - 1u].now != NULL) {
        const size_t used = (size_t)size % DISK_PAGE;
        memset(dirty_page(inode, kept - 1u)->now + used, 0, DISK_PAGE - used);
    }
}

int disk_set_size(disk_inode *inode, int64_t size)
{
    if (size < inode->size) {
        cut_pages(inode, size);
        inode->disk->fault.room += (uint64_t)(inode->size - size);
        inode->size = size;
    } else if (grow(inode, size) < size) {
        return ENOSPC;
    }
    disk_touch(inode);
    return 0;
}

static void make_durable(disk_page *page)
{
    if (page->durable != page->now) {
        free(page->durable);
        page->durable = page->now;
    }
}

void disk_sync_bytes(disk_inode *inode)
{
    for (size_t i = 0; i < inode->page_room; i++) {
        if (!inode->pages[i].is_lost) {
            make_durable(&inode->pages[i]);
        }
    }
    inode->durable_size = inode->size;
}

/* As Linux does, the pages count as written from then on. */
void disk_lose_bytes(disk_inode *inode)
{
    for (size_t i = 0; i < inode->page_room; i++) {
        inode->pages[i].is_lost =
            inode->pages[i].now != inode->pages[i].durable;
    }
}

bool disk_is_synced(const disk_inode *inode)
{
    for (size_t i = 0; i < inode->page_room; i++) {
        if (inode->pages[i].now != inode->pages[i].durable) {
            return false;
        }
    }
    return inode->durable_size == inode->size;
}

/* Whether the disk got a page by itself. What was appended comes there in its
 * order: `appends` is false from the first page on that did not. */
static bool is_kept(disk_inode *inode, size_t i, double kept, bool *appends)
{
    const disk_page *page = &inode->pages[i];
    const bool is_appended =
        (int64_t)(i + 1u) * DISK_PAGE > inode->durable_size;
    const bool result = page->now != NULL && !page->is_lost && kept > 0 &&
                        world_random_chance(&inode->disk->fault.random, kept);
    *appends = *appends && (result || !is_appended);
    return result && (*appends || !is_appended);
}

void disk_revert_bytes(disk_inode *inode, double kept)
{
    int64_t size = inode->durable_size;
    bool appends = true;
    for (size_t i = 0; i < inode->page_room; i++) {
        disk_page *page = &inode->pages[i];
        if (page->now == page->durable) {
            continue;
        }
        if (is_kept(inode, i, kept, &appends)) {
            const int64_t end = (int64_t)(i + 1u) * DISK_PAGE;
            make_durable(page);
            size = end < inode->size ? (end > size ? end : size) : inode->size;
        } else {
            free(page->now);
            page->now = page->durable;
        }
        page->is_lost = false;
    }
    if (!inode->has_no_room) {
        inode->disk->fault.room += (uint64_t)inode->size;
        take_room(&inode->disk->fault.room, (uint64_t)size);
    }
    inode->size = size;
    inode->durable_size = size;
}

/* --- A disk --- */

/* A name that is there from the beginning. */
static disk_inode *plant(disk_inode *folder, const char *name, mode_t mode,
                         enum disk_magic magic)
{
    const uid_t root = 0;
    disk_inode *inode = disk_inode_new(folder->disk, mode, root);
    inode->magic = magic;
    inode->links = 1;
    inode->parent = folder;
    disk_names_set(&folder->names, name, inode);
    disk_names_set(&folder->durable_names, name, inode);
    disk_inode_drop(inode);
    return inode;
}

static void plant_link(disk_inode *folder, const char *name, const char *target)
{
    disk_inode *link = plant(folder, name, S_IFLNK | EVERYONE, DISK_PLAIN);
    link->target = must(strdup(target));
}

static void plant_all(world_disk *disk)
{
    const mode_t folder = S_IFDIR | 0755u;
    disk_inode *dev = plant(disk->root, "dev", folder, DISK_PLAIN);
    (void)plant(dev, "null", S_IFCHR | 0666u, DISK_NULL);
    (void)plant(dev, "full", S_IFCHR | 0666u, DISK_FULL);
    plant_link(dev, "fd", "/proc/self/fd");
    plant_link(dev, "stdin", "/proc/self/fd/0");
    plant_link(dev, "stdout", "/proc/self/fd/1");
    plant_link(dev, "stderr", "/proc/self/fd/2");
    disk->proc = plant(disk->root, "proc", S_IFDIR | 0555u, DISK_PROC);
    plant(disk->root, "home", folder, DISK_PLAIN)->uid = WORLD_UID;
    (void)plant(disk->root, "tmp", S_IFDIR | S_ISVTX | EVERYONE, DISK_PLAIN);
}

static world_disk *new_disk(world_host *host)
{
    world_disk *disk = must(calloc(1, sizeof *disk));
    char name[64];
    disk->host = host;
    disk->last_change = &disk->changes;
    (void)snprintf(name, sizeof name, "names:%s", host->name);
    disk->random = world_stream(name, 0);
    disk_fault_begin(disk);
    disk->root = disk_inode_new(disk, S_IFDIR | 0755u, 0);
    disk->root->links = 1;
    plant_all(disk);
    disk->next = disks;
    disks = disk;
    return disk;
}

world_disk *world_disk_of(world_host *host)
{
    if (host->disk == NULL) {
        host->disk = new_disk(host);
    }
    return host->disk;
}

static void free_disk(world_disk *disk)
{
    disk_forget_changes(disk);
    while (disk->inodes != NULL) {
        disk_inode *inode = disk->inodes;
        disk->inodes = inode->next;
        for (unsigned i = 0; i < inode->names.count; i++) {
            free(inode->names.list[i].text);
        }
        for (unsigned i = 0; i < inode->durable_names.count; i++) {
            free(inode->durable_names.list[i].text);
        }
        free(inode->names.list);
        free(inode->durable_names.list);
        free_content(inode);
        free(inode);
    }
    disk->host->disk = NULL;
    free(disk);
}

void world_disk_reset(void)
{
    while (disks != NULL) {
        world_disk *next = disks->next;
        free_disk(disks);
        disks = next;
    }
    disk_forget_watchers();
}
