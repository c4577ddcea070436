#!/usr/bin/env python3
"""What a monitor costs on the emulated targets: instructions a frame and of its end, stack,
memory, flash.

    monitor.py [FRAMES]    the table, 300 frames a line; the cost of four cameras fails above
                           its limits
"""
import sys

import figures

# target, optimisation, cameras
LINES = [("cortex-m4f", "-O2", 2), ("cortex-m4f", "-O2", 3), ("cortex-m4f", "-O2", 4),
         ("cortex-m4f", "-O2", 8), ("cortex-m4f", "-Os", 4), ("cortex-m7", "-O2", 3),
         ("cortex-m0", "-Os", 2)]

# Of four cameras on the Cortex-M4F, -O2: a frame, and its end.
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
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    is_over = False
    figures.plugin()
    for target, optimisation, cameras in LINES:
        image = figures.Image(target, "float", optimisation)
        elf, counts = image.dir / "monitor.elf", image.dir / "monitor_counts.txt"
        some = frames if target != "cortex-m0" else min(frames, 100)
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
        print(f"{image.title}, {cameras} cameras: frame {sum(wholes) // len(wholes)}, at most "
              f"{max(wholes)}; its end {sum(ends) // len(ends)}, at most {max(ends)}; between "
              f"alarm and answer {sum(of_alarm) // max(len(of_alarm), 1)}; {printed[-1]}; "
              f"{' '.join(line for line in printed if line.startswith('blamed'))}")
        if (target, optimisation, cameras) == ("cortex-m4f", "-O2", 4):
            is_over = max(wholes) > LIMIT_FRAME or max(ends) > LIMIT_END
        if cameras in (2, 4) and optimisation == "-Os":
            for row, functions in FLASH.items():
                print(f"    flash, {row}: %d, with libraries %d" % ((lambda o, l: (o, o + l))(
                    *image.flash(functions))))
    sys.exit("monitor: a frame of four cameras takes too long" if is_over else 0)


if __name__ == "__main__":
    main()
