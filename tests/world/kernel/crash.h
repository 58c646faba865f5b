/* What kills a tool on a real machine kills the program of the world. It then
 * says on standard error when that was, in which process, and under which seed.
 */
#ifndef WORLD_CRASH_H
#define WORLD_CRASH_H

/* Once, by main(). */
void world_crash_tell(void);

#endif
