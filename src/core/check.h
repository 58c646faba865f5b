/* What a function of the core relies on: checked where LUM_CHECKED is defined,
 * as tests and fuzzers have it, and nothing at all elsewhere. Never of what a
 * caller or a packet says, which is judged and answered. */
#ifndef LUM_CORE_CHECK_H
#define LUM_CORE_CHECK_H

#ifdef LUM_CHECKED
#define LUM_CHECK(fact) ((fact) ? (void)0 : __builtin_trap())
#else
#define LUM_CHECK(fact) ((void)0)
#endif

/* The same of what the compiler knows: where it is not so, nothing is built.
 * The name says why it has to be. */
#define LUM_CHECK_BUILD(name, fact)                                            \
    enum {                                                                     \
        name = 1 / ((fact) ? 1 : 0)                                            \
    }

#endif
