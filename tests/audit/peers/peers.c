/* Peers in C, written for the audit: what an engineer would write by hand, compiled with arm-none-eabi-gcc -O3.
 *
 * Each function has the signature that `firmware-stub/src/bin/audit_kernels/peers.rs` declares. */

struct mahalanobis {
    float mean[3];
    float inverse[9]; /* of the covariance, column by column */
};

/* T2 = d' M d with the whole matrix, as emlearn's eml_mahalanobis_distance_squared does. */
float audit_c_t2_matrix(const struct mahalanobis *model, const float *x)
{
    float distance = 0.0f;
    for (int i = 0; i < 3; i++) {
        float sum = 0.0f;
        for (int j = 0; j < 3; j++) {
            sum += model->inverse[3 * i + j] * (x[j] - model->mean[j]);
        }
        distance += (x[i] - model->mean[i]) * sum;
    }
    return distance;
}

struct triangle {
    float mean[3];
    float rows[6]; /* upper triangle U with T2 = |U d|^2, row by row */
};

float audit_c_t2_triangle(const struct triangle *model, const float *x)
{
    const float a = x[0] - model->mean[0], b = x[1] - model->mean[1], c = x[2] - model->mean[2];
    const float *u = model->rows;
    const float y0 = u[0] * a + u[1] * b + u[2] * c;
    const float y1 = u[3] * b + u[4] * c;
    const float y2 = u[5] * c;
    return y0 * y0 + y1 * y1 + y2 * y2;
}

struct biquad {
    float coefficients[5]; /* b0, b1, b2, -a1, -a2: the order and signs of CMSIS-DSP */
    float state[2];
};

/* One sample of a direct form II transposed section, as arm_biquad_cascade_df2T_f32 computes it. */
float audit_c_biquad(struct biquad *filter, const float *input)
{
    const float *k = filter->coefficients;
    const float x = *input;
    const float y = k[0] * x + filter->state[0];
    filter->state[0] = k[1] * x + k[3] * y + filter->state[1];
    filter->state[1] = k[2] * x + k[4] * y;
    return y;
}
