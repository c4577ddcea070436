#!/usr/bin/env python3
"""Stack and call graph of the library, from gcc's own account (-fcallgraph-info).

    check_callgraph.py [FOLDER]    also writes FOLDER/stack.txt

Refuses recursion, stack whose size is not known when compiling (arrays of
variable length, alloca) and calls through function pointers, so that the bound
on the stack of each public function is a proof. Refusals are judged at -O0,
where no call is hidden by inlining; the table of stack sizes is of optimised
code, for this machine and, where there is a compiler, for a Cortex-M4F. libm's
own stack comes on top.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Functions that may call through a pointer, and what of the library they may
# reach so: a cost, or a source of views, of the caller's, who knows its stack;
# what is given of a view, its points or its own pose; what intrinsics add to a covariance;
# the clocks of a rig.
GIVEN = ("rc_rig_check_points", "check_pose", "check_view", "equations_of_points",
         "equations_of_pose", "equations_by_loss", "equations_timed")
PLACE, WEIGH = ("rc_times_place",), ("rc_times_weigh",)
INDIRECT = {"rigcal_rig_covariance": ("considered_camera",),
            "rigcal_rig_pair": ("considered_pair",),
            "rigcal_rig_placement": ("considered_placement",),
            "copy_rig": ("considered_joint",),
            "rigcal_calibrated_take": ("considered_joint",),
            "rigcal_neldermead_step": (), "rc_rig_view_at": (), "rc_rig_pose_at": (),
            "rc_candidate_at": (), "rc_candidates": (),
            "rc_rig_begin_points": ("begin_clocks",), "rc_rig_chain": PLACE,
            "rc_judge_claim": PLACE, "move_to_instant": PLACE,
            "rc_rig_view_equations": WEIGH, "equations_by_loss": WEIGH,
            "equations_timed": WEIGH, "add_view": WEIGH,
            "rigcal_rig_step": ("rc_rig_step", "step_timed"),
            "take_step": ("rc_rig_move", "move_timed"),
            "check_next": GIVEN, "add_equations": GIVEN,
            "rc_views_step": GIVEN, "rc_rig_step": GIVEN}

# Bytes that a public function may need at most, without libm.
STACK_LIMIT = 4096

# Functions that may need more, in double. Which views contradict, and why, is asked seldom,
# where there is memory; in one call these functions hold the solvers too. The first view of
# a monitor's target is solved as a pose.
STACK_LIMITS = {"rigcal_rig_cause": 7168, "rigcal_camera_cause": 7168,
                "rigcal_cause_step": 5120, "rigcal_rig_judge": 5632,
                "rigcal_judge_step": 5120, "rigcal_monitor_view": 5120,
                "rigcal_rig_faults": 5120, "rigcal_rig_noise": 4352}

NODE = re.compile(r'node: \{ title: "([^"]+)" label: "([^"]*)"')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')


class Graph:
    """The functions with the bytes of their frames, and which functions they call."""

    def __init__(self, compiler, *flags):
        self.frame, self.dynamic, self.calls = {}, set(), {}
        with tempfile.TemporaryDirectory() as work:
            for source in sorted((ROOT / "src").glob("*.c")):
                name = source.relative_to(ROOT)
                done = subprocess.run(
                    [compiler, "-std=c99", *flags, "-ffp-contract=off",
                     "-fno-stack-protector", "-fcallgraph-info=su,da",
                     "-DRIGCAL_BUILD", "-Iinclude", "-c", str(name),
                     "-o", f"{work}/{source.stem}.o"],
                    cwd=ROOT, capture_output=True, text=True)
                if done.returncode:
                    sys.exit(f"check_callgraph: {name} does not compile\n{done.stderr}")
                self.read(pathlib.Path(work, source.stem + ".ci"))

    def read(self, path):
        for line in path.read_text().splitlines():
            node = NODE.match(line)
            if node:
                size = re.search(r"(\d+) bytes \(([^)]*)\)", node[2])
                if size:
                    self.frame[node[1]] = int(size[1])
                    # "dynamic,bounded": arguments are pushed, and their bytes are counted.
                    if size[2] == "dynamic":
                        self.dynamic.add(node[1])
            edge = EDGE.match(line)
            if edge:
                self.calls.setdefault(edge[1], set()).add(edge[2])

    def callees(self, name):
        for callee in sorted(self.calls.get(name, ())):
            if callee == "__indirect_call":
                for reached in INDIRECT.get(plain(name), ()):
                    yield from (title for title in self.frame if plain(title) == reached)
            else:
                yield callee

    def deepest(self, name, path=(), memo=None):
        """(bytes, chain of names) of the deepest chain of calls."""
        if memo is None:
            memo = {}
        if name in path:
            raise RecursionError(" -> ".join(map(plain, path[path.index(name):] + (name,))))
        if name not in memo:
            below = (0, ())
            for callee in self.callees(name):
                below = max(below, self.deepest(callee, path + (name,), memo))
            memo[name] = (self.frame.get(name, 0) + below[0], (name,) + below[1])
        return memo[name]

    def offences(self):
        for name in sorted(self.dynamic):
            yield f"{plain(name)} has an array of variable length or calls alloca"
        for name in sorted(self.calls):
            if "__indirect_call" in self.calls[name] and plain(name) not in INDIRECT:
                yield f"{plain(name)} calls through a function pointer"
        try:
            for name in sorted(self.frame):
                self.deepest(name)
        except RecursionError as chain:
            yield f"recursion: {chain}"

    def stacks(self):
        """{public function: (bytes, chain)}"""
        memo = {}
        return {name: self.deepest(name, memo=memo)
                for name in self.frame if name.startswith("rigcal_")}


def plain(title):
    """The title of a static function is path:name. A clone of it is called name.part.0."""
    return title.split(":")[-1].split(".")[0]


def main():
    bad = list(Graph("gcc", "-O0").offences())
    host = Graph("gcc", "-O2")
    bad += [text for text in host.offences() if text not in bad]
    if bad:
        print("\n".join(bad))
        sys.exit(f"check_callgraph: {len(bad)} offences")

    columns = {"host double -O2": host.stacks()}
    arm = shutil.which("arm-none-eabi-gcc")
    if arm:
        picolibc = "--specs=picolibc.specs"
        known = subprocess.run([arm, picolibc, "-E", "-x", "c", "/dev/null"],
                               capture_output=True).returncode == 0
        columns["M4F float -Os"] = Graph(
            arm, "-Os", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard",
            "-mfpu=fpv4-sp-d16", "-DRIGCAL_USE_FLOAT=1",
            *([picolibc] if known else [])).stacks()

    names = sorted(columns["host double -O2"])
    width = max(map(len, names))
    table = ["deepest stack of each public function, bytes, libm apart", "",
             " ".join([" " * width] + [f"{title:>16}" for title in columns])]
    for name in names:
        table.append(" ".join([f"{name:{width}}"] + [
            f"{stacks[name][0] if name in stacks else '-':>16}"
            for stacks in columns.values()]))
    print("\n".join(table))
    if len(sys.argv) > 1:
        folder = pathlib.Path(sys.argv[1])
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "stack.txt").write_text("\n".join(table) + "\n")

    deepest = []
    for title, stacks in columns.items():
        name = max(stacks, key=lambda f: stacks[f][0])
        size, chain = stacks[name]
        print(f"\n{title}: {size} bytes in {' -> '.join(map(plain, chain))}")
        deepest.append(f"{size} bytes ({title})")
        for name in sorted(stacks):
            limit = STACK_LIMITS.get(name, STACK_LIMIT)
            if stacks[name][0] > limit:
                sys.exit(f"check_callgraph: {name} needs {stacks[name][0]} bytes of stack, "
                         f"more than {limit}")
    print(f"no recursion, deepest stack {', '.join(deepest)}")


if __name__ == "__main__":
    main()
