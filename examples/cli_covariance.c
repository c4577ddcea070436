/* The covariances of rig.csv. */
#include "cli_covariance.h"

#include <math.h>
#include <string.h>

/* ==== of one camera ======================================================= */

/* Writes the name of a column: "S11", "S21", "S22", ..., "S66". */
static void column_name(char name[4], int row, int column)
{
    name[0] = 'S';
    name[1] = (char)('1' + row);
    name[2] = (char)('1' + column);
    name[3] = '\0';
}

int cli_covariance_find(size_t columns[CLI_COVARIANCE_COLUMNS], const csv_table *table)
{
    char name[4];
    int i, j, k = 0;

    if (csv_optional(table, "S11") == CSV_NONE) {
        return 0;
    }
    for (i = 0; i < 6; i++) {
        for (j = 0; j <= i; j++) {
            column_name(name, i, j);
            columns[k++] = csv_column(table, name);
        }
    }
    return 1;
}

/* Whether the matrix is positive definite: Cholesky, with the diagonal scaled to 1. */
static int is_covariance(const rigcal_real Sigma[36])
{
    double L[36] = {0};
    int i, j, k;

    for (i = 0; i < 6; i++) {
        if (!(Sigma[7 * i] > 0)) {
            return 0;
        }
    }
    for (i = 0; i < 6; i++) {
        for (j = 0; j <= i; j++) {
            double sum = (double)Sigma[6 * i + j] / sqrt((double)Sigma[7 * i]) /
                         sqrt((double)Sigma[7 * j]);

            for (k = 0; k < j; k++) {
                sum -= L[6 * i + k] * L[6 * j + k];
            }
            if (i == j && !(sum > 0)) {
                return 0;
            }
            L[6 * i + j] = i == j ? sqrt(sum) : sum / L[7 * j];
        }
    }
    return 1;
}

uint8_t cli_covariance_read(rigcal_real Sigma[36], const csv_table *table, size_t row,
                            const size_t columns[CLI_COVARIANCE_COLUMNS])
{
    int i, j, k = 0, is_zero = 1;

    for (i = 0; i < 6; i++) {
        for (j = 0; j <= i; j++) {
            const rigcal_real s = csv_real(table, row, columns[k++]);

            Sigma[6 * i + j] = Sigma[6 * j + i] = s;
            is_zero = is_zero && !(s < 0 || s > 0);
        }
    }
    if (!is_zero && !is_covariance(Sigma)) {
        csv_fail(table, row,
                 "S11 to S66 are no covariance: it must be positive definite, or all "
                 "0 for a camera that is held");
    }
    return is_zero ? RIGCAL_CAMERA_HELD : RIGCAL_CAMERA_PRIOR;
}

/* ==== between cameras ===================================================== */

const char *cli_covariance_between(int row, int column, const char *name)
{
    return cli_text("S%d%d@%s", row + 1, column + 1, name);
}

/* Whether a column, which may be CSV_NONE, has text in this line. */
static int has_cell(const csv_table *table, size_t row, size_t column)
{
    return column != CSV_NONE && *table->cells[row * table->n_columns + column] != '\0';
}

static size_t find_exactly(const csv_table *table, const char *name)
{
    size_t i;

    for (i = 0; i < table->n_columns; i++) {
        if (strcmp(table->columns[i], name) == 0) {
            return i;
        }
    }
    return CSV_NONE;
}

/* For each camera: the 36 columns of its covariance with other cameras, at first CSV_NONE:
 * the file may lack them. */
static size_t *find_between(const cli_transforms *file)
{
    const size_t n = file->names.count;
    size_t *columns = cli_alloc(36 * n, sizeof *columns), c;
    int k;

    for (c = 0; c < n; c++) {
        for (k = 0; k < 36; k++) {
            const char *name = cli_covariance_between(k / 6, k % 6, file->names.name[c]);
            const size_t column = find_exactly(&file->table, name);

            columns[36 * c + (size_t)k] = column;
            if (column == CSV_NONE && k == 0) {
                break;
            }
            if (column == CSV_NONE) {
                csv_fail_line(&file->table, file->table.header_line,
                              "there is no column %s, but S11@%s", name,
                              file->names.name[c]);
            }
        }
    }
    return columns;
}

/* The address of an element of the joint covariance. */
static rigcal_real *element(rigcal_real *Sigma, size_t row, size_t column)
{
    return &Sigma[row > column ? row * (row + 1) / 2 + column
                               : column * (column + 1) / 2 + row];
}

/* Reads the block of two cameras from the line of one of them. The unknowns of the camera
 * of a line begin at first[line]. Returns 0 if the file has no such block. */
static int read_between(rigcal_real *Sigma, const csv_table *table, const size_t *columns,
                        const size_t *first, size_t a, size_t b)
{
    const int is_of_b = has_cell(table, b, columns[36 * a]);
    const size_t line = is_of_b ? b : a, other = is_of_b ? a : b;
    size_t i, j;

    if (!has_cell(table, line, columns[36 * other])) {
        return 0;
    }
    for (i = 0; i < 6; i++) {
        for (j = 0; j < 6; j++) {
            const rigcal_real s = csv_real(table, line, columns[36 * other + 6 * i + j]);
            const size_t row = first[line] + i, column = first[other] + j;
            const double most = sqrt((double)*element(Sigma, row, row)) *
                                sqrt((double)*element(Sigma, column, column));

            if (!(fabs((double)s) <= most * (1 + 1e-6))) {
                csv_fail(table, line, "%s is more than the variances of both allow",
                         table->columns[columns[36 * other + 6 * i + j]]);
            }
            *element(Sigma, row, column) = s;
        }
    }
    return 1;
}

rigcal_real *cli_covariance_joint(const cli_transforms *file, const size_t *lines,
                                  const rigcal_real *const *own, size_t n)
{
    const size_t *columns = find_between(file);
    size_t *first = cli_alloc(file->names.count, sizeof *first), a, b, i, j;
    rigcal_real *Sigma = cli_alloc(rigcal_calibrated_size(n) + 1, sizeof *Sigma);

    for (b = 0; b < n; b++) {
        first[lines[b]] = 6 * b;
        for (i = 0; i < 6; i++) {
            for (j = 0; j <= i; j++) {
                *element(Sigma, 6 * b + i, 6 * b + j) = own[b][6 * i + j];
            }
        }
    }
    for (b = 0; b < n; b++) {
        for (a = 0; a < b; a++) {
            if (!read_between(Sigma, &file->table, columns, first, lines[a], lines[b])) {
                return NULL;
            }
        }
    }
    return Sigma;
}

/* ==== the file ============================================================ */

/* Whether every line has the covariance of its own camera. An empty cell means that it is
 * not known. */
static int has_covariances(size_t columns[CLI_COVARIANCE_COLUMNS], const csv_table *table)
{
    size_t row;

    if (!cli_covariance_find(columns, table)) {
        return 0;
    }
    for (row = 0; row < table->n_rows; row++) {
        if (!has_cell(table, row, columns[0])) {
            return 0;
        }
    }
    return 1;
}

/* Reads all blocks. Returns 0 if some are missing. */
static int read_joint(cli_rig *rig)
{
    const size_t n = rig->file.names.count;
    size_t columns[CLI_COVARIANCE_COLUMNS], c, n_known = 0;
    size_t *lines = cli_alloc(n, sizeof *lines);
    const rigcal_real **own = cli_alloc(n, sizeof *own);

    if (!has_covariances(columns, &rig->file.table)) {
        return 0;
    }
    for (c = 0; c < n; c++) {
        rigcal_mounted_camera *m = &rig->rig.cameras[c];

        rig->rig.held[c] = cli_covariance_read(m->Sigma, &rig->file.table, c, columns) ==
                           RIGCAL_CAMERA_HELD;
        m->has_Sigma = 1;
        if (!rig->rig.held[c]) {
            own[n_known] = m->Sigma;
            lines[n_known++] = c;
        }
    }
    rig->rig.Sigma_capacity = rigcal_calibrated_size(n_known);
    rig->rig.Sigma = cli_covariance_joint(&rig->file, lines, own, n_known);
    return rig->rig.Sigma != NULL;
}

/* Reads a number of pixels, or any other number within the same limits. */
static rigcal_real read_pixels(const csv_table *table, size_t row, size_t column)
{
    const rigcal_real number = csv_real(table, row, column);

    if (!((double)number >= RIGCAL_CLI_SIGMA_LEAST &&
          (double)number <= RIGCAL_CLI_SIGMA_MOST)) {
        csv_fail(table, row, "%s is from 1e-6 to 1e6", table->columns[column]);
    }
    return number;
}

/* Reads a column that has the same number in all lines. Returns 0 if it is not known. */
static rigcal_real read_common(const csv_table *table, const char *name)
{
    const size_t column = csv_optional(table, name);

    return has_cell(table, 0, column) ? read_pixels(table, 0, column) : 0;
}

/* Reads column sigma_px, which all lines must have, or none. */
static void read_sigmas(cli_rig *rig, double sigma_px)
{
    const csv_table *table = &rig->file.table;
    const size_t n = rig->file.names.count, column = csv_optional(table, "sigma_px");
    size_t c;

    for (c = 0; c < n; c++) {
        if (!(sigma_px > 0) && !has_cell(table, c, column)) {
            return;
        }
    }
    rig->sigma_px = cli_alloc(n, sizeof *rig->sigma_px);
    for (c = 0; c < n; c++) {
        rig->sigma_px[c] =
            sigma_px > 0 ? (rigcal_real)sigma_px : read_pixels(table, c, column);
    }
}

void cli_rig_read(cli_rig *rig, const char *path, const cli_cameras *cameras,
                  double sigma_px)
{
    rigcal_real root_F;
    size_t c, n;

    memset(rig, 0, sizeof *rig);
    cli_transforms_read(&rig->file, path, "camera", cameras);
    n = rig->file.names.count;
    rig->rig.cameras = cli_alloc(n, sizeof *rig->rig.cameras);
    rig->rig.group = cli_alloc(n, sizeof *rig->rig.group);
    rig->rig.held = cli_alloc(n, sizeof *rig->rig.held);
    rig->rig.capacity = rig->rig.n_cameras = n;
    rig->camera = cli_alloc(n, sizeof *rig->camera);
    for (c = 0; c < n; c++) {
        rig->camera[c] = cli_names_find(&cameras->names, rig->file.names.name[c]);
        rig->rig.cameras[c].camera = cameras->camera[rig->camera[c]];
        rig->rig.cameras[c].cam_from_rig = rig->file.transform[c];
    }
    read_sigmas(rig, sigma_px);
    rig->noise_px =
        sigma_px > 0 ? (rigcal_real)sigma_px : read_common(&rig->file.table, "noise_px");
    root_F = read_common(&rig->file.table, "sqrt_F");
    rig->rig.F = root_F * root_F;
    if (read_joint(rig)) {
        rig->rig.sigma_px = rig->noise_px > 0 ? rig->noise_px : 1;
    }
}

void cli_rig_tell_exact(const cli_rig *rig)
{
    if (!(rig->rig.sigma_px > 0)) {
        cli_say("%s has no covariance of all its cameras: they count as exact",
                rig->file.table.path);
    }
}
