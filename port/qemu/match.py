#!/usr/bin/env python3
"""What matching costs on a Cortex-M4F: two Markdown tables of BENCHMARKS.md, instructions of
each call, and bytes of memory and flash.

    match.py [BANDS]    400 random bands of Brown lenses in images of 640 x 480
"""
import sys

import figures

ROWS = ["the ray of a pixel of a (`rigcal_ray_make`)",
        "the band from that ray (`rigcal_band_make_ray`)",
        "the band from the pixel of a (`rigcal_band_make`)",
        "a ray of b (`rigcal_ray_make`)",
        "a candidate as such a ray, 20 at once (`rigcal_band_search_rays`)",
        "all spans of the image (`rigcal_spans_find`)"]
CANDIDATES = 20
IMAGE = ["rigcal_camera_ray", "rigcal_camera_project"]
BANDS = ["rigcal_match_k", "rigcal_ray_make", "rigcal_band_make_ray", "rigcal_band_search_rays"]
SPANS = ["rigcal_spans_begin", "rigcal_spans_step", "rigcal_spans_row", "rigcal_spans_result"]


def main():
    bands = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    figures.plugin()
    image = figures.Image("cortex-m4f", "float", "-O2")
    elf, counts = image.dir / "match.elf", image.dir / "match_counts.txt"
    figures.run(image.gcc, *image.flags, f"-DBANDS={bands}", figures.HERE / "match.c", image.library,
                "-lm", "--crt0=semihost", "--oslib=semihost", "-Wl,--gc-sections", *image.memory, "-o", elf)
    printed = figures.run("sh", figures.HERE / "run.sh", image.target, elf, "-plugin",
                          f"{figures.BUILD}/count.so,out={counts}").splitlines()
    numbers = figures.intervals(counts.read_text().splitlines())
    statuses = [int(line.split()[1]) for line in printed[:-1]]
    print(f"of {bands} bands, {sum(s == 0 for s in statuses)} have spans", file=sys.stderr)
    print("| instructions, Cortex-M4F -O2 | mean | half at most | 99 % at most | most |\n"
          "| --- | ---: | ---: | ---: | ---: |")
    for i, row in enumerate(ROWS):
        own = sorted(n // (CANDIDATES if "20 at once" in row else 1) for n in numbers[i::len(ROWS)])
        print(f"| {row} | {sum(own) // len(own)} | {own[len(own) // 2]} | {own[99 * len(own) // 100]} | "
              f"{own[-1]} |")
    _, band, _, ray, _, spans = printed[-1].split()
    small = figures.Image("cortex-m4f", "float", "-Os")
    flash = [sum(small.flash(functions)) for functions in
             (IMAGE, IMAGE + BANDS, IMAGE + BANDS + SPANS)]
    print("\n| bytes, float | |\n| --- | ---: |")
    print(f"| a `rigcal_band` | {band} |\n| a `rigcal_ray` | {ray} |\n| a `rigcal_spans_solver` | {spans} |")
    print(f"| flash, -Os: bands and candidates, beyond rays and projection | {flash[1] - flash[0]} |")
    print(f"| flash, -Os: spans, beyond that | {flash[2] - flash[1]} |")


if __name__ == "__main__":
    main()
