#define @guard@_UNITS @units@

/* Force [N] and its slopes, by each unit's pressure [N/Pa] and by strain [N]; any of the three
 * may be NULL. */
int @name@_force(const double pressure[@guard@_UNITS], double strain, double *force,
                 double by_pressure[@guard@_UNITS], double *by_strain);

/* Smallest strain of zero force, INFINITY where there is none. */
double @name@_free_strain(const double pressure[@guard@_UNITS]);
