/* A lock for a few assignments at a time. */
#ifndef LUM_FRAME_LOCK_H
#define LUM_FRAME_LOCK_H

typedef struct lum_lock lum_lock;

/* NULL without memory. */
lum_lock *lum_lock_new(void);

/* Nobody holds it. NULL is allowed. */
void lum_lock_free(lum_lock *lock);

void lum_lock_take(lum_lock *lock);
void lum_lock_leave(lum_lock *lock);

#endif
