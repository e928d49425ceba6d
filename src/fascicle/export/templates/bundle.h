
#define @guard@_UNITS @units@

/* Pressures of the motor units in Pa (gauge), @lowest_pressure@ to @highest@; strain is the
 * contraction of the plates' distance over that at rest, @low@ to @high@; force in N, positive
 * where the ends are pulled together; volume in m3 of all muscles of a unit, the one on which
 * pressure does the work that the force takes. */

/* Force [N] and its slopes, by each unit's pressure [N/Pa] and by strain [N]; any of the three may
 * be NULL. Returns 1 outside of the table, with NAN; else 0. */
int @name@_force(const @real@ pressure[@guard@_UNITS], @real@ strain, @real@ *force,
                 @real@ by_pressure[@guard@_UNITS], @real@ *by_strain);

/* Each unit's volume [m3]. Returns 1 outside of the table, with NAN; else 0. */
int @name@_volume(const @real@ pressure[@guard@_UNITS], @real@ strain,
                  @real@ volume[@guard@_UNITS]);
@inverse@@controller@
