#define CELLS 8

static void @name@_unit(int unit, double pressure, double strain, double out[3])
{
    double unit_strain = 1.0 - ratio_of[unit] * (1.0 - strain);
    double *res[6] = {&out[0], &out[1], &out[2], NULL, NULL, NULL};

    @name@_kind(kind_of[unit], pressure, unit_strain, res);
    out[0] *= count_of[unit];
    out[1] *= count_of[unit];
    out[2] *= count_of[unit] * ratio_of[unit];
}

static void @name@_kinks(int unit, double pressure, double out[3])
{
    double *res[6] = {NULL, NULL, NULL, &out[0], &out[1], &out[2]};
    int i;

    @name@_kind(kind_of[unit], pressure, 0.0, res);
    for (i = 0; i < 3; i++) out[i] = 1.0 - (1.0 - out[i]) / ratio_of[unit];
}

static double @name@_sum(const double pressure[UNITS], double strain, double *slope)
{
    double force = 0.0, out[3];
    int unit;

    *slope = 0.0;
    for (unit = 0; unit < UNITS; unit++) {
        @name@_unit(unit, pressure[unit], strain, out);
        force += out[0];
        *slope += out[2];
    }
    return force;
}

int @name@_force(const double pressure[UNITS], double strain, double *force,
                 double by_pressure[UNITS], double *by_strain)
{
    double total = 0.0, slope = 0.0, out[3];
    int unit, inside = strain > @name@_lowest && strain <= @name@_largest;

    for (unit = 0; unit < UNITS; unit++) inside = inside && @name@_inside(pressure[unit]);
    for (unit = 0; unit < UNITS; unit++) {
        out[0] = out[1] = out[2] = NAN;
        if (inside) @name@_unit(unit, pressure[unit], strain, out);
        total += out[0];
        slope += out[2];
        if (by_pressure) by_pressure[unit] = out[1];
    }
    if (force) *force = total;
    if (by_strain) *by_strain = slope;
    return !inside;
}

/* where in (0, 1) the cubic of these values and slopes turns; the middle if nowhere */
static double turn(double left, double right, double left_slope, double right_slope)
{
    double c3 = 2.0 * (left - right) + left_slope + right_slope;
    double c2 = 3.0 * (right - left) - 2.0 * left_slope - right_slope;
    double inside = c2 * c2 - 3.0 * c3 * left_slope, q, t;

    inside = inside > 0.0 ? sqrt(inside) : 0.0;
    q = -(c2 + (c2 < 0.0 ? -inside : inside));
    t = c3 == 0.0 ? -1.0 : q / (3.0 * c3);
    if (!(t > 0.0 && t < 1.0)) t = q == 0.0 ? -1.0 : left_slope / q;
    return t > 0.0 && t < 1.0 ? t : 0.5;
}

/* the zero between a strain at which the bundle pulls and one at which it doesn't */
static double @name@_between(const double pressure[UNITS], double a, double b)
{
    double x = 0.5 * (a + b), last = b - a, f, slope, next;
    int i;

    for (i = 0; i < 100; i++) {
        f = @name@_sum(pressure, x, &slope);
        if (f == 0.0) return x;
        if (f > 0.0) a = x; else b = x;
        next = slope < 0.0 ? x - f / slope : b + 1.0;
        if (!(next >= a && next <= b && fabs(next - x) < 0.5 * last)) next = 0.5 * (a + b);
        last = fabs(next - x);
        x = next;
        if (last <= 4e-16) break;
    }
    return x;
}

double @name@_free_strain(const double pressure[UNITS])
{
    double ends[3 * UNITS + 1], out[3], low = INFINITY, high = -INFINITY, top = @name@_largest;
    double a, b, x, next, f, g, h, slope, next_slope, step, middle;
    int unit, i, j, n = 0;

    for (unit = 0; unit < UNITS; unit++) {
        if (!@name@_inside(pressure[unit])) return NAN;
        @name@_kinks(unit, pressure[unit], out);
        if (out[0] < low) low = out[0];
        if (out[0] > high) high = out[0];
        for (i = 0; i < 3; i++) ends[n++] = out[i];
    }
    if (high > top) top = high;
    if (high - low <= 1e-13) return low;
    ends[n++] = top;
    for (i = 0; i < n; i++) {
        x = ends[i] < low ? low : ends[i] > top ? top : ends[i];
        for (j = i; j > 0 && ends[j - 1] > x; j--) ends[j] = ends[j - 1];
        ends[j] = x;
    }
    /* from kink to kink, in cells that are cut at their turning point; before `low` all pull */
    for (i = 0; i + 1 < n; i++) {
        a = ends[i];
        b = ends[i + 1];
        if (b - a <= 1e-13) continue;
        step = (b - a) / CELLS;
        x = a;
        f = @name@_sum(pressure, a, &slope);
        @name@_sum(pressure, a + 1e-7 * step, &slope);
        if (!(f > 0.0) && a > low) return a;
        for (j = 0; j < CELLS; j++) {
            next = j + 1 < CELLS ? a + (j + 1) * step : b;
            g = @name@_sum(pressure, next, &next_slope);
            if (j + 1 == CELLS) @name@_sum(pressure, b - 1e-7 * step, &next_slope);
            middle = x + step * turn(f, g, slope * step, next_slope * step);
            h = @name@_sum(pressure, middle, &slope);
            if (!(h > 0.0)) return @name@_between(pressure, x, middle);
            if (!(g > 0.0)) return @name@_between(pressure, middle, next);
            x = next;
            f = g;
            slope = next_slope;
        }
    }
    return INFINITY;
}
