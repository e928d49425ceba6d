#include "@name@.h"

#include <math.h>
#include <stddef.h>

#define UNITS @units@
#define KINDS @kinds@ /* of muscles that are unlike */
#define LINES @lines@ /* cells in pressure */
#define COLUMNS @columns@ /* cells in strain */

typedef @real@ real;

/* at each node the co-energy [J] and its slopes: by strain, for a cell [J], by pressure [m3], and
 * by both, for a cell [m3] */
static const real nodes[KINDS][LINES + 1][COLUMNS + 1][4] = {
@nodes@
};
static const real root_step[KINDS] = {@root_steps@}; /* [Pa^(1/2)] */
static const real top[KINDS] = {@tops@};             /* [Pa] */
static const real low[KINDS] = {@lows@};
static const real high[KINDS] = {@highs@};
static const real cell[KINDS] = {@cells@};
static const real length[KINDS] = {@lengths@}; /* [m] */

static const int kind_of[UNITS] = {@kind_of@};
static const real count_of[UNITS] = {@counts@};
static const real ratio_of[UNITS] = {@ratios@}; /* distance of the plates over its length */

/* one muscle: force [N], volume [m3], force by strain [N] and by pressure [m2], volume by pressure
 * [m3/Pa] */
typedef struct {
    real force, volume, by_strain, by_pressure, growth;
} point;

/* linear past the ends of the table */
static point muscle_at(int kind, real pressure, real strain)
{
    const real h = root_step[kind], line = h * h, step = cell[kind], L0 = length[kind];
    const real P = pressure > 0 ? pressure < top[kind] ? pressure : top[kind] : 0;
    const real eps = strain > low[kind] ? strain < high[kind] ? strain : high[kind] : low[kind];
    const real s = @sqrt@(P > line ? P : line), x = (eps - low[kind]) / step;
    int i = P > line ? (int)(s / h) : 0, j = (int)x, k;
    real u, w, by_P, side[2], value[2], slope[2], bend[2], value_P[2], slope_P[2], bend_P[2];
    real force, volume, by_both;
    point found;

    if (i > LINES - 1) i = LINES - 1;
    if (j > COLUMNS - 1) j = COLUMNS - 1;
    /* the first cell is even in P, the others are in its root */
    u = i ? s / h - (real)i : P / line;
    by_P = 1 / (i ? 2 * s * h : line);
    side[0] = i ? 2 * (real)i * line : line;
    side[1] = i ? 2 * (real)(i + 1) * line : line;
    w = x - (real)j;
    {
        /* Hermite's cubics of w, their slopes and bends */
        const real v = 1 - w, a = w * w * (3 - 2 * w), b = w * v * v, c = -w * w * v;
        const real da = 6 * w * v, db = v * (1 - 3 * w), dc = w * (3 * w - 2);
        const real dda = 6 - 12 * w, ddb = 6 * w - 4, ddc = 6 * w - 2;

        for (k = 0; k < 2; k++) {
            const real *m = nodes[kind][i + k][j], *n = nodes[kind][i + k][j + 1];
            const real rise = n[0] - m[0], rise_P = n[2] - m[2];

            value[k] = m[0] + a * rise + b * m[1] + c * n[1];
            slope[k] = da * rise + db * m[1] + dc * n[1];
            bend[k] = dda * rise + ddb * m[1] + ddc * n[1];
            value_P[k] = side[k] * (m[2] + a * rise_P + b * m[3] + c * n[3]);
            slope_P[k] = side[k] * (da * rise_P + db * m[3] + dc * n[3]);
            bend_P[k] = side[k] * (dda * rise_P + ddb * m[3] + ddc * n[3]);
        }
    }
    {
        /* and of u */
        const real v = 1 - u, a = u * u * (3 - 2 * u), b = u * v * v, c = -u * u * v;
        const real da = 6 * u * v, db = v * (1 - 3 * u), dc = u * (3 * u - 2);
        const real turned = slope[1] - slope[0];

        force = slope[0] + a * turned + b * slope_P[0] + c * slope_P[1];
        volume = by_P * (da * (value[1] - value[0]) + db * value_P[0] + dc * value_P[1]);
        by_both = by_P * (da * turned + db * slope_P[0] + dc * slope_P[1]);
        found.growth = by_P * by_P * ((6 - 12 * u) * (value[1] - value[0])
                                      + (6 * u - 4) * value_P[0] + (6 * u - 2) * value_P[1]);
        if (i) found.growth -= volume / (2 * P);
        found.by_strain = bend[0] + a * (bend[1] - bend[0]) + b * bend_P[0] + c * bend_P[1];
    }
    found.force = (force + by_both * (pressure - P)) / (step * L0);
    found.volume = volume + by_both * (strain - eps) / step;
    found.by_pressure = by_both / (step * L0);
    if (pressure != P) found.growth = 0;
    found.by_strain = strain == eps ? found.by_strain / (step * step * L0) : 0;
    return found;
}

/* strain of a unit's muscles, of the plates' */
static real own(int unit, real strain)
{
    return strain + (1 - ratio_of[unit]) * (1 - strain);
}
@functions_source@
