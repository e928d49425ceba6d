/* @title@, as a table, written by fascicle @version@.
 * SI units. C99 and math.h; no memory is allocated.
 *
@errors@
 */
#ifndef @guard@_H
#define @guard@_H

#ifdef __cplusplus
extern "C" {
#endif
@functions@
#ifdef __cplusplus
}
#endif

#endif
