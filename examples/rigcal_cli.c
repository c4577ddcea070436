/* rigcal - the library from the command line, on the files of data/FORMAT.md. */
#include <errno.h>
#include <getopt.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static const char HELP[] =
    "rigcal - where each camera of a rig is, from a few points of known shape\n"
    "\n"
    "  rigcal calibrate   --cameras FILE --observations FILE [--out FOLDER]\n"
    "                     [--method ml|paper]\n"
    "                     [--robust [--threshold PIXELS] [--seed NUMBER]]\n"
    "  rigcal triangulate --cameras FILE --rig FILE --observations FILE\n"
    "                     [--targets FILE] [--sigma PIXELS]\n"
    "  rigcal line        --cameras FILE --rig FILE --from CAMERA --to CAMERA\n"
    "                     --pixel U,V [--depth NEAR,FAR]\n"
    "  rigcal --help | --version\n"
    "\n"
    "calibrate    finds every camera's pose and the rig they form; writes\n"
    "             poses.csv, rig.csv, targets.csv and pairs.csv to FOLDER.\n"
    "             --method ml, the default: the maximum-likelihood pose and "
    "its\n"
    "             1-sigma; of three points, all poses are found and one is taken\n"
    "             --method paper: the published procedure for every view\n"
    "             --robust: points that disagree with the others by more than\n"
    "             --threshold, 3 if not given, are named and left out\n"
    "triangulate  measures the points that two cameras or more observed, in "
    "the\n"
    "             first camera's frame or with --targets in the target's; "
    "prints\n"
    "             CSV. Noise of a pixel coordinate is --sigma or is estimated\n"
    "line         tells where what --from sees at --pixel can be in the image\n"
    "             of --to: alpha u + beta v + gamma = 0 in pixels without\n"
    "             distortion, its ends in the image, and with --depth its "
    "part\n"
    "             between two depths along --from's axis; prints CSV\n"
    "\n"
    "The files are described in examples/data/FORMAT.md.\n"
    "Exit status: 0 done; 1 something could not be computed, and was named, "
    "the\n"
    "rest was done; 2 wrong use or a file at fault, nothing was written.\n";

#define BIT(option) (1u << (option))

typedef struct {
    const char *name;
    cli_command *run;
    unsigned required, optional;
} command;

static const command COMMANDS[] = {
    {"calibrate", cli_calibrate, BIT(OPTION_CAMERAS) | BIT(OPTION_OBSERVATIONS),
     BIT(OPTION_OUT) | BIT(OPTION_METHOD) | BIT(OPTION_ROBUST) |
         BIT(OPTION_THRESHOLD) | BIT(OPTION_SEED)},
    {"triangulate", cli_triangulate,
     BIT(OPTION_CAMERAS) | BIT(OPTION_RIG) | BIT(OPTION_OBSERVATIONS),
     BIT(OPTION_TARGETS) | BIT(OPTION_SIGMA)},
    {"line", cli_line,
     BIT(OPTION_CAMERAS) | BIT(OPTION_RIG) | BIT(OPTION_FROM) | BIT(OPTION_TO) |
         BIT(OPTION_PIXEL),
     BIT(OPTION_DEPTH)},
};

enum { HELP_OPTION = OPTION_COUNT };

static const struct option OPTIONS[] = {
    {"cameras", required_argument, NULL, OPTION_CAMERAS},
    {"observations", required_argument, NULL, OPTION_OBSERVATIONS},
    {"out", required_argument, NULL, OPTION_OUT},
    {"rig", required_argument, NULL, OPTION_RIG},
    {"targets", required_argument, NULL, OPTION_TARGETS},
    {"sigma", required_argument, NULL, OPTION_SIGMA},
    {"from", required_argument, NULL, OPTION_FROM},
    {"to", required_argument, NULL, OPTION_TO},
    {"pixel", required_argument, NULL, OPTION_PIXEL},
    {"depth", required_argument, NULL, OPTION_DEPTH},
    {"method", required_argument, NULL, OPTION_METHOD},
    {"robust", no_argument, NULL, OPTION_ROBUST},
    {"threshold", required_argument, NULL, OPTION_THRESHOLD},
    {"seed", required_argument, NULL, OPTION_SEED},
    {"help", no_argument, NULL, HELP_OPTION},
    {NULL, 0, NULL, 0},
};

/* Wrong use: the message, and where to read on. */
#define WRONG_USE(...) (cli_say(__VA_ARGS__), hint())

static CLI_NORETURN void hint(void)
{
    cli_fail("see rigcal --help");
}

void cli_numbers(double numbers[], size_t count, const char *option,
                 const char *text)
{
    const char *rest = text;
    const char *problem = NULL;
    size_t i;

    for (i = 0; i < count && problem == NULL; i++) {
        rest = cli_number(&numbers[i], &problem, rest);
        if (problem == NULL && *rest != (i + 1 < count ? ',' : '\0')) {
            problem = "is not what it should be";
        }
        rest++;
    }
    if (problem != NULL) {
        WRONG_USE("%s takes %lu number%s, not \"%s\"", option,
                  (unsigned long)count,
                  count > 1 ? "s with a comma between" : "", text);
    }
}

static void print_help(void)
{
    fputs(HELP, stdout);
}

static CLI_NORETURN void refuse_option(char *argv[])
{
    if (optopt > ' ') {
        WRONG_USE("-%c: no such option", optopt);
    }
    WRONG_USE("%s: no such option", argv[optind - 1]);
}

static void parse(const char *option[OPTION_COUNT], const command *chosen,
                  int argc, char *argv[])
{
    int given, i;

    opterr = 0;
    while ((given = getopt_long(argc, argv, ":", OPTIONS, NULL)) != -1) {
        if (given == ':') {
            WRONG_USE("%s needs a value", argv[optind - 1]);
        } else if (given == '?') {
            refuse_option(argv);
        } else if (given == HELP_OPTION) {
            print_help();
            exit(CLI_DONE);
        } else if (!((chosen->required | chosen->optional) & BIT(given))) {
            WRONG_USE("%s takes no --%s", chosen->name, OPTIONS[given].name);
        } else if (option[given] != NULL) {
            WRONG_USE("--%s is given twice", OPTIONS[given].name);
        }
        option[given] = optarg != NULL ? optarg : "";
    }
    if (optind < argc) {
        WRONG_USE("%s: %s takes options only", argv[optind], chosen->name);
    }
    for (i = 0; i < OPTION_COUNT; i++) {
        if ((chosen->required & BIT(i)) && option[i] == NULL) {
            WRONG_USE("%s needs --%s", chosen->name, OPTIONS[i].name);
        }
    }
}

static const command *find_command(const char *name)
{
    size_t i;

    for (i = 0; i < sizeof COMMANDS / sizeof COMMANDS[0]; i++) {
        if (strcmp(name, COMMANDS[i].name) == 0) {
            return &COMMANDS[i];
        }
    }
    WRONG_USE("%s: no such command", name);
}

static void print_version(void)
{
    const int version = (int)rigcal_version();

    printf("rigcal %d.%d.%d (%s)\n", version / 10000, version / 100 % 100,
           version % 100, rigcal_sizeof_real() == 8 ? "double" : "float");
}

static int run(int argc, char *argv[])
{
    const char *option[OPTION_COUNT] = {NULL};
    const command *chosen;

    if (argc < 2) {
        WRONG_USE("which command?");
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        print_help();
        return CLI_DONE;
    }
    if (strcmp(argv[1], "--version") == 0) {
        print_version();
        return CLI_DONE;
    }
    chosen = find_command(argv[1]);
    parse(option, chosen, argc - 1, argv + 1);
    return chosen->run(option);
}

int main(int argc, char *argv[])
{
    int status;

    if (rigcal_sizeof_real() != (int32_t)sizeof(rigcal_real)) {
        cli_fail("built for another rigcal_real than the library");
    }
    status = run(argc, argv);
    if (fflush(stdout) != 0 || ferror(stdout)) {
        cli_fail("standard output: %s", strerror(errno));
    }
    return status;
}
