#!/usr/bin/env python3
"""The paper's experiments, made again and compared with what examples/paper keeps.

  check_paper.py [--all] [PROGRAM [SCENES]]    rigcal_paper, bench_paper_scenes

Of the long tables every third depth or resolution is made again, and the others are those
kept; of the random placements, the first third are judged by fits. --all makes all again.

The last bit of another math library may change the numbers: up to a hundredth of
the guesses of a map, up to a fiftieth of a number. Then this checks that
  - the tables agree with each other where two of them have the same numbers,
  - every claim has the answer that is known, judged from the new numbers,
  - independent fits confirm the solver that needs no guess,
  - README and figures are made from the numbers kept.
"""
import csv
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAPER = ROOT / "examples/paper"
sys.path.insert(0, str(PAPER))
import claims  # noqa: E402 -- lies there

PROGRAM = ROOT / "build/gcc-double/rigcal_paper"
SCENES = ROOT / "build/gcc-double/tests/bench_paper_scenes"
RELATIVE, ROUNDING, CELLS, ATTEMPTS = 0.02, 5e-9, 0.01, 0.01
PNG_BYTES_MAX = 150000

# The long tables make one depth or resolution in this many; which tables; the number of
# placements out of 1000.
EVERY, PLACEMENTS = 3, 333
LONG = ("fig06_share", "fig09", "fig10", "fig11", "fig12", "fig13", "fig14",
        "fig14_unsettled", "over_bound")


def number(text):
    try:
        return float(text)
    except ValueError:
        return None


def same(column, old, new, row):
    """Whether two fields of a CSV file say the same."""
    if old == new:
        return True
    if column == "outcomes_over_roll":
        return len(old) == len(new)  # a number that is counted over the whole file
    if number(old) is None or number(new) is None:
        return False
    if column in ("correct", "false", "behind", "n", "lost", "missing") or \
            column.endswith("_from_anywhere"):
        of = float(row.get("tried") or row.get("placements") or 2000)
        return abs(number(old) - number(new)) <= 2 + ATTEMPTS * of
    return abs(number(old) - number(new)) <= ROUNDING + RELATIVE * max(
        abs(number(old)), abs(number(new)))


def fill(name, kept, made):
    """Adds the kept rows of the depths and resolutions that were not made to those that
    were. Returns what is wrong with the rows that were made."""
    tables, heads = [], []
    for folder in (kept, made):
        with open(folder / f"{name}.csv", newline="") as file:
            head, *rows = csv.reader(file)
        heads.append(head)
        tables.append({})
        for row in rows:
            tables[-1].setdefault(tuple(row[:2]), []).append(row)
    old, new = tables
    if heads[0] != heads[1] or heads[0][:2] != ["depth_cm", "width_px"]:
        return [f"{name}.csv: other columns"]
    if not new.keys() <= old.keys() or len(new) * EVERY < len(old):
        return [f"{name}.csv: {len(new)} depths and resolutions made, of {len(old)}"]
    with open(made / f"{name}.csv", "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(
            [heads[0]] + [row for key in old for row in new.get(key, old[key])])
    return []


def compare(name, kept, made):
    """The differences, as a list of sentences."""
    tables = []
    for folder in (kept, made):
        with open(folder / name, newline="") as file:
            tables.append(list(csv.DictReader(file)))
    old, new = tables
    if len(old) != len(new) or (old and old[0].keys() != new[0].keys()):
        return [f"{name}: other rows or columns"]
    wrong, cells, differ = [], 0, 0
    for line, (a, b) in enumerate(zip(old, new), 2):
        for column in a:
            if not same(column, a[column], b[column], a):
                wrong.append(f"{name}:{line}: {column} was {a[column]}, is "
                             f"{b[column]}")
        for x, y in zip(a.get("outcomes_over_roll", ""),
                        b.get("outcomes_over_roll", "")):
            cells += 1
            differ += x != y
    if differ > CELLS * cells:
        wrong.append(f"{name}: {differ} of {cells} guesses lead elsewhere")
    return wrong


def check_counts(wrong, data):
    """Checks that counts from the guesses of a map agree with the map."""
    maps = {("3", "0", "2"): ("fig03", {"camera": "1", "pairs_used": "2"}),
            ("8", "1", "2"): ("fig08", {"camera": "1", "pairs_used": "2"}),
            ("5", "0", "2"): ("fig05_map", {"method": "two_angles"}),
            ("5", "0", "3"): ("fig05_map", {"method": "three_angles"})}
    compared = 0
    for row in claims.pick(claims.read(data, "counts"), guesses="map"):
        name, fields = maps[row["figure"], row["digital"], row["angles"]]
        fields = dict(fields, **({"yaw_error_deg": row["yaw_error_deg"]}
                                 if name == "fig05_map" else
                                 {"points": row["points"]}))
        cells = "".join(line["outcomes_over_roll"] for line in
                        claims.pick(claims.read(data, name), **fields))
        if not cells:
            continue  # there is no map for this error of yaw of figure 5
        compared += 1
        found = len(cells), cells.count("2"), cells.count("1")
        if found != tuple(int(row[k]) for k in ("tried", "correct", "false")):
            wrong.append(f"counts.csv: figure {row['figure']}, {row['points']} points: "
                         f"not as in {name}.csv: {found}")
    if compared != 6:
        wrong.append(f"counts.csv: {compared} counts are of maps, not 6")


def check_settling(wrong, data):
    """Checks the lines on camera 1: the true line holds the match, and the other lines are
    as far from it as the table says."""
    rows = claims.read(data, "fig14_settling")
    for row in rows:
        true, = claims.pick(rows, width_px=row["width_px"], point=row["point"],
                            method="true")
        u1, v1, u2, v2 = (float(row[k]) for k in ("u1", "v1", "u2", "v2"))
        length = ((u2 - u1) ** 2 + (v2 - v1) ** 2) ** 0.5

        def off(u, v):
            return abs((u2 - u1) * (v - v1) - (v2 - v1) * (u - u1)) / length

        worst = max(off(float(true["u1"]), float(true["v1"])),
                    off(float(true["u2"]), float(true["v2"])))
        where = f"{row['width_px']} px, point {row['point']}, {row['method']}"
        if abs(worst - float(row["off_inch"])) > 3e-5:  # the numbers have five digits
            wrong.append(f"fig14_settling.csv: {where}: off by {worst:.5f} inch")
        if row["method"] == "true" and off(float(row["match_u"]),
                                           float(row["match_v"])) > 3e-5:
            wrong.append(f"fig14_settling.csv: {where}: not through the match")


def check_kept(wrong):
    """Checks that README and the figures are those of the kept numbers."""
    readme = (PAPER / "README.md").read_text()
    if claims.with_tables(readme, PAPER / "data") != readme:
        wrong.append("README.md: its tables are not those of the data")
    digest = claims.digest(PAPER / "data")
    for svg in sorted((PAPER / "figures").glob("*.svg")):
        png = svg.with_suffix(".png")
        if f"numbers {digest}" not in svg.read_text():
            wrong.append(f"{svg.name}: not drawn from the data")
        if not png.exists() or png.stat().st_size > PNG_BYTES_MAX:
            wrong.append(f"{png.name}: missing, or too large")
        if f"(figures/{png.name})" not in readme:
            wrong.append(f"{png.name}: README.md does not show it")


def main():
    arguments = sys.argv[1:]
    is_all = arguments[:1] == ["--all"]
    arguments = arguments[is_all:] + [None, None]
    program, scenes = (pathlib.Path(a) if a else d
                       for a, d in zip(arguments, (PROGRAM, SCENES)))
    made = ROOT / "build/paper"
    made.mkdir(parents=True, exist_ok=True)
    for old in made.glob("*.csv"):
        old.unlink()
    subprocess.run([str(program), "-e", str(1 if is_all else EVERY), str(made)], check=True)

    wrong = []
    kept = PAPER / "data"
    if not is_all:
        for name in LONG:
            wrong += fill(name, kept, made)
    names = [sorted(p.name for p in folder.glob("*.csv"))
             for folder in (kept, made)]
    if names[0] != names[1]:
        wrong.append(f"other files: {set(names[0]) ^ set(names[1])}")
    for name in sorted(set(names[0]) & set(names[1])):
        wrong += compare(name, kept, made)
    check_counts(wrong, made)
    check_settling(wrong, made)
    check_kept(wrong)

    known = 0
    for figures, _, expected, holds, claim, measured in claims.judge(made):
        print(f"figure {figures}: {claim} {'yes' if holds else 'no'}: {measured}")
        known += holds == expected
        if holds != expected:
            wrong.append(f"figure {figures}: {claim} {'yes' if holds else 'no'}, "
                         f"which is news: {measured}")
    if subprocess.run([str(scenes), *([] if is_all else [str(PLACEMENTS)])]).returncode:
        wrong.append("the solver is wrong where the best minimum is right")
    if wrong:
        print("\n".join(wrong[:40]))
        sys.exit(f"check_paper: {len(wrong)} things are not as kept. When they "
                 "ought to be so: sh examples/paper/run.sh")
    print(f"{len(names[0])} tables as kept, {known} claims as known")


if __name__ == "__main__":
    main()
