#define @guard@_UNITS 1

/* Force [N] and its slopes, by pressure [N/Pa] and by strain [N]; any of the three may be NULL. */
int @name@_force(double pressure, double strain, double *force, double *by_pressure,
                 double *by_strain);

/* Strain of zero force. */
double @name@_free_strain(double pressure);

/* Strain at which the buckled bladder collapses, INFINITY where it never does. */
double @name@_collapse_strain(double pressure);
