/* Fifos as the disk opens them. */
#ifndef WORLD_PIPE_INTERNAL_H
#define WORLD_PIPE_INTERNAL_H

#include "disk_internal.h"

struct pipe_body;

/* As open() of a fifo: it waits for the other side unless flags have
 * O_NONBLOCK, or no process asks. NULL and errno. */
world_file *pipe_open_fifo(disk_inode *inode, int flags);
/* The fifo of a file; NULL: it is none. */
disk_inode *pipe_inode(const world_file *file);
/* NULL is allowed. */
void pipe_body_free(struct pipe_body *body);

#endif
