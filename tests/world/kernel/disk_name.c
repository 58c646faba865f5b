#define _GNU_SOURCE
#include "disk_internal.h"

#include "process.h"
#include "trace.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define LINKS_MAX    40
#define WATCHERS_MAX 8

static struct {
    void (*told)(const world_name_event *event, void *argument);
    void *argument;
} watchers[WATCHERS_MAX];
static unsigned watcher_count;

static char *copy_text(const char *text)
{
    char *copy = strdup(text);
    if (copy == NULL) {
        abort();
    }
    return copy;
}

/* --- A folder's names --- */

disk_name *disk_names_find(const disk_names *names, const char *name)
{
    for (unsigned i = 0; i < names->count; i++) {
        if (strcmp(names->list[i].text, name) == 0) {
            return &names->list[i];
        }
    }
    return NULL;
}

static void take_out(disk_names *names, disk_name *name)
{
    disk_inode *inode = name->inode;
    free(name->text);
    names->count--;
    for (disk_name *i = name; i < names->list + names->count; i++) {
        *i = i[1];
    }
    disk_inode_drop(inode);
}

static disk_name *append(disk_names *names)
{
    if (names->count == names->room) {
        names->room = names->room == 0 ? 8 : 2 * names->room;
        names->list = realloc(names->list, names->room * sizeof(disk_name));
        if (names->list == NULL) {
            abort();
        }
    }
    return &names->list[names->count++];
}

/* The inode of a name from now on; NULL: the name goes. */
void disk_names_set(disk_names *names, const char *name, disk_inode *inode)
{
    disk_name *entry = disk_names_find(names, name);
    if (inode == NULL) {
        if (entry != NULL) {
            take_out(names, entry);
        }
        return;
    }
    (void)disk_inode_use(inode);
    if (entry != NULL) {
        disk_inode_drop(entry->inode);
        entry->inode = inode;
    } else {
        *append(names) = (disk_name){copy_text(name), inode};
    }
}

void disk_names_clear(disk_names *names)
{
    while (names->count > 0) {
        take_out(names, &names->list[names->count - 1u]);
    }
    free(names->list);
    *names = (disk_names){NULL, 0, 0};
}

/* --- Paths --- */

/* What is left of a path, on the way. */
struct walk {
    world_disk *disk;
    char text[PATH_MAX];
    char *at;
    disk_inode *folder; /* held */
    unsigned links;
};

static bool is_virtual(const disk_inode *folder)
{
    return folder->magic != DISK_PLAIN;
}

disk_inode *disk_child(disk_inode *folder, const char *name)
{
    const disk_name *found = disk_names_find(&folder->names, name);
    if (strcmp(name, ".") == 0 || strcmp(name, "..") == 0) {
        return disk_inode_use(name[1] == '.' ? folder->parent : folder);
    }
    if (found != NULL) {
        return disk_inode_use(found->inode);
    }
    return is_virtual(folder) ? disk_proc_find(folder, name) : NULL;
}

static void go_to(struct walk *walk, disk_inode *folder)
{
    disk_inode_drop(walk->folder);
    walk->folder = folder;
}

/* Takes the next name. False: there is none. */
static bool next_name(struct walk *walk, char out[NAME_MAX + 1], int *code)
{
    walk->at += strspn(walk->at, "/");
    const size_t len = strcspn(walk->at, "/");
    if (len > NAME_MAX) {
        *code = ENAMETOOLONG;
        return false;
    }
    memcpy(out, walk->at, len);
    out[len] = '\0';
    walk->at += len;
    return len > 0;
}

/* The link's text takes its place before the rest of the path. */
static int follow(struct walk *walk, const disk_inode *link)
{
    char target[PATH_MAX];
    char text[2 * PATH_MAX];
    walk->links++;
    if (walk->links > LINKS_MAX) {
        return ELOOP;
    }
    if (link->target != NULL) {
        (void)snprintf(target, sizeof target, "%s", link->target);
    } else {
        disk_proc_target(link, target, sizeof target);
    }
    const int n = snprintf(text, sizeof text, "%s%s", target, walk->at);
    if (n >= PATH_MAX) {
        return ENAMETOOLONG;
    }
    memcpy(walk->text, text, (size_t)n + 1u);
    walk->at = walk->text;
    if (walk->text[0] == '/') {
        go_to(walk, disk_inode_use(walk->disk->root));
    }
    return 0;
}

/* What stands behind a name within a path: a folder, or a link to one. */
static int enter(struct walk *walk, disk_inode *inode)
{
    if (S_ISDIR(inode->mode)) {
        go_to(walk, inode);
        return 0;
    }
    const int code = S_ISLNK(inode->mode) ? follow(walk, inode) : ENOTDIR;
    disk_inode_drop(inode);
    return code;
}

/* Hands the folder over. */
static void arrive(struct walk *walk, const char *name, disk_inode *inode,
                   disk_place *out)
{
    const bool has_dots = strcmp(name, ".") == 0 || strcmp(name, "..") == 0;
    out->dots = has_dots ? (unsigned)strlen(name) : 0;
    out->has_slash = *walk->at == '/';
    out->folder = walk->folder;
    out->inode = inode;
    (void)snprintf(out->name, sizeof out->name, "%s", has_dots ? "" : name);
    walk->folder = NULL;
}

/* A link that is not a text but a file itself. */
static bool is_magic_link(const disk_inode *inode)
{
    return inode->magic == DISK_DESCRIPTOR;
}

/* One name further. 0: go on, or arrived (walk->folder is NULL). */
static int step(struct walk *walk, const char *name, enum disk_end end,
                disk_place *out)
{
    const int code = disk_may(walk->folder, X_OK);
    const bool is_last = walk->at[strspn(walk->at, "/")] == '\0';
    const bool wants_folder = *walk->at == '/';
    if (code != 0) {
        return code;
    }
    disk_inode *inode = disk_child(walk->folder, name);
    if (!is_last) {
        return inode != NULL ? enter(walk, inode) : ENOENT;
    }
    const bool follows =
        end == DISK_FOLLOWS || (end == DISK_STAYS && wants_folder);
    if (inode != NULL && S_ISLNK(inode->mode) && follows &&
        !is_magic_link(inode)) {
        return enter(walk, inode);
    }
    if (inode != NULL && wants_folder && end != DISK_NAMES &&
        !S_ISDIR(inode->mode)) {
        disk_inode_drop(inode);
        return ENOTDIR;
    }
    if (inode != NULL && strcmp(name, "..") == 0) {
        go_to(walk, disk_inode_use(inode));
    }
    arrive(walk, name, inode, out);
    return 0;
}

static int run_walk(struct walk *walk, enum disk_end end, disk_place *out)
{
    char name[NAME_MAX + 1];
    int code = 0;
    while (code == 0 && walk->folder != NULL) {
        if (!next_name(walk, name, &code)) {
            if (code == 0) {
                arrive(walk, "", disk_inode_use(walk->folder), out);
            }
            break;
        }
        code = step(walk, name, end, out);
    }
    if (walk->folder != NULL) {
        disk_inode_drop(walk->folder);
    }
    return code;
}

int disk_find(world_disk *disk, const char *directory, const char *path,
              enum disk_end end, disk_place *out)
{
    struct walk walk = {.disk = disk};
    const bool is_absolute = path[0] == '/';
    const int n =
        is_absolute
            ? snprintf(walk.text, sizeof walk.text, "%s", path)
            : snprintf(walk.text, sizeof walk.text, "%s/%s", directory, path);
    if (path[0] == '\0') {
        return ENOENT;
    }
    if (n >= PATH_MAX) {
        return ENAMETOOLONG;
    }
    walk.at = walk.text;
    walk.folder = disk_inode_use(disk->root);
    return run_walk(&walk, end, out);
}

void disk_place_drop(disk_place *place)
{
    disk_inode_drop(place->folder);
    if (place->inode != NULL) {
        disk_inode_drop(place->inode);
    }
}

static const char *name_of(const disk_inode *folder)
{
    const disk_names *names = &folder->parent->names;
    for (unsigned i = 0; i < names->count; i++) {
        if (names->list[i].inode == folder) {
            return names->list[i].text;
        }
    }
    return "?"; /* it was removed */
}

void disk_path_of(const disk_inode *folder, const char *name,
                  char out[PATH_MAX])
{
    char path[PATH_MAX];
    char rest[PATH_MAX];
    (void)snprintf(path, sizeof path, "%s%s", name[0] != '\0' ? "/" : "", name);
    for (const disk_inode *i = folder; i->parent != i; i = i->parent) {
        (void)snprintf(rest, sizeof rest, "%s", path);
        (void)snprintf(path, sizeof path, "/%s%.*s", name_of(i),
                       PATH_MAX - NAME_MAX - 2, rest);
    }
    (void)snprintf(out, PATH_MAX, "%s", path[0] != '\0' ? path : "/");
}

/* --- Who watches --- */

void world_disk_watch(void (*told)(const world_name_event *event,
                                   void *argument),
                      void *argument)
{
    if (watcher_count == WATCHERS_MAX) {
        world_fail("more than %d watch the names of disks", WATCHERS_MAX);
        return;
    }
    watchers[watcher_count].told = told;
    watchers[watcher_count].argument = argument;
    watcher_count++;
}

void disk_forget_watchers(void)
{
    watcher_count = 0;
}

static void tell(world_name_change change, const disk_inode *folder,
                 const char *name, const char *from, const disk_inode *inode)
{
    static const char *const words[] = {"made", "named", "removed", "lost"};
    const world_process *process = world_process_self();
    char path[PATH_MAX];
    disk_path_of(folder, name, path);
    if (strncmp(path, "/proc", 5) != 0) {
        WORLD_TRACE("%s is %s%s%s, %lld bytes%s", path, words[change],
                    from != NULL ? ", before " : "", from != NULL ? from : "",
                    (long long)inode->size,
                    disk_is_synced(inode) ? "" : ", not synced");
    }
    if (!S_ISREG(inode->mode)) {
        return;
    }
    const world_name_event event = {
        .change = change,
        .disk = inode->disk,
        .pid = process != NULL ? process->pid : 0,
        .path = path,
        .from = from,
        .inode = inode->number,
        .size = inode->size,
        .is_synced = disk_is_synced(inode),
    };
    for (unsigned i = 0; i < watcher_count; i++) {
        watchers[i].told(&event, watchers[i].argument);
    }
}

/* --- Names that change --- */

/* Each part holds its folder and its inode. */
static struct disk_change_part part(disk_inode *folder, const char *name,
                                    disk_inode *inode)
{
    return (struct disk_change_part){disk_inode_use(folder), copy_text(name),
                                     inode != NULL ? disk_inode_use(inode)
                                                   : NULL};
}

static disk_change *note(world_disk *disk)
{
    disk_change *change = calloc(1, sizeof *change);
    if (change == NULL) {
        abort();
    }
    *disk->last_change = change;
    disk->last_change = &change->next;
    return change;
}

static void free_change(disk_change *change)
{
    for (unsigned i = 0; i < 2; i++) {
        struct disk_change_part *p = &change->part[i];
        if (p->folder != NULL) {
            disk_inode_drop(p->folder);
            free(p->name);
        }
        if (p->inode != NULL) {
            disk_inode_drop(p->inode);
        }
    }
    free(change);
}

static void set_name(disk_inode *folder, const char *name, disk_inode *inode)
{
    const disk_name *old = disk_names_find(&folder->names, name);
    if (old != NULL) {
        old->inode->links--;
        if (inode == NULL) {
            disk_touch(old->inode);
        }
        disk_settle_room(old->inode);
    }
    if (inode != NULL) {
        inode->links++;
        disk_settle_room(inode);
        if (S_ISDIR(inode->mode)) {
            inode->parent = folder;
        }
    }
    disk_names_set(&folder->names, name, inode);
    disk_touch(folder);
}

void disk_add_name(disk_inode *folder, const char *name, disk_inode *inode)
{
    set_name(folder, name, inode);
    note(folder->disk)->part[0] = part(folder, name, inode);
    tell(WORLD_NAME_MADE, folder, name, NULL, inode);
}

void disk_link_name(disk_inode *folder, const char *name, disk_inode *inode,
                    const char *old_path)
{
    set_name(folder, name, inode);
    note(folder->disk)->part[0] = part(folder, name, inode);
    tell(WORLD_NAME_GIVEN, folder, name, old_path, inode);
}

void disk_remove_name(disk_inode *folder, const char *name)
{
    disk_inode *inode =
        disk_inode_use(disk_names_find(&folder->names, name)->inode);
    note(folder->disk)->part[0] = part(folder, name, NULL);
    set_name(folder, name, NULL);
    tell(WORLD_NAME_REMOVED, folder, name, NULL, inode);
    disk_inode_drop(inode);
}

void disk_move_name(disk_inode *from, const char *name, disk_inode *to,
                    const char *new_name)
{
    char old_path[PATH_MAX];
    disk_inode *inode =
        disk_inode_use(disk_names_find(&from->names, name)->inode);
    disk_change *change = note(from->disk);
    disk_path_of(from, name, old_path);
    change->part[0] = part(from, name, NULL);
    change->part[1] = part(to, new_name, inode);
    set_name(from, name, NULL);
    set_name(to, new_name, inode);
    tell(WORLD_NAME_GIVEN, to, new_name, old_path, inode);
    disk_inode_drop(inode);
}

/* --- To the disk, and back --- */

static bool concerns(const disk_change *change, const disk_inode *folder)
{
    return folder == NULL || change->part[0].folder == folder ||
           change->part[1].folder == folder;
}

static void make_durable(disk_change *change)
{
    for (unsigned i = 0; i < 2; i++) {
        const struct disk_change_part *p = &change->part[i];
        if (p->folder != NULL) {
            disk_names_set(&p->folder->durable_names, p->name, p->inode);
        }
    }
    free_change(change);
}

void disk_sync_names(world_disk *disk, const disk_inode *folder)
{
    disk_change **at = &disk->changes;
    while (*at != NULL) {
        disk_change *change = *at;
        if (concerns(change, folder)) {
            *at = change->next;
            make_durable(change);
        } else {
            at = &change->next;
        }
    }
    disk->last_change = at;
}

void disk_forget_changes(world_disk *disk)
{
    while (disk->changes != NULL) {
        disk_change *change = disk->changes;
        disk->changes = change->next;
        free_change(change);
    }
    disk->last_change = &disk->changes;
}

/* What processes saw in a folder gives way to what is on the disk. */
static void revert_folder(disk_inode *folder)
{
    for (unsigned i = 0; i < folder->names.count; i++) {
        const disk_name *name = &folder->names.list[i];
        const disk_name *kept =
            disk_names_find(&folder->durable_names, name->text);
        name->inode->links--;
        if (kept == NULL || kept->inode != name->inode) {
            tell(WORLD_NAME_LOST, folder, name->text, NULL, name->inode);
        }
    }
    disk_names_clear(&folder->names);
    for (unsigned i = 0; i < folder->durable_names.count; i++) {
        const disk_name *name = &folder->durable_names.list[i];
        disk_names_set(&folder->names, name->text, name->inode);
        name->inode->links++;
        if (S_ISDIR(name->inode->mode)) {
            name->inode->parent = folder;
        }
    }
}

struct held {
    disk_inode *folder;
};

/* Held all the while: a folder that goes takes others with it. */
static struct held *hold_folders(const world_disk *disk, size_t *count)
{
    size_t n = 0;
    for (const disk_inode *i = disk->inodes; i != NULL; i = i->next) {
        n += S_ISDIR(i->mode) ? 1u : 0u;
    }
    struct held *folders = calloc(n + 1u, sizeof *folders);
    if (folders == NULL) {
        abort();
    }
    n = 0;
    for (disk_inode *i = disk->inodes; i != NULL; i = i->next) {
        if (S_ISDIR(i->mode)) {
            folders[n++].folder = disk_inode_use(i);
        }
    }
    *count = n;
    return folders;
}

void disk_revert_names(world_disk *disk, double kept)
{
    size_t count = 0;
    while (disk->changes != NULL && kept > 0 &&
           world_random_chance(&disk->fault.random, kept)) {
        disk_change *change = disk->changes;
        disk->changes = change->next;
        make_durable(change);
    }
    if (disk->changes == NULL) {
        disk->last_change = &disk->changes;
    }
    struct held *folders = hold_folders(disk, &count);
    for (size_t i = 0; i < count; i++) {
        if (folders[i].folder->magic == DISK_PLAIN) {
            revert_folder(folders[i].folder);
        }
    }
    for (disk_inode *i = disk->inodes; i != NULL; i = i->next) {
        disk_settle_room(i);
    }
    disk_forget_changes(disk);
    for (size_t i = 0; i < count; i++) {
        disk_inode_drop(folders[i].folder);
    }
    free(folders);
}
