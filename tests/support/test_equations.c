#include "test_equations.h"

#include "vectors_scenes.h"

void test_golden_scene(rigcal_bearing out[6], double ypr[3], double wrong[3], int k)
{
    const double *v = SCENE[k];

    for (int i = 0; i < 6; i++) {
        test_to_real(out[i].X_w, v + 3 * i, 3);
        test_to_real(out[i].ray, v + 18 + 2 * i, 2);
        out[i].ray[2] = 1;
    }
    for (int i = 0; i < 3; i++) {
        ypr[i] = v[30 + i];
        wrong[i] = v[36 + i];
    }
}

int test_golden_pairs(rigcal_pair pairs[15], const rigcal_bearing s[6], int n)
{
    int count = 0;

    for (int j = 0; j < n; j++) {
        for (int i = 0; i < j; i++) {
            ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pairs[count++], s, 6, i, j));
        }
    }
    return count;
}

void test_other_two(rigcal_real out[2], const double ypr[3], int eliminated)
{
    out[0] = RC(ypr[eliminated == RIGCAL_YAW ? 1 : 0]);
    out[1] = RC(ypr[eliminated == RIGCAL_ROLL ? 1 : 2]);
}

void test_rotation_of(rigcal_real R[9], const double ypr[3])
{
    double M[9];

    test_rotation(M, ypr[0], ypr[1], ypr[2]);
    test_to_real(R, M, 9);
}

rigcal_pair test_pair_of(double n1, double n2, double n3, double d1, double d2, double d3)
{
    const rigcal_pair pair = {{RC(n1), RC(n2), RC(n3)}, {RC(d1), RC(d2), RC(d3)}, 0, 1};

    return pair;
}
