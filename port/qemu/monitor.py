#!/usr/bin/env python3
"""What a monitor costs on the emulated targets: instructions a frame and of its end, stack,
memory, flash: two Markdown tables of BENCHMARKS.md.

    monitor.py [FRAMES]           300 frames a line
    monitor.py --check [FRAMES]   fails if four cameras cost more than the limits below
"""
import argparse
import sys

import figures

# target, optimisation, number of cameras
LINES = [("cortex-m4f", "-O2", 2), ("cortex-m4f", "-O2", 3), ("cortex-m4f", "-O2", 4),
         ("cortex-m4f", "-O2", 8), ("cortex-m4f", "-Os", 4), ("cortex-m7", "-O2", 3),
         ("cortex-m0", "-Os", 2)]

# Limits for four cameras on the Cortex-M4F, -O2: a frame, and its end.
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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", nargs="?", type=int, default=300, metavar="FRAMES")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    is_over = False
    flash = []
    print("| target | cameras | frame | at most | its end | at most | after an alarm | stack | monitor |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    figures.plugin()
    for target, optimisation, cameras in LINES:
        image = figures.Image(target, "float", optimisation)
        elf, counts = image.dir / "monitor.elf", image.dir / "monitor_counts.txt"
        some = options.frames if target != "cortex-m0" else min(options.frames, 100)
        memory = [m.replace("=4096", "=3072") for m in image.memory]
        figures.run(image.gcc, *image.flags, f"-DCAMERAS={cameras}", f"-DFRAMES={some}",
                    figures.HERE / "monitor.c", image.library, "-lm", "--crt0=semihost",
                    "--oslib=semihost", "-Wl,--gc-sections", *memory, "-o", elf)
        printed = figures.run("sh", figures.HERE / "run.sh", target, elf, "-plugin",
                              f"{figures.BUILD}/count.so,out={counts}").splitlines()
        alarms = [int(line.split()[1]) for line in printed if line.startswith("frame")]
        numbers = figures.intervals(counts.read_text().splitlines())
        wholes = [a + b for a, b in zip(numbers[::2], numbers[1::2])]
        ends = numbers[1::2]
        of_alarm = [w for w, a in zip(wholes, alarms) if a]
        _, stack, _, size = printed[-1].split()
        print(f"| {target} {optimisation} | {cameras} | {sum(wholes) // len(wholes)} | {max(wholes)} | "
              f"{sum(ends) // len(ends)} | {max(ends)} | {sum(of_alarm) // max(len(of_alarm), 1)} | "
              f"{stack} | {size} |", flush=True)
        print(" ".join(line for line in printed if line.startswith("blamed")), file=sys.stderr)
        if (target, optimisation, cameras) == ("cortex-m4f", "-O2", 4):
            is_over = max(wholes) > LIMIT_FRAME or max(ends) > LIMIT_END
        if optimisation == "-Os":
            for row, functions in FLASH.items():
                own, libraries = image.flash(functions)
                flash.append(f"| {target} -Os | {row} | {own} | {own + libraries} |")
    print("\n| target | flash | rigcal | with libraries |\n| --- | --- | ---: | ---: |")
    print("\n".join(flash))
    if is_over and options.check:
        sys.exit("monitor: a frame of four cameras takes too long")


if __name__ == "__main__":
    main()
