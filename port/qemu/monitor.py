#!/usr/bin/env python3
"""What a monitor costs on the emulated targets: instructions a frame and of its end, stack,
memory, flash: two Markdown tables of BENCHMARKS.md.

    monitor.py [FRAMES]           300 frames a line
    monitor.py --check [FRAMES]   four cameras on the Cortex-M4F alone: fails if they cost
                                  more than the limits below
"""
import argparse
import sys

import figures

# target, optimisation, number of cameras
LINES = [("cortex-m4f", "-O2", 2), ("cortex-m4f", "-O2", 3), ("cortex-m4f", "-O2", 4),
         ("cortex-m4f", "-O2", 8), ("cortex-m4f", "-Os", 4), ("cortex-m7", "-O2", 3),
         ("cortex-m0", "-Os", 2)]

# What --check measures, and the limits of its means: a frame, and its end.
CHECKED = ("cortex-m4f", "-O2", 4)
LIMIT_FRAME, LIMIT_END = 100000, 25000

FLASH = {
    "matches": ["rigcal_monitor_begin", "rigcal_monitor_match", "rigcal_monitor_frame",
                "rigcal_monitor_moved", "rigcal_monitor_rig"],
    "matches by rays": ["rigcal_monitor_begin", "rigcal_monitor_match_rays",
                        "rigcal_monitor_frame", "rigcal_monitor_moved", "rigcal_monitor_rig"],
    "matches and targets": ["rigcal_monitor_begin", "rigcal_monitor_match",
                            "rigcal_monitor_view", "rigcal_monitor_lifted",
                            "rigcal_monitor_frame", "rigcal_monitor_moved",
                            "rigcal_monitor_rig", "rigcal_monitor_body"],
}


def count(image, cameras, frames):
    """The instructions of each frame and of its end, whether it had an alarm, and what was
    printed."""
    elf, counts = image.dir / "monitor.elf", image.dir / "monitor_counts.txt"
    memory = [m.replace("=4096", "=3072") for m in image.memory]
    figures.run(image.gcc, *image.flags, f"-DCAMERAS={cameras}", f"-DFRAMES={frames}",
                figures.HERE / "monitor.c", image.library, "-lm", "--crt0=semihost",
                "--oslib=semihost", "-Wl,--gc-sections", *memory, "-o", elf)
    printed = figures.run("sh", figures.HERE / "run.sh", image.target, elf, "-plugin",
                          f"{figures.BUILD}/count.so,out={counts}").splitlines()
    alarms = [int(line.split()[1]) for line in printed if line.startswith("frame")]
    numbers = figures.intervals(counts.read_text().splitlines())
    return [a + b for a, b in zip(numbers[::2], numbers[1::2])], numbers[1::2], alarms, printed


def mean(numbers):
    return sum(numbers) // max(len(numbers), 1)


def check(frames):
    target, optimisation, cameras = CHECKED
    wholes, ends, _, _ = count(figures.Image(target, "float", optimisation), cameras, frames)
    print(f"monitor: {mean(wholes)} instructions a frame, of at most {LIMIT_FRAME}, "
          f"{mean(ends)} of its end, of at most {LIMIT_END}")
    if mean(wholes) > LIMIT_FRAME or mean(ends) > LIMIT_END:
        sys.exit("monitor: a frame of four cameras takes too long")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", nargs="?", type=int, default=300, metavar="FRAMES")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    figures.plugin()
    if options.check:
        return check(options.frames)
    flash = []
    print("| target | cameras | frame | at most | its end | at most | after an alarm | stack | monitor |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for target, optimisation, cameras in LINES:
        image = figures.Image(target, "float", optimisation)
        some = options.frames if target != "cortex-m0" else min(options.frames, 100)
        wholes, ends, alarms, printed = count(image, cameras, some)
        of_alarm = [w for w, a in zip(wholes, alarms) if a]
        _, stack, _, size = printed[-1].split()
        print(f"| {target} {optimisation} | {cameras} | {mean(wholes)} | {max(wholes)} | "
              f"{mean(ends)} | {max(ends)} | {mean(of_alarm)} | {stack} | {size} |", flush=True)
        print(" ".join(line for line in printed if line.startswith("blamed")), file=sys.stderr)
        if optimisation == "-Os":
            for row, functions in FLASH.items():
                own, libraries = image.flash(functions)
                flash.append(f"| {target} -Os | {row} | {own} | {own + libraries} |")
    print("\n| target | flash | rigcal | with libraries |\n| --- | --- | ---: | ---: |")
    print("\n".join(flash))


if __name__ == "__main__":
    main()
