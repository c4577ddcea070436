/* How much the cameras saw together: pairs of cameras, the weakest link, and what to record
 * next. */
#include "cli_calibrate.h"

#include <math.h>
#include <string.h>

/* ==== groups ============================================================== */

int *cameras_that_count(const calibration *c)
{
    int *counts = cli_alloc(c->rig.n_cameras, sizeof *counts);
    size_t i;

    for (i = 0; i < c->n_views; i++) {
        counts[c->views[i].rig_camera] |= c->views[i].in_rig;
    }
    return counts;
}

/* The links of the rig, computed in memory of their own: the memory of the rig holds the
 * covariance. NULL: not known. */
static rigcal_link *links_of(const calibration *c)
{
    const size_t n = RIGCAL_LINKS(c->rig.n_cameras);
    rigcal_link *links = cli_alloc(n + 1, sizeof *links);
    rigcal_rig rig = c->rig;
    int32_t at_fault, n_groups;

    if (n == 0) { /* one camera has no links */
        return links;
    }
    rig.work = cli_alloc(rig.work_capacity, sizeof *rig.work);
    rig.group = cli_alloc(rig.n_cameras, sizeof *rig.group);
    if (rigcal_rig_links(links, n + 1, &n_groups, &at_fault, &rig) < 0) {
        cli_free(links);
        links = NULL;
    }
    cli_free(rig.group);
    cli_free(rig.work);
    return links;
}

/* The names of the groups: "a, b and c; d and e". */
static const char *groups_by_name(const calibration *c, const int counts[])
{
    const size_t n = c->rig.n_cameras;
    const char **names = cli_alloc(n, sizeof *names), *text = NULL;
    size_t first, i;

    for (first = 0; first < n; first++) {
        size_t n_names = 0;

        for (i = 0; i < n; i++) {
            if (counts[i] && c->rig.group[i] == c->rig.group[first]) {
                if (i < first) {
                    break;
                }
                names[n_names++] = rig_camera_name(c, i);
            }
        }
        if (i == n && n_names > 0) {
            const char *group = names_joined(names, n_names, " and ");

            text = text == NULL ? group : cli_text("%s; %s", text, group);
        }
    }
    cli_free(names);
    return text;
}

static const char *advice_by_name(const calibration *c, const rigcal_link links[],
                                  const int counts[])
{
    const size_t room = c->rig.n_cameras;
    rigcal_advice *list = cli_alloc(room, sizeof *list);
    const char *text = NULL;
    size_t i, n = 0;

    if (rigcal_rig_advise(list, room, &n, links, &c->rig) < 0) {
        n = 0;
    }
    for (i = 0; i < n; i++) {
        if (counts[list[i].a] && counts[list[i].b]) {
            const char *a = rig_camera_name(c, (size_t)list[i].a);
            const char *b = rig_camera_name(c, (size_t)list[i].b);

            text = text == NULL
                       ? cli_text("show the target to %s and %s together in a frame", a, b)
                       : cli_text("%s, to %s and %s in another", text, a, b);
        }
    }
    return text != NULL ? text : "show the target to cameras of two groups together";
}

/* Finds cameras without a common frame. */
void find_groups(calibration *c)
{
    const int *counts = cameras_that_count(c);
    const rigcal_link *links;
    int is_apart = 0;
    size_t i;

    for (i = 0; i < c->rig.n_cameras; i++) {
        is_apart |= counts[i] && !c->in_frame[i];
    }
    if (!is_apart) {
        return;
    }
    links = links_of(c);
    if (links != NULL) {
        find(c, ABOUT_RIG,
             cli_text("the cameras are disconnected, these groups share no frame: %s. "
                      "rig.csv and pairs.csv have those of the group of %s only",
                      groups_by_name(c, counts), rig_camera_name(c, c->main_camera)),
             advice_by_name(c, links, counts));
    }
    c->exit_status = CLI_GEOMETRY;
}

/* ==== pairs =============================================================== */

static double angle_of(const rigcal_transform *b_from_a)
{
    static const rigcal_real NONE[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    rigcal_real angle = 0;

    rigcal_rotation_angle(&angle, NONE, b_from_a->R);
    return DEGREE * (double)angle;
}

/* `direct` says how sure the rotation is from what the two cameras see together alone. */
static void print_pair(const calibration *c, size_t a, size_t b, int wide,
                       const rigcal_link *link)
{
    const double information = (double)link->information;
    rigcal_transform b_from_a;
    rig_sigma s;
    const int is_known = rig_pair(&b_from_a, &s, c, a, b);

    printf("%-*s  %-*s  %8.5g  %11.4f", wide, rig_camera_name(c, a), wide,
           rig_camera_name(c, b), length_of(b_from_a.t), angle_of(&b_from_a));
    print_rig_sigma(&s, is_known);
    if (is_known && information > 0) {
        printf("  %12.2g", DEGREE * c->noise_px * c->factor / sqrt(information));
    } else {
        printf("  %12s", "-");
    }
    printf("  over %ld placement%s\n", (long)link->n_shared,
           link->n_shared == 1 ? "" : "s");
}

static void print_pairs(const calibration *c, const rigcal_link links[])
{
    const int wide = widest(&c->cameras.names);
    int header = 0;
    size_t a, b;

    for (a = 0; a < c->rig.n_cameras; a++) {
        for (b = a + 1; b < c->rig.n_cameras; b++) {
            if (c->rig.group[a] != c->rig.group[b]) {
                continue;
            }
            if (!header++) {
                printf("\n%-*s  %-*s  distance  angle [deg]  +- [deg]  +- position  "
                       "direct [deg]\n",
                       wide, "camera", wide, "camera");
            }
            print_pair(c, a, b, wide, &links[RIGCAL_LINK(a, b)]);
        }
    }
    if (header) {
        printf(
            "+- of a pair: by all views; direct: by the placements that the two share\n");
    }
}

int find_weakest(rigcal_weakest *weakest, const calibration *c)
{
    const rigcal_real noise = (rigcal_real)(c->noise_px * c->factor);

    return c->is_adjusted && c->noise_px > 0 &&
           rigcal_rig_weakest(weakest, &c->rig, noise) >= 0;
}

const char *next_text(const calibration *c, const rigcal_weakest *weakest)
{
    return cli_text("show the target to %s and %s together in more places",
                    rig_camera_name(c, (size_t)weakest->camera),
                    rig_camera_name(c, (size_t)weakest->other));
}

/* Prints the camera whose pose is supported least, and what would help. */
static void print_weakest(const calibration *c)
{
    rigcal_weakest weakest;

    if (!find_weakest(&weakest, c)) {
        return;
    }
    printf("weakest: camera %s, +- %.2g deg and %.2g to %s, to which it is surest\n",
           rig_camera_name(c, (size_t)weakest.camera), DEGREE * (double)weakest.rotation,
           (double)weakest.translation, rig_camera_name(c, (size_t)weakest.other));
    printf("next: %s\n", next_text(c, &weakest));
}

void print_graph(const calibration *c)
{
    const rigcal_link *links = links_of(c);

    if (links != NULL) {
        print_pairs(c, links);
        print_weakest(c);
    }
}
