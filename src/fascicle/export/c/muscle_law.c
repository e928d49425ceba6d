int @name@_force(double pressure, double strain, double *force, double *by_pressure,
                 double *by_strain)
{
    double out[3] = {NAN, NAN, NAN};
    const double *arg[2] = {&pressure, &strain};
    double *res[6] = {&out[0], &out[1], &out[2], NULL, NULL, NULL};
    int inside = @name@_inside(pressure) && strain > @name@_lowest && strain <= @name@_largest;

    if (inside) @name@_law0(arg, res, NULL, NULL, 0);
    if (force) *force = out[0];
    if (by_pressure) *by_pressure = out[1];
    if (by_strain) *by_strain = out[2];
    return !inside;
}

static void @name@_kinks(double pressure, double out[3])
{
    double rest = 0.0;
    const double *arg[2] = {&pressure, &rest};
    double *res[6] = {NULL, NULL, NULL, &out[0], &out[1], &out[2]};

    out[0] = out[1] = out[2] = NAN;
    if (@name@_inside(pressure)) @name@_law0(arg, res, NULL, NULL, 0);
}

double @name@_free_strain(double pressure)
{
    double out[3];
    @name@_kinks(pressure, out);
    return out[0];
}

double @name@_collapse_strain(double pressure)
{
    double out[3];
    @name@_kinks(pressure, out);
    return out[2];
}
