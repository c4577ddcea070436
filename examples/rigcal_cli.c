/* rigcal - the library from the command line, on the files of data/FORMAT.md. */
#include <getopt.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "cli_os.h"

/* In several parts, because a C99 compiler may refuse a string of more than 4095 bytes. */
static const char HELP_USAGE[] =
    "rigcal - where each camera of a rig is, from a few points of known shape\n"
    "\n"
    "  rigcal calibrate   --cameras FILE --observations FILE [--out FOLDER]\n"
    "                     [--sigma PIXELS] [--weigh]\n"
    "                     [--robust [--threshold PIXELS] [--seed NUMBER]]\n"
    "                     [--hold CAMERA]... [--prior FILE]\n"
    "                     [--times FILE|frames [--clocks [--drift]]\n"
    "                     [--sigma-time TIME]]\n"
    "                     [--intrinsics-sigma F,ASPECT,CENTRE,K1,K2\n"
    "                     [--estimate-intrinsics]]\n"
    "                     [--method ml|paper] [--progress]\n"
    "  rigcal triangulate --cameras FILE --rig FILE --observations FILE\n"
    "                     [--targets FILE] [--sigma PIXELS]\n"
    "  rigcal line        --cameras FILE --rig FILE --from CAMERA --to CAMERA\n"
    "                     --pixel U,V [--depth NEAR,FAR] [--sigma PIXELS]\n"
    "                     [--probability P] [--candidates FILE]\n"
    "  rigcal monitor     --rig FILE (--matches FILE | --observations FILE\n"
    "                     --times FILE) [--sigma PIXELS] [--arl0 FRAMES]\n"
    "                     [--common SHARE] [--wrong SHARE] [--walk DEGREES,LENGTH]\n"
    "  rigcal --help | --version\n"
    "\n";

static const char HELP_CALIBRATE[] =
    "calibrate finds every camera's pose and the rig that they form. Views that\n"
    "contradict the others are left out: the first lines say which, why, and what to\n"
    "do.\n"
    "  --out        the folder for poses.csv, rig.csv, rig.bin, targets.csv,\n"
    "               pairs.csv, residuals.csv, summary.json, faults.csv and clocks.csv.\n"
    "               It is made if it does not exist.\n"
    "  --sigma      the noise of one pixel coordinate. Fits and uncertainties are\n"
    "               judged by it; without it, by the residuals.\n"
    "  --weigh      weighs every point by 1 / sigma_px^2, a column of the observations:\n"
    "               in the poses of views, in the rig and in all uncertainties. The\n"
    "               noise that is stated or found is then that of the usual point, the\n"
    "               median of the column. Without --weigh all points count alike.\n"
    "  --robust     leaves out points that disagree with the others by more than\n"
    "               --threshold (4 x --sigma; without --sigma 3 pixels).\n"
    "               --seed chooses other random samples; 1 if not given.\n"
    "  --hold       a camera that stays where it is. One alone: the rig is in its\n"
    "               frame. Several: --prior tells where they are.\n"
    "  --prior      an earlier rig.csv: what is known of the cameras beforehand. Its\n"
    "               covariances count; a camera whose covariance is 0 is held.\n"
    "               It needs --sigma. Remove the lines of cameras that moved.\n"
    "  --times      when each picture was taken: a file with the columns frame,\n"
    "               camera, time_s. Then clocks that differ can be found. frames: the\n"
    "               numbers of the frames serve as times.\n"
    "  --clocks     estimates how late each camera is against the first, with the\n"
    "               rig. --drift: and how fast its clock runs.\n"
    "  --sigma-time the noise of a time by itself: in seconds, or in frames.\n"
    "  --intrinsics-sigma\n"
    "               standard deviations of every camera's intrinsics: of f and of\n"
    "               fx / fy as parts of them, of the centre in pixels, of k1 and of k2.\n"
    "               The uncertainties of the rig contain them.\n"
    "  --estimate-intrinsics\n"
    "               lets the recording change the intrinsics as far as these deviations\n"
    "               allow, says what it moved, and writes cameras.csv. Only where the\n"
    "               deviations are honest; without --times.\n"
    "  --method     ml, the default: the maximum-likelihood poses and rig, and their\n"
    "               uncertainties. paper: the published procedure, without --sigma,\n"
    "               --weigh, --robust, --hold and --prior.\n"
    "  --progress   prints on standard error how much of the work is done, line by\n"
    "               line, for programs that show it. A terminal shows it anyway.\n"
    "\n";

static const char HELP_OTHERS[] =
    "triangulate measures the points that two or more cameras observed. It prints\n"
    "CSV.\n"
    "  --targets    gives the points in the target's frame; without it they are in\n"
    "               the first camera's.\n"
    "  --sigma      the noise of one pixel coordinate. Without it, it is that of the\n"
    "               rig.csv of calibrate; of another one it is estimated.\n"
    "With the covariances of such a rig.csv the sigmas have the error of the\n"
    "calibration, and views that contradict the others are left out and named.\n"
    "\n"
    "line takes a pixel of camera --from and finds the line in the image of camera\n"
    "--to on which the same point lies. It prints CSV: the line as alpha u + beta v +\n"
    "gamma = 0 in pixels without distortion, and its ends in the image.\n"
    "  --depth      adds the part between two depths along the axis of --from.\n"
    "With the rig.csv of calibrate, or --sigma, also the band in which the match is.\n"
    "  --sigma      the noise of one pixel coordinate, of both cameras.\n"
    "  --probability  that of the band, 0.99 if not given. Adds the spans: for each\n"
    "               row of the image the columns to search.\n"
    "  --candidates a CSV file with columns u and v: those in the band, best first.\n"
    "\n"
    "monitor watches a calibrated rig by points that two cameras see at once. It prints\n"
    "CSV, a line a frame: the evidence that a camera moved, 0 or more is an alarm, and\n"
    "all poses. After an alarm it says who moved and solves that camera anew.\n"
    "  --rig        rig.csv of calibrate, with the rig.bin beside it.\n"
    "  --matches    CSV: time_s,camera_a,u_a,v_a,camera_b,u_b,v_b. Lines of one time\n"
    "               are a frame.\n"
    "  --observations, --times\n"
    "               observations.csv, and CSV: frame,time_s, or frame,camera,time_s,\n"
    "               whose mean is the frame's. Points that two cameras saw in a frame\n"
    "               are matches.\n"
    "  --sigma      the noise of one pixel coordinate; without it, that of the rig.\n"
    "  --arl0       the mean number of frames between false alarms; 1000000.\n"
    "  --common     how far the matches of a frame err together, 0 to 1; 0.5.\n"
    "  --wrong      the share of wrong matches that is expected; 0.1.\n"
    "  --walk       how far cameras wander in a second: a random walk; 0,0.\n"
    "\n";

static const char HELP_END[] =
    "examples/data/FORMAT.md describes the files, and how to make them from those of\n"
    "OpenCV, Kalibr, ROS, COLMAP, MATLAB and others.\n"
    "\n"
    "Exit status: 0 all is done, or no more is wrong than that a view fits badly. 1\n"
    "something could not be computed or was left out: the first lines name it, and the\n"
    "rest is done; of monitor, there was an alarm. 2 wrong use, a file at fault, or\n"
    "output that could not be written: no file was written.\n";

static void print_help(void)
{
    fputs(HELP_USAGE, stdout);
    fputs(HELP_CALIBRATE, stdout);
    fputs(HELP_OTHERS, stdout);
    fputs(HELP_END, stdout);
}

#define BIT(option) (1U << (option))

typedef struct {
    const char *name;
    cli_command *run;
    unsigned required, optional;
} command;

static const command COMMANDS[] = {
    {"calibrate", cli_calibrate, BIT(OPTION_CAMERAS) | BIT(OPTION_OBSERVATIONS),
     BIT(OPTION_OUT) | BIT(OPTION_METHOD) | BIT(OPTION_SIGMA) | BIT(OPTION_ROBUST) |
         BIT(OPTION_THRESHOLD) | BIT(OPTION_SEED) | BIT(OPTION_HOLD) | BIT(OPTION_PRIOR) |
         BIT(OPTION_TIMES) | BIT(OPTION_CLOCKS) | BIT(OPTION_DRIFT) |
         BIT(OPTION_SIGMA_TIME) | BIT(OPTION_INTRINSICS_SIGMA) |
         BIT(OPTION_ESTIMATE_INTRINSICS) | BIT(OPTION_PROGRESS) | BIT(OPTION_WEIGH)},
    {"triangulate", cli_triangulate,
     BIT(OPTION_CAMERAS) | BIT(OPTION_RIG) | BIT(OPTION_OBSERVATIONS),
     BIT(OPTION_TARGETS) | BIT(OPTION_SIGMA)},
    {"line", cli_line,
     BIT(OPTION_CAMERAS) | BIT(OPTION_RIG) | BIT(OPTION_FROM) | BIT(OPTION_TO) |
         BIT(OPTION_PIXEL),
     BIT(OPTION_DEPTH) | BIT(OPTION_SIGMA) | BIT(OPTION_PROBABILITY) |
         BIT(OPTION_CANDIDATES)},
    {"monitor", cli_monitor, BIT(OPTION_RIG),
     BIT(OPTION_MATCHES) | BIT(OPTION_OBSERVATIONS) | BIT(OPTION_TIMES) |
         BIT(OPTION_SIGMA) | BIT(OPTION_ARL0) | BIT(OPTION_COMMON) | BIT(OPTION_WRONG) |
         BIT(OPTION_WALK)},
};

enum { HELP_OPTION = OPTION_COUNT, VERSION_OPTION };

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
    {"hold", required_argument, NULL, OPTION_HOLD},
    {"prior", required_argument, NULL, OPTION_PRIOR},
    {"probability", required_argument, NULL, OPTION_PROBABILITY},
    {"candidates", required_argument, NULL, OPTION_CANDIDATES},
    {"matches", required_argument, NULL, OPTION_MATCHES},
    {"times", required_argument, NULL, OPTION_TIMES},
    {"arl0", required_argument, NULL, OPTION_ARL0},
    {"common", required_argument, NULL, OPTION_COMMON},
    {"wrong", required_argument, NULL, OPTION_WRONG},
    {"walk", required_argument, NULL, OPTION_WALK},
    {"clocks", no_argument, NULL, OPTION_CLOCKS},
    {"drift", no_argument, NULL, OPTION_DRIFT},
    {"sigma-time", required_argument, NULL, OPTION_SIGMA_TIME},
    {"intrinsics-sigma", required_argument, NULL, OPTION_INTRINSICS_SIGMA},
    {"estimate-intrinsics", no_argument, NULL, OPTION_ESTIMATE_INTRINSICS},
    {"progress", no_argument, NULL, OPTION_PROGRESS},
    {"weigh", no_argument, NULL, OPTION_WEIGH},
    {"help", no_argument, NULL, HELP_OPTION},
    {"version", no_argument, NULL, VERSION_OPTION},
    {NULL, 0, NULL, 0},
};

/* Wrong use of an option: prints the message, and where help is. */
#define WRONG_USE(...) (cli_say(__VA_ARGS__), hint())

static CLI_NORETURN void hint(void)
{
    cli_fail("run rigcal --help for the commands and their options");
}

void cli_numbers(double numbers[], size_t count, const char *option, const char *text)
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
        WRONG_USE("%s takes %lu number%s, not \"%s\"", option, (unsigned long)count,
                  count > 1 ? "s with a comma between" : "", text);
    }
}

double cli_pixels(const char *option, const char *text, double least)
{
    static const double MOST = 1e6;
    double pixels;

    cli_numbers(&pixels, 1, option, text);
    if (!(pixels >= least && pixels <= MOST)) {
        cli_fail("%s is from %g to %g pixels, not \"%s\"", option, least, MOST, text);
    }
    return pixels;
}

double cli_sigma(const char *text)
{
    return cli_pixels("--sigma", text, 1e-6);
}

static void print_version(void)
{
    const int version = (int)rigcal_version();

    printf("rigcal %d.%d.%d (%s)\n", version / 10000, version / 100 % 100, version % 100,
           rigcal_sizeof_real() == 8 ? "double" : "float");
}

static CLI_NORETURN void refuse_option(const command *chosen, char *const argv[])
{
    if (optopt > ' ') {
        WRONG_USE("%s has no option -%c", chosen->name, optopt);
    }
    WRONG_USE("%s has no option %s", chosen->name, argv[optind - 1]);
}

/* If the value of an option is missing, getopt takes the next option as the value. With =
 * the value is intended: then the word of argv is longer than the value. */
static int is_option(const char *value, const char *word)
{
    return value != NULL && value == word && strncmp(value, "--", 2) == 0;
}

/* Takes one option from getopt_long. Returns 0 for --help and --version, after which
 * nothing else is done. */
static int take_option(const char *option[OPTION_COUNT], const command *chosen, int given,
                       char *const argv[])
{
    if (given == ':') {
        WRONG_USE("%s needs a value behind it", argv[optind - 1]);
    } else if (given == '?') {
        refuse_option(chosen, argv);
    } else if (given == HELP_OPTION) {
        print_help();
        return 0;
    } else if (given == VERSION_OPTION) {
        print_version();
        return 0;
    } else if (!((chosen->required | chosen->optional) & BIT(given))) {
        WRONG_USE("%s has no option --%s", chosen->name, OPTIONS[given].name);
    } else if (option[given] != NULL && given != OPTION_HOLD) {
        WRONG_USE("--%s is given twice: give it once", OPTIONS[given].name);
    } else if (is_option(optarg, argv[optind - 1])) {
        WRONG_USE("--%s needs a value, and %s follows. If that is the value, write "
                  "--%s=%s",
                  OPTIONS[given].name, optarg, OPTIONS[given].name, optarg);
    }
    option[given] = option[given] != NULL ? cli_text("%s,%s", option[given], optarg)
                    : optarg != NULL      ? optarg
                                          : "";
    return 1;
}

/* Returns 0 if only help or the version was wanted. */
static int parse(const char *option[OPTION_COUNT], const command *chosen, int argc,
                 char *argv[])
{
    int given, i;

    opterr = 0;
    while ((given = getopt_long(argc, argv, ":", OPTIONS, NULL)) != -1) {
        if (!take_option(option, chosen, given, argv)) {
            return 0;
        }
    }
    if (optind < argc) {
        WRONG_USE("%s takes options only, not \"%s\"", chosen->name, argv[optind]);
    }
    for (i = 0; i < OPTION_COUNT; i++) {
        if ((chosen->required & BIT(i)) && option[i] == NULL) {
            WRONG_USE("%s needs --%s", chosen->name, OPTIONS[i].name);
        }
    }
    return 1;
}

static const command *find_command(const char *name)
{
    size_t i;

    for (i = 0; i < sizeof COMMANDS / sizeof COMMANDS[0]; i++) {
        if (strcmp(name, COMMANDS[i].name) == 0) {
            return &COMMANDS[i];
        }
    }
    WRONG_USE("there is no command \"%s\": the commands are calibrate, "
              "triangulate, line and monitor",
              name);
}

static int run(int argc, char *argv[])
{
    const char *option[OPTION_COUNT] = {NULL};
    const command *chosen;

    if (argc < 2) {
        WRONG_USE("give a command: calibrate, triangulate, line or monitor");
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
    return parse(option, chosen, argc - 1, argv + 1) ? chosen->run(option) : CLI_DONE;
}

int main(int argc, char *argv[])
{
    int status;

    cli_os_begin(&argc, &argv);
    if (rigcal_sizeof_real() != (int32_t)sizeof(rigcal_real)) {
        cli_fail("this program and the library differ in rigcal_real: build both "
                 "with the same RIGCAL_REAL");
    }
    status = run(argc, argv);
    cli_flush_stdout("");
    return status;
}
