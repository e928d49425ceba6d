/* @title@, written by fascicle @version@.
 *
 * SI units: pressure in Pa (gauge), 0 to @top@; strain is contraction over length at rest,
 * @low@ (fibers straight) to @high@; force in N, positive where the ends are pulled
 * together. C99 and math.h, no memory is allocated; the stack holds @stack@ kB at most.
 *
 * Outside of these limits functions return 1 or NAN and results are NAN; inside, 0.
 */
#ifndef @guard@_H
#define @guard@_H

#ifdef __cplusplus
extern "C" {
#endif

@declarations@@inverse@
#ifdef __cplusplus
}
#endif

#endif
