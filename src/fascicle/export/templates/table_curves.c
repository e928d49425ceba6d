
static const real tie = @tie@;                 /* [N]: forces this near to each other are equal */
static const int unit_of[KINDS] = {@first_units@}; /* the first unit of each kind */

/* force [N] of one muscle of each kind and its slope by pressure [m2], at each line of the table
 * and at the supply's pressure */
typedef struct {
    real supply, force[KINDS][NODES], slope[KINDS][NODES], full[KINDS];
} curves;

/* a pressure [Pa], and how far its force is beyond the demand [N] */
typedef struct {
    real pressure, excess;
    int meets;
} solution;

static int inside_inverse(real force, real strain, real supply)
{
    int unit, all = force - force == 0 && supply > 0;

    for (unit = 0; unit < UNITS; unit++) {
        const real eps = own(unit, strain);

        all = all && eps >= low[kind_of[unit]] && eps <= high[kind_of[unit]];
    }
    return all;
}

static void fill_curves(curves *at, real strain, real supply)
{
    int kind, i;

    at->supply = supply;
    for (kind = 0; kind < KINDS; kind++) {
        const real eps = own(unit_of[kind], strain), x = (eps - low[kind]) / cell[kind];
        const int j = x < COLUMNS ? (int)x : COLUMNS - 1;
        const real w = x - (real)j, v = 1 - w, per = 1 / (cell[kind] * length[kind]);
        const real da = 6 * w * v, db = v * (1 - 3 * w), dc = w * (3 * w - 2);

        for (i = 0; i < NODES; i++) {
            const real *m = nodes[kind][i][j], *n = nodes[kind][i][j + 1];

            at->force[kind][i] = per * (da * (n[0] - m[0]) + db * m[1] + dc * n[1]);
            at->slope[kind][i] = per * (da * (n[2] - m[2]) + db * m[3] + dc * n[3]);
        }
        at->full[kind] = muscle_at(kind, supply, eps).force;
    }
}

/* where a cubic turns between 0 and `end`, in order; returns how often */
static int turns(const real c[4], real end, real turn[2])
{
    const real inside = c[2] * c[2] - 3 * c[3] * c[1];
    const real root = inside > 0 ? @sqrt@(inside) : 0;
    const real q = -(c[2] + (c[2] < 0 ? -root : root));
    const real first = q != 0 ? c[1] / q : -1, second = c[3] != 0 ? q / (3 * c[3]) : -1;
    int count = 0;

    if (!(inside > 0)) return 0;
    turn[count] = smaller(first, second);
    if (turn[count] > 0 && turn[count] < end) count++;
    turn[count] = larger(first, second);
    if (turn[count] > 0 && turn[count] < end) count++;
    return count;
}

/* the lowest pressure at which so many muscles of each kind give a force; else that of the nearest
 * force */
static solution search(const curves *at, const real count[KINDS], real force)
{
    const real h = root_step[0], line = h * h;
    solution best = {0, INFINITY, 0};
    real excess_at[NODES], slope_at[NODES], bound = INFINITY;
    int i, kind, n;

    for (i = 0; i < NODES; i++) {
        excess_at[i] = -force;
        slope_at[i] = 0;
    }
    for (kind = 0; kind < KINDS; kind++) {
        if (!(count[kind] > 0)) continue;
        for (i = 0; i < NODES; i++) {
            excess_at[i] += count[kind] * at->force[kind][i];
            slope_at[i] += count[kind] * at->slope[kind][i];
        }
    }
    for (i = 0; i < NODES && (real)(i * i) * line <= at->supply; i++)
        bound = smaller(bound, size(excess_at[i]));
    /* what is as near as this may be the result */
    bound = larger(bound + tie, meets);
    for (i = 0; i < LINES && (real)(i * i) * line < at->supply; i++) {
        const real stop = (real)((i + 1) * (i + 1)) * line;
        real end = 1, stops[4], c[4], f, g, f_b, g_b;
        int count_stops = 1;

        cell_cubic(excess_at, slope_at, i, c);
        f = c[0];
        g = excess_at[i + 1];
        f_b = f + c[1] / 3;
        g_b = g - (c[1] + 2 * c[2] + 3 * c[3]) / 3;
        /* a cubic lies between the least and the largest of its Bezier ordinates: skip a cell that
         * holds nothing as near as a node, or nothing nearer than what is found */
        bound = smaller(bound, size(best.excess));
        if (smaller(smaller(f, f_b), smaller(g, g_b)) >= bound) continue;
        if (larger(larger(f, f_b), larger(g, g_b)) <= -bound) continue;
        if (stop > at->supply) end = i ? @sqrt@(at->supply) / h - (real)i : at->supply / line;
        stops[0] = 0;
        count_stops += turns(c, end, stops + 1);
        stops[count_stops] = end;
        for (n = 0; n <= count_stops && !best.meets; n++) {
            real u = stops[n], excess = cubic(c, u);

            if (n && size(excess) > meets && (excess > 0) != (cubic(c, stops[n - 1]) > 0)) {
                u = zero(c, stops[n - 1], u);
                excess = 0;
            }
            if (!(size(excess) <= meets || size(excess) < size(best.excess) - tie)) continue;
            best.pressure = i ? ((real)i + u) * ((real)i + u) * line : u * line;
            if (u >= end && (stop >= at->supply || i == LINES - 1)) best.pressure = at->supply;
            best.pressure = smaller(best.pressure, at->supply);
            best.excess = excess;
            best.meets = size(excess) <= meets;
        }
        if (best.meets) break;
    }
    return best;
}
