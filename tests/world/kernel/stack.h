/* Stacks of tasks, and the change from one to another. */
#ifndef WORLD_STACK_H
#define WORLD_STACK_H

typedef struct world_stack world_stack;

/* Each runs `run` on a stack of its own, from its first turn on. What it holds
 * before comes from the seed and the number of its task. */
world_stack *world_stack_new(void (*run)(void), unsigned task);
/* Not the one that is in use. */
void world_stack_free(world_stack *stack);

/* The scheduler gives a turn to a stack; returns when that gives it back. */
void world_stack_turn(world_stack *stack);
/* The stack gives it back; returns at its next turn. */
void world_stack_rest(world_stack *stack);
/* The same for the last time. */
__attribute__((noreturn)) void world_stack_end(world_stack *stack);

#endif
