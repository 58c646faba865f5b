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

#endif
