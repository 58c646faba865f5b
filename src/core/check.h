/* Assertions about what a function of the core relies on. They are active if
 * LUM_CHECKED is defined, as in tests and fuzzers, and empty otherwise. Never
 * for values of a caller or a packet: these are checked, and refused by a
 * result. */
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
