/* The loop of fric/kernels/loop.py, line by line in C, with the GMS step of gms.c: the baseline of benchmarks/loop.py. */
#include "gms.c"

typedef struct { double A, B, M, load, delay; } Plant;
typedef struct { double K_v, K_p, K_i, pole, T_s, limit, resolution; } Control;

static double filtered(const double *b, const double *a, double *memory, long order, double x)
{
    double y = b[0] * x + memory[0];
    for (long i = 0; i < order - 1; i++)
        memory[i] = b[i + 1] * x - a[i + 1] * y + memory[i + 1];
    memory[order - 1] = b[order] * x - a[order] * y;
    return y;
}

long closed_loop(double *state, const double *parameters, int blocks, const Plant *plant, const Control *control,
                 long order, const double *position_b, const double *position_a, const double *voltage_b,
                 const double *voltage_a, long n_samples, const double *r, const double *r_dot, const double *model,
                 const double *ahead, long substeps, double *position, double *measured_out, double *velocity,
                 double *input, double *friction, double *disturbance)
{
    long whole = (long)(plant->delay / control->T_s + 1e-9);
    double share = fmax(plant->delay / control->T_s - whole, 0.0);
    long before = share < 1e-9 ? 0 : fmax(1, (long)(substeps * share + 0.5));
    long after = fmax(1, substeps - before);
    double lengths[2] = {share * control->T_s / fmax(before, 1), (1.0 - share) * control->T_s / after};
    long counts[2] = {before, after};
    double z = r[0], origin = z, seen = z;
    if (control->resolution > 0.0)
        seen = rint(z / control->resolution) * control->resolution;
    double v = 0.0, a = 0.0, h_before = 0.0, F = 0.0, filtered_v = 0.0, integral = 0.0;
    double position_memory[8] = {0}, voltage_memory[8] = {0};
    long saturated = 0;
    for (long n = 0; n < n_samples; n++) {
        double measured = z;
        if (control->resolution > 0.0)
            measured = rint(z / control->resolution) * control->resolution;
        filtered_v = control->pole * filtered_v + (1.0 - control->pole) * (measured - seen) / control->T_s;
        seen = measured;
        double error = control->K_v * (r[n] - measured) + r_dot[n] - filtered_v;
        double step_of_integral = control->K_i * control->T_s * error, estimate = 0.0;
        if (order)
            estimate = filtered(position_b, position_a, position_memory, order, measured - origin) - voltage_memory[0];
        double wanted = control->K_p * error + integral + step_of_integral + model[n] + ahead[n] - estimate;
        double u = fmin(fmax(wanted, -control->limit), control->limit);
        if (u == wanted)
            integral += step_of_integral;
        else {
            saturated++;
            if ((wanted - u) * step_of_integral < 0.0)
                integral += step_of_integral;
        }
        if (order)
            filtered(voltage_b, voltage_a, voltage_memory, order, u - ahead[n]);
        position[n] = z, measured_out[n] = measured, velocity[n] = v;
        input[n] = u, friction[n] = F, disturbance[n] = estimate;
        for (int part = 0; part < 2; part++) {
            long sample = n - whole - 1 + part;
            double driven = (sample >= 0 ? plant->B * input[sample] : 0.0) - plant->load / plant->M;
            double h = lengths[part], decay = exp(-plant->A * h);
            double reach = plant->A > 0.0 ? -expm1(-plant->A * h) / plant->A : h;
            for (long i = 0; i < counts[part]; i++) {
                double half = 0.5 * h, free_v = decay * v + reach * driven;
                z += half * v;
                F = step((0.5 * h_before + half) * v, v + half * a, 0.5 * h_before + half, state, parameters, blocks);
                double moved = free_v - reach * F / plant->M;
                a = (moved - v) / h;
                v = moved;
                z += half * v;
                h_before = h;
            }
        }
    }
    return saturated;
}
