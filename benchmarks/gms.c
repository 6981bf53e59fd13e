/* The step of fric/friction/gms.py, line by line in C: the baseline of benchmarks/gms.py. */
#include <math.h>

static void relax(double s_0, double s_1, double C, double dt, double *left, double *pull)
{
    double x = 2.0 * C * dt / (s_0 + s_1);
    *left = 1.0;
    *pull = 0.0;
    if (x > 0.0) {
        double mean;
        if (x < 0.01) {
            mean = 1.0 + x * (-1.0 / 2.0 + x * (1.0 / 6.0 + x * (-1.0 / 24.0 + x * (1.0 / 120.0 - x * (1.0 / 720.0)))));
            *left = 1.0 - x * mean;
        } else {
            *left = exp(-x);
            mean = (1.0 - *left) / x;
        }
        *pull = (mean - *left) * s_0 + (1.0 - mean) * s_1;
    }
}

typedef struct { double way, dt, v_0, v_1, s_0, s_1; } Course;

static double least(double a, double b) { return a < b ? a : b; }
static double most(double a, double b) { return a > b ? a : b; }

static Course part(const Course *c, double x_0, double x_1)
{
    double dt = c->dt * (x_1 - x_0);
    double v_0 = c->v_0 + x_0 * (c->v_1 - c->v_0), v_1 = c->v_0 + x_1 * (c->v_1 - c->v_0);
    Course found = {0.5 * (v_0 + v_1) * dt, dt, v_0, v_1, c->s_0 + x_0 * (c->s_1 - c->s_0),
                    c->s_0 + x_1 * (c->s_1 - c->s_0)};
    return found;
}

static double slipped(double u, double alpha, double k, double C, double left, double pull, const Course *c)
{
    double relaxed = left * u + alpha * pull, stretched = u + k * c->way;
    double load = least(relaxed, stretched);
    double excess_0 = C * (alpha * c->s_0 - u) - k * c->v_0 * c->s_0;
    double reached = excess_0 > 0.0 ? stretched : relaxed;
    double excess_1 = C * (alpha * c->s_1 - reached) - k * c->v_1 * c->s_1;
    if ((excess_0 > 0.0) != (excess_1 > 0.0)) {
        double x = excess_0 / (excess_0 - excess_1);
        Course first = part(c, 0.0, x), second = part(c, x, 1.0);
        if (excess_0 > 0.0) {
            relax(second.s_0, second.s_1, C, second.dt, &left, &pull);
            load = least(load, left * (u + k * first.way) + alpha * pull);
        } else {
            relax(first.s_0, first.s_1, C, first.dt, &left, &pull);
            load = least(load, left * u + alpha * pull + k * second.way);
        }
    }
    return load;
}

static void advance(double direction, const Course *c, double *state, const double *parameters, int blocks)
{
    double C = parameters[5], left, pull;
    double s_high = most(c->s_0, c->s_1), q_low = least(c->v_0 * c->s_0, c->v_1 * c->s_1);
    relax(c->s_0, c->s_1, C, c->dt, &left, &pull);
    for (int i = 0; i < blocks; i++) {
        double alpha = parameters[6 + i], k = parameters[6 + blocks + i];
        double u = direction * state[2 + i], stretched = u + k * c->way;
        if (state[2 + blocks + i] == direction) {
            double relaxed = left * u + alpha * pull;
            if (C * (alpha * s_high - least(u, relaxed)) < k * q_low)
                u = least(relaxed, stretched);
            else
                u = slipped(u, alpha, k, C, left, pull, c);
        } else if (c->way > 0.0) {
            double before = alpha * c->s_0 - u, after = alpha * c->s_1 - stretched;
            if (before > 0.0 && after > 0.0) {
                u = stretched;
                state[2 + blocks + i] = 0.0;
            } else {
                if (before > 0.0) {
                    Course rest = part(c, before / (before - after), 1.0);
                    double left_x, pull_x;
                    relax(rest.s_0, rest.s_1, C, rest.dt, &left_x, &pull_x);
                    u = least(slipped(alpha * rest.s_0, alpha, k, C, left_x, pull_x, &rest), stretched);
                } else {
                    u = slipped(u, alpha, k, C, left, pull, c);
                }
                state[2 + blocks + i] = direction;
            }
        }
        state[2 + i] = direction * u;
    }
}

static double step(double dz, double v, double dt, double *state, const double *parameters, int blocks)
{
    double F_c = parameters[0], F_s = parameters[1], v_s = parameters[2], delta = parameters[3], sigma = parameters[4];
    double v_0 = state[0], s_0 = state[1];
    double x = fabs(v / v_s);
    if (delta != 1.0)
        x = pow(x, delta);
    double s_1 = x < 40.0 ? F_c + (F_s - F_c) * exp(-x) : F_c;
    if (v_0 * v < 0.0) {
        double before = v_0 / (v_0 - v) * dt, overshoot = 0.5 * v_0 * (v_0 / (v_0 - v)) * dt;
        Course until_turn = {fabs(overshoot), before, fabs(v_0), 0.0, s_0, F_s};
        advance(copysign(1.0, v_0), &until_turn, state, parameters, blocks);
        dz -= overshoot;
        dt -= before;
        v_0 = 0.0;
        s_0 = F_s;
    }
    if (dz != 0.0 || v != 0.0) {
        Course rest = {fabs(dz), dt, fabs(v_0), fabs(v), s_0, s_1};
        advance(copysign(1.0, dz != 0.0 ? dz : v), &rest, state, parameters, blocks);
    }
    state[0] = v;
    state[1] = s_1;
    double force = sigma * v;
    for (int i = 0; i < blocks; i++) {
        force += state[2 + i];
        if (v == 0.0)
            state[2 + blocks + i] = 0.0;
    }
    return force;
}

void replay(long n, const double *position, const double *velocity, const double *time, double *state,
            const double *parameters, int blocks, double *force)
{
    force[0] = step(0.0, velocity[0], 0.0, state, parameters, blocks);
    for (long i = 1; i < n; i++)
        force[i] = step(position[i] - position[i - 1], velocity[i], time[i] - time[i - 1], state, parameters, blocks);
}
