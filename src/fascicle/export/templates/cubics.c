
/* the inverse: at one strain, in each of the table's cells, a force is one cubic */
#define NODES (LINES + 1)
#define ROOT_STEPS 60 /* at most: bisection alone takes as many for all digits */

static const real inverse_top = @inverse_top@; /* [Pa] */
static const real meets = @meets@;             /* [N]: a force this near to the demand meets it */
static const real digits = @digits@; /* rounding of a number near 1 */

static real smaller(real a, real b) { return a < b ? a : b; }
static real larger(real a, real b) { return a > b ? a : b; }
static real size(real x) { return x < 0 ? -x : x; }
static real cubic(const real c[4], real u) { return ((c[3] * u + c[2]) * u + c[1]) * u + c[0]; }

/* a cell's cubic of its coordinate: of the pressure in the first, of its root in the others */
static void cell_cubic(const real value[NODES], const real slope[NODES], int i, real c[4])
{
    const real line = root_step[0] * root_step[0];
    const real by_start = i ? 2 * (real)i * line : line;
    const real by_stop = i ? 2 * (real)(i + 1) * line : line;
    const real rise = value[i + 1] - value[i];

    c[0] = value[i];
    c[1] = by_start * slope[i];
    c[3] = c[1] + by_stop * slope[i + 1] - 2 * rise;
    c[2] = rise - c[1] - c[3];
}

/* the zero of a cubic that changes its sign once between a and b: from the chord's Newton's method,
 * or a half */
static real zero(const real c[4], real a, real b)
{
    const real at_a = cubic(c, a), at_b = cubic(c, b);
    real x = a + (b - a) * (at_a / (at_a - at_b)), next;
    int n;

    for (n = 0; n < ROOT_STEPS; n++) {
        const real value = cubic(c, x), slope = (3 * c[3] * x + 2 * c[2]) * x + c[1];

        if ((value > 0) == (at_b > 0)) b = x; else a = x;
        next = slope != 0 ? x - value / slope : a;
        if (size(next - x) <= digits) break;
        if (!(next > a && next < b)) next = (a + b) / 2;
        x = next;
    }
    return x;
}
