/** @file
 * What the texts of a rig may be. Internal to host. */
#ifndef LUM_HOST_RIG_TEXT_H
#define LUM_HOST_RIG_TEXT_H

#include <stddef.h>
#include <stdint.h>

/** Checks of a text of len bytes, which need not be terminated: NULL, or why it
 * is refused, as lum_key_rule_read() says it. */
const char *lum_rig_check_frame(const char *text, size_t len);
/** A sensor's name. */
const char *lum_rig_check_name(const char *text, size_t len);
/** An address, and after a '%' an interface. */
const char *lum_rig_check_address(const char *text, size_t len);
/** An interface. */
const char *lum_rig_check_interface(const char *text, size_t len);
/** A file's name. */
const char *lum_rig_check_path(const char *text, size_t len);
/** No text is a list. */
const char *lum_rig_check_list(const char *text, size_t len);

/** Take an address that was checked.
 * @return where its interface begins; text + len: it names none. */
const char *lum_rig_take_address(const char *text, size_t len, uint32_t *out);

#endif
