/* rigcal_paper: the numbers behind the figures of the paper, and behind ours.
 *
 *   rigcal_paper [-e N] DIR [FIGURE]...   writes FIGURE.csv into DIR, or all of them
 *
 * -e N: of the depths and resolutions of the long tables, every N-th, from the first.
 * scene.h has the scene and every setting, solve.h the methods that are compared. */
#include "figures.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene.h"
#include "table.h"

#if RIGCAL_USE_FLOAT
#error "The experiments are for the library in double."
#endif

static void figure_settings(void)
{
    FILE *const file = table_open("settings");

    fprintf(file, "name,value,unit,meaning\n");
#define WRITE(name, value, unit, meaning) \
    fprintf(file, "%s,%g,%s,\"%s\"\n", #name, (double)(value), unit, meaning);
    PAPER_SETTINGS(WRITE)
    table_close(file);
}

static const struct {
    const char *name;
    void (*make)(void);
} figures[] = {{"settings", figure_settings},
               {"fig03", figure_3},
               {"fig04", figure_4},
               {"fig05", figure_5},
               {"fig06", figure_6},
               {"fig06_share", figure_6_share},
               {"fig08", figure_8},
               {"three_points", figure_three},
               {"fig09", figure_9},
               {"fig10-14", figures_10_to_14},
               {"fig14_settling", figure_14_settling},
               {"fig14_lines", figure_14_lines},
               {"counts", figure_counts},
               {"choices", figure_choices},
               {"conditions", figure_conditions}};

int main(int argc, char *argv[])
{
    int made = 0;

    if (argc > 2 && strcmp(argv[1], "-e") == 0) {
        table_every = atoi(argv[2]);
        argv += 2;
        argc -= 2;
    }
    if (argc < 2 || table_every < 1) {
        fprintf(stderr, "usage: rigcal_paper [-e N] DIR [FIGURE]...\n");
        return 2;
    }
    table_folder = argv[1];
    for (size_t i = 0; i < sizeof figures / sizeof figures[0]; i++) {
        int wanted = argc == 2;

        for (int k = 2; k < argc; k++) {
            wanted |= strcmp(argv[k], figures[i].name) == 0;
        }
        if (wanted) {
            fprintf(stderr, "%s\n", figures[i].name);
            figures[i].make();
            made++;
        }
    }
    if (made == 0) {
        fprintf(stderr, "paper: there is no such figure\n");
        return 2;
    }
    return 0;
}
