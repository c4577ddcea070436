#!/usr/bin/env python3
"""What the library costs on the emulated targets, and whether its bits agree.

    figures.py            measures and compares with port/qemu/README.md: fails where
                          a figure has grown by more than 2 %. The steps of the solvers
                          are measured in every fifth scene
    figures.py --update   measures the steps in all scenes, and writes the figures into
                          port/qemu/README.md
    figures.py --profile TARGET OPTIMISATION JOB
                          instructions of one job, function by function

Instructions are counted by count.c, stack by a pattern, flash in an image of what a
job's functions pull in and nothing else. The results of all float images for
size must be the same bits, and those of all for speed.
"""
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BUILD = ROOT / "build/figures"
README = HERE / "README.md"
BEGIN, END = "<!-- figures: begin -->", "<!-- figures: end -->"

# a figure that grew by less is not reported
SLACK = 1.02

# When figures are compared, steps.c measures one scene in this many.
STEPS_ONE_IN = 5

# The assumption by which milliseconds are estimated. It includes flash wait states.
CLOCK_MHZ, CYCLES = 64, (1.2, 1.5)

# Target, precision, optimisation, and the build: all, or what port/template's
# rigcal_config_small.h leaves.
COLUMNS = [("cortex-m0", "float", "-Os"), ("cortex-m0", "float", "-Os", "small"),
           ("cortex-m4f", "float", "-Os"), ("cortex-m4f", "float", "-Os", "small"),
           ("cortex-m4f", "float", "-O2"), ("cortex-m33", "float", "-O2"),
           ("cortex-m7", "float", "-O2"), ("cortex-m7", "double", "-O2"),
           ("rv32imac", "float", "-Os"), ("rv32imafc", "float", "-O2")]

# Presets whose library has the options of a column, except for -g1.
PRESETS = {("cortex-m0", "float", "-Os"): "cortex-m0",
           ("rv32imac", "float", "-Os"): "rv32imac",
           ("cortex-m4f", "float", "-O2"): "cortex-m4f",
           ("cortex-m33", "float", "-O2"): "cortex-m33",
           ("cortex-m7", "float", "-O2"): "cortex-m7",
           ("cortex-m7", "double", "-O2"): "cortex-m7-double",
           ("rv32imafc", "float", "-O2"): "rv32imafc"}

# For each row: the functions whose flash is counted.
FLASH = {
    "project": ["rigcal_camera_project"],
    "pixel_to_ray": ["rigcal_camera_ray"],
    "solve_pose": ["rigcal_pose_solve"],
    "pose_covariance": ["rigcal_pose_covariance"],
    "triangulate": ["rigcal_point_triangulate"],
    "epiline_px": ["rigcal_epiline_px"],
    "relative_pose": ["rigcal_transform_between"],
    "point_measure": ["rigcal_point_measure"],
    "point_measure, point_distance": ["rigcal_point_measure", "rigcal_point_distance"],
    "solve_pose, triangulate, epiline_px":
        ["rigcal_pose_solve", "rigcal_point_triangulate", "rigcal_epiline_px"],
    "solve_pose and rig": ["rigcal_pose_solve", "rigcal_rig_adjust", "rigcal_rig_covariance"],
    "solve_pose and rig with join":
        ["rigcal_pose_solve", "rigcal_view_pose_make", "rigcal_rig_join", "rigcal_rig_adjust",
         "rigcal_rig_covariance"],
    "solve_pose and rig, chosen and judged":
        ["rigcal_pose_solve", "rigcal_view_pose_make", "rigcal_rig_choose", "rigcal_rig_judge",
         "rigcal_rig_covariance"],
    "solve_pose and rig with clocks":
        ["rigcal_pose_solve", "rigcal_rig_adjust", "rigcal_rig_covariance",
         "rigcal_clocks_defaults", "rigcal_clocks_sigma", "rigcal_clocks_frames"],
    "solve_pose and rig with faults in words":
        ["rigcal_pose_solve", "rigcal_rig_adjust", "rigcal_rig_covariance", "rigcal_rig_faults",
         "rigcal_faults_text"],
}

# Without an FPU: the jobs of a rig take minutes there, and the Cortex-M0 has no RAM for them.
WITHOUT_RIG = ("cortex-m0", "rv32imac")

# Limits that hold whatever was measured before: table, row, column, limit.
LIMITS = [
    ("Instructions", "solve_pose_4", "cortex-m4f float -O2", 120000),
    ("Instructions", "solve_pose_4_warm", "cortex-m4f float -O2", 30000),
    ("Instructions", "solve_pose_8", "cortex-m4f float -O2", 160000),
    ("Instructions at most", "measure_2", "cortex-m4f float -O2", 13000),
    ("Instructions at most", "measure_4", "cortex-m4f float -O2", 25000),
    ("Stack", "solve_pose_8", "cortex-m0 float -Os", 4096 - 512),
    ("Flash with libraries", "solve_pose", "cortex-m0 float -Os", 24 * 1024),
    ("Flash with libraries", "solve_pose, triangulate, epiline_px",
     "cortex-m4f float -Os small", 16 * 1024),
    ("Flash with libraries", "solve_pose, triangulate, epiline_px",
     "cortex-m4f float -Os", 20 * 1024),
    *[("Stack", f"solve_pose_{job}", column, limit)
      for job in ("3", "tag", "4", "8", "8_lens", "50")
      for column, limit in (("cortex-m7 double -O2", 2048), ("cortex-m4f float -O2", 1229))],
]


def run(*command, **more):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True,
                          cwd=ROOT, **more)
    if done.returncode:
        sys.exit(f"figures: {' '.join(map(str, command))}\n{done.stdout[-2000:]}{done.stderr}")
    return done.stdout


class Image:
    """The library of one column, and images linked with it."""

    def __init__(self, target, real, optimisation, extent="all"):
        is_small = extent == "small"
        self.target = target
        self.title = f"{target} {real} {optimisation}" + " small" * is_small
        self.dir = BUILD / self.title.replace(" ", "")
        self.dir.mkdir(parents=True, exist_ok=True)
        words = dict(re.findall(r'^set\((\w+) "?([^")]*)"?\)', (HERE / f"{target}.cmake").read_text(), re.M))
        self.gcc = words["prefix"] + "gcc"
        self.flags = [*words["cpu"].split(), "--specs=picolibc.specs", "-std=c99", optimisation,
                      "-ffp-contract=off", "-ffunction-sections", "-fdata-sections", "-Iinclude",
                      *(["-DRIGCAL_USE_FLOAT=1"] if real == "float" else []),
                      *(["-Iport/template", "-DRIGCAL_CONFIG_FILE=<rigcal_config_small.h>"]
                        if is_small else [])]
        names = ("__flash", "__flash_size", "__ram", "__ram_size")
        values = words["flash"].split() + words["ram"].split()
        self.memory = [f"-Wl,--defsym={n}={v}" for n, v in zip(names, values)]
        self.memory.append("-Wl,--defsym=__stack_size=4096")
        preset = PRESETS.get((target, real, optimisation)) if extent == "all" else None
        if preset:
            self.library = ROOT / "build" / preset / "librigcal.a"
            run("sh", "-c", f". tests/support/steps.sh; preset_build {preset} rigcal")
        else:
            self.library = self.dir / "librigcal.a"
            self.compile(words["prefix"])

    def compile(self, prefix):
        self.library.unlink(missing_ok=True)
        objects = []
        for source in sorted((ROOT / "src").glob("*.c")):
            objects.append(self.dir / (source.stem + ".o"))
            run(self.gcc, *self.flags, "-DRIGCAL_BUILD", "-c", source, "-o", objects[-1])
        run(prefix + "ar", "rcs", self.library, *objects)

    def jobs(self, *defines):
        image = self.dir / "jobs.elf"
        if self.target in WITHOUT_RIG:
            defines = [*defines, "-DJOBS_RIG=0"]
        run(self.gcc, *self.flags, *defines, HERE / "jobs.c", self.library, "-lm",
            "--crt0=semihost", "--oslib=semihost", "-Wl,--gc-sections", *self.memory, "-o", image)
        counts = self.dir / "counts.txt"
        printed = run("sh", HERE / "run.sh", self.target, image,
                      "-plugin", f"{BUILD}/count.so,out={counts}")
        (self.dir / "jobs.txt").write_text(printed)
        lines = printed.splitlines()
        self.bytes = [line.split()[1:] for line in lines if line.startswith("bytes ")]
        lines = [line for line in lines if not line.startswith("bytes ")]
        return lines, counts.read_text().splitlines()

    def steps(self, one_in):
        """The table of steps.c, which measures one scene in one_in. The program ends if
        steps.c complains."""
        image = self.dir / "steps.elf"
        run(self.gcc, *self.flags, "-misa-spec=2.2", f"-DSTEPS_ONE_IN={one_in}", "-Isrc",
            HERE / "steps.c", self.library, "-lm", "--crt0=semihost", "--oslib=semihost", "-Wl,--gc-sections", *self.memory, "-o", image)
        return run("sh", HERE / "run.sh", self.target, image, "-icount", "shift=0")

    def flash(self, functions):
        """Bytes of flash: (of the library, of the C library and the compiler)."""
        link_map = self.dir / "flash.map"
        run(self.gcc, *self.flags, "-nostartfiles", "-Wl,-e,0", "-Wl,--gc-sections", *self.memory,
            *[f"-Wl,-u,{name}" for name in functions], self.library, "-lm",
            f"-Wl,-Map={link_map}", "-o", self.dir / "flash.elf")
        text = link_map.read_text().split("Linker script and memory map")[1]
        ours = others = 0
        for section, size, origin in re.findall(
                r"^ (\.\S+)\s+0x[0-9a-f]+\s+0x([0-9a-f]+) (\S+)$", text, re.M):
            if section.startswith((".text", ".rodata", ".data", ".srodata", ".sdata")):
                if "librigcal.a" in origin:
                    ours += int(size, 16)
                elif ".a(" in origin:
                    others += int(size, 16)
        return ours, others


def plugin():
    BUILD.mkdir(parents=True, exist_ok=True)
    run("gcc", "-O2", "-shared", "-fPIC", HERE / "count.c", "-o", BUILD / "count.so")


def intervals(counts):
    return [int(line.split()[1]) for line in counts if line.startswith("interval")]


def measure(steps_one_in):
    """{table: {row: {column: figure}}} and the bits of each float column."""
    tables = {name: {} for name in ("Instructions", "Instructions at most", "Stack", "RAM",
                                   "Flash", "Flash with libraries")}
    bits = {}
    for column in COLUMNS:
        image = Image(*column)
        printed, counts = image.jobs()
        numbers = intervals(counts)
        if len(numbers) != len(printed):
            sys.exit(f"figures: {len(numbers)} intervals of {len(printed)} jobs on {image.title}")
        jobs = {}
        for line, number in zip(printed, numbers):
            name, status, stack = line.split()[:3]
            if int(status) < 0 or int(stack) < 0:
                sys.exit(f"figures: {line} on {image.title}")
            jobs.setdefault(name, []).append((number, int(stack)))
        for name, list_ in jobs.items():
            mean = round(sum(n for n, _ in list_) / len(list_))
            for table, value in (("Instructions", mean), ("Instructions at most", max(n for n, _ in list_)),
                                 ("Stack", max(s for _, s in list_))):
                tables[table].setdefault(name, {})[image.title] = value
        for row, number in image.bytes:
            tables["RAM"].setdefault(row, {})[image.title] = int(number)
        for row, functions in FLASH.items():
            ours, others = image.flash(functions)
            tables["Flash"].setdefault(row, {})[image.title] = ours
            tables["Flash with libraries"].setdefault(row, {})[image.title] = ours + others
        if column[0] == "rv32imafc":
            tables |= from_text("### Steps\n" + image.steps(steps_one_in))
        if column[1] == "float":
            bits[image.title] = [" ".join(line.split()[:2] + line.split()[3:]) for line in printed]
    return tables, bits


def disagreements(bits):
    """Compares the images for size with each other, and those for speed: RIGCAL_FOR_SPEED
    changes bits."""
    for option in ("-Os", "-O2"):
        yield from disagreements_of({t: b for t, b in bits.items() if option in t})


def disagreements_of(bits):
    """Compares with the image that has all jobs. A small image, or one without a rig,
    leaves some out."""
    first = max(bits, key=lambda title: len(bits[title]))
    for title in bits:
        jobs = {line.split()[0] for line in bits[title]}
        expected = [line for line in bits[first] if line.split()[0] in jobs]
        leaves_out = title.endswith(" small") or title.split()[0] in WITHOUT_RIG
        if len(bits[title]) != len(expected if leaves_out else bits[first]):
            yield f"{title} prints {len(bits[title])} results, {first} {len(bits[first])}"
        for a, b in zip(expected, bits[title]):
            if a != b:
                yield f"bits differ:\n  {first}: {a}\n  {title}: {b}"
                break


def to_text(tables):
    lines = []
    for name, rows in tables.items():
        columns = list(dict.fromkeys(c for cells in rows.values() for c in cells))
        lines += [f"### {name}", "", "| | " + " | ".join(columns) + " |",
                  "| --- |" + " ---: |" * len(columns)]
        lines += [f"| {row} | " + " | ".join(str(cells.get(c, "")) for c in columns) + " |"
                  for row, cells in rows.items()]
        lines.append("")
    column = "cortex-m4f float -O2"
    lines += [f"At {CLOCK_MHZ} MHz, assuming that an instruction takes {CYCLES[0]} to {CYCLES[1]} cycles "
              f"({column}, mean):", ""]
    for row in ("solve_pose_tag", "solve_pose_8", "solve_pose_tag_warm", "triangulate_2",
                "rig_join_tag", "rig_adjust_tag", "rig_adjust_12_lens"):
        low, high = (tables["Instructions"][row][column] * c / CLOCK_MHZ / 1000 for c in CYCLES)
        lines.append(f"- {row}: {low:.2f} to {high:.2f} ms")
    return "\n".join(lines) + "\n"


def from_text(text):
    tables, rows, columns = {}, None, None
    for line in text.splitlines():
        if line.startswith("### "):
            rows, columns = tables.setdefault(line[4:], {}), None
        elif line.startswith("| ---"):
            continue
        elif line.startswith("|"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            if columns is None:
                columns = cells[1:]
            else:
                rows[cells[0]] = {c: int(v) for c, v in zip(columns, cells[1:]) if v}
    return tables


def flat(tables):
    return {(t, r, c): v for t, rows in tables.items() for r, cells in rows.items()
            for c, v in cells.items()}


def profile(target, optimisation, job):
    image = Image(target, "float", optimisation)
    printed, counts = image.jobs(f'-DJOBS_ONLY="{job}"')
    total = sum(intervals(counts))
    print(f"{total / len(printed):.0f} instructions, mean of {len(printed)}")
    rows = [line.split(None, 2)[1:] for line in counts if line.startswith("symbol")]
    for number, name in sorted(rows, key=lambda r: -int(r[0])):
        print(f"{int(number) / len(printed):10.0f} {100 * int(number) / total:5.1f} % {name}")


def main():
    plugin()
    if sys.argv[1:2] == ["--profile"] and len(sys.argv) == 5:
        return profile(*sys.argv[2:])
    if sys.argv[1:] not in ([], ["--update"]):
        sys.exit(__doc__)
    tables, bits = measure(1 if sys.argv[1:] else STEPS_ONE_IN)
    now = flat(tables)
    bad = list(disagreements(bits))
    bad += [f"{t}, {r}, {c}: {now[t, r, c]} is above the limit {limit}"
            for t, r, c, limit in LIMITS if now[t, r, c] > limit]
    head, rest = README.read_text().split(BEGIN)
    old_text, tail = rest.split(END)
    if sys.argv[1:] == ["--update"]:
        README.write_text(f"{head}{BEGIN}\n\n{to_text(tables)}\n{END}{tail}")
        run(sys.executable, ROOT / "tests/bench/quoted.py")  # the project's README.md has some of them
    else:
        then = flat(from_text(old_text))
        if then.keys() != now.keys():
            bad.append("the table's rows or columns are not those measured: --update it")
        for key in sorted(then.keys() & now.keys()):
            if now[key] > then[key] * SLACK:
                bad.append(f"{', '.join(key)}: {now[key]}, was {then[key]}")
    if bad:
        print("\n".join(bad))
        sys.exit(f"figures: {len(bad)} complaints")
    count = max(len(lines) for lines in bits.values())
    print(f"{len(now)} figures within 2 % of port/qemu/README.md; {count} results the same "
          f"bits in {len(bits)} float images")


if __name__ == "__main__":
    main()
