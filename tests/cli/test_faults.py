"""Every call by which the program writes, makes, renames or removes something fails, one at a
time; or a signal comes before it, or the folder is moved away. With RIGCAL_ALL_FAULTS=1 each
call meets each of them; else two of them, in turn."""
import errno
import itertools
import os
import resource
import shutil
import signal
import subprocess
import unittest

from cli_support import (BIN, OUTPUTS, SANITIZED, STEREO, CliTest, measured, read, rigcal, sound,
                         with_fault, write)

ALL = os.environ.get("RIGCAL_ALL_FAULTS") == "1"
STRIDE = 4 if SANITIZED and not ALL else 1  # calls: a run takes ten times as long there
ERRORS = [errno.ENOSPC, errno.EIO, errno.EACCES]
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE, signal.SIGKILL]
VANISH = -1000
EARLIER = "as it was"
CALIBRATE = ["calibrate", "--cameras", STEREO + "/cameras.csv", "--observations",
             STEREO + "/observations.csv"]


def some(whats, call, step=1):
    """All of them, or one after the other in turn."""
    return whats if ALL else [whats[call // step % len(whats)]]


class Sweep(CliTest):
    def setUp(self):
        super().setUp()
        self.count = os.path.join(self.folder, "count")
        self.addCleanup(os.environ.pop, "FAULT_COUNT", None)
        self.addCleanup(os.environ.pop, "FAULT_FOLDER", None)

    def number_of_calls(self, *arguments):
        os.environ["FAULT_COUNT"] = self.count
        run = with_fault("any:0:0", *arguments)
        del os.environ["FAULT_COUNT"]
        with open(self.count) as file:
            n = int(file.read())
        os.remove(self.count)
        self.assertGreater(n, 0)
        return run, n


class TestFaultsOfCalibrate(Sweep):
    """`out` is new, or has an earlier file of each name and a file of somebody else."""

    def prepare(self, is_new):
        for folder in (self.out, self.out + "-gone"):
            shutil.rmtree(folder, ignore_errors=True)
        if not is_new:
            os.mkdir(self.out)
            for name in [*OUTPUTS, "notes.txt"]:
                write(self.out, name, EARLIER)
        return self.files()

    def usual(self, is_new):
        """Counts the calls, and keeps the files of a run without a fault."""
        self.prepare(is_new)
        run, n = self.number_of_calls(*CALIBRATE, "--out", self.out)
        self.assertEqual(run.returncode, 0, run.stderr)
        return n, self.files()

    def run_with_fault(self, call, what):
        return with_fault(f"any:{call}:{what}", *CALIBRATE, "--out", self.out)

    def each(self, whats, step):
        for is_new in (True, False):
            n, after = self.usual(is_new)
            measured(f"{n} calls")
            for call in range(1, n + 1, STRIDE):
                for what in some(whats, call, step):
                    with self.subTest(is_new=is_new, call=call, what=what):
                        before = self.prepare(is_new)
                        yield before, after, call, what

    def test_a_call_that_fails(self):
        for before, after, call, what in self.each(ERRORS, 1):
            run = self.run_with_fault(call, what)
            if run.returncode == 2:
                self.assertRegex(run.stderr, r"cannot write (standard output|/\S*/out\S*): |"
                                             "cannot write to standard output: ")
                self.assertIn(os.strerror(what), run.stderr)
                self.assertIn("no file was written", run.stderr)
                self.assertEqual(self.files(), before)
            else:  # an earlier file that could not be removed, at the end
                self.assertEqual(run.returncode, 0)
                self.assertEqual({p: t for p, t in self.files().items() if "/rigcal-" not in p},
                                 after)

    def test_a_signal(self):
        for before, after, call, what in self.each(SIGNALS, 1):
            run = self.run_with_fault(call, -what)
            self.assertEqual(run.returncode, -what)
            there = self.files()
            if what != signal.SIGKILL:
                self.assertIn(there, (before, after))
                continue
            inside = {p: t for p, t in there.items()
                      if os.path.dirname(p) == self.out and t is not None}
            kept = [p for p in inside if before.get(p) == inside[p]]
            new = [p for p in inside if after.get(p) == inside[p] and p not in kept]
            self.assertEqual(len(kept) + len(new), len(inside))  # no file is half written
            kept = [p for p in kept if not p.endswith("notes.txt")]
            self.assertTrue(not kept or not new)
            if not new:  # no earlier file is lost
                self.assertEqual(list(there.values()).count(EARLIER),
                                 list(before.values()).count(EARLIER))

    def test_the_folder_is_moved_away(self):
        os.environ["FAULT_FOLDER"] = self.out
        for before, _, call, _ in self.each([VANISH], 1):
            run = self.run_with_fault(call, VANISH)
            self.assertIn(run.returncode, (0, 2))
            if run.returncode == 2:
                self.assertRegex(run.stderr, "cannot write /\\S*/out.*: .*no file was written")
                self.assertFalse(os.path.exists(self.out))
            if not before:
                self.assertEqual(run.returncode, 0)  # there is no file that could be lost

    def test_the_disk_is_full_after_so_many_bytes(self):
        size = max(len(text) for text in self.usual(True)[1].values())
        before = self.prepare(False)
        for most in [*range(0, size, size // (200 if ALL else 20)), size - 1]:
            def limit():
                signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
                resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
            with self.subTest(most=most):
                run = rigcal(*CALIBRATE, "--out", self.out, preexec_fn=limit)
                self.assertEqual(run.returncode, 2)
                self.assertRegex(run.stderr, rf"cannot write {self.out}/\S+\.\w+: "
                                             f"{os.strerror(errno.EFBIG)}; no file was written")
                self.assertEqual(self.files(), before)

    @unittest.skipIf(SANITIZED, "the sanitizer itself takes more address space")
    def test_the_memory_is_full_after_so_many_bytes(self):
        before, n_failed, run = self.prepare(False), 0, None
        for most in range(2 << 20, 64 << 20, 1 << 12 if ALL else 1 << 15):
            def limit():
                resource.setrlimit(resource.RLIMIT_AS, (most, most))
            with self.subTest(most=most):
                run = rigcal(*CALIBRATE, "--out", self.out, preexec_fn=limit)
                if run.returncode == 0:
                    break
                self.assertEqual(self.files(), before)
                if run.returncode == 2:  # otherwise the program could not be loaded
                    self.assertTrue(run.stderr.endswith("rigcal: out of memory\n"), run.stderr)
                    n_failed += 1
                else:
                    self.assertEqual(n_failed, 0)
        self.assertEqual(run.returncode, 0)
        self.assertGreater(n_failed, 10)


class TestFaultsOfTheOthers(Sweep):
    """Commands that write only to standard output."""

    def commands(self):
        self.calibrate_well(STEREO)
        rig = ["--rig", self.result("rig.csv")]
        cameras = ["--cameras", STEREO + "/cameras.csv"]
        observations = ["--observations", STEREO + "/observations.csv"]
        frames = sorted({row["frame"] for row in read(observations[1])})
        times = write(self.folder, "times.csv", "frame,time_s\n" + "".join(
            f"{name},{k}\n" for k, name in enumerate(frames)))
        return [CALIBRATE, ["triangulate", *cameras, *rig, *observations],
                ["line", *cameras, *rig, "--from", "left", "--to", "right", "--pixel", "300,200"],
                ["monitor", *rig, *observations, "--times", times], ["--help"], ["--version"]]

    def test_a_write_that_fails_or_a_signal(self):
        for command in self.commands():
            _, n = self.number_of_calls(*command)
            for call in range(1, n + 1):
                for what in some(ERRORS, call) + [-s for s in some(SIGNALS, call)]:
                    with self.subTest(command=command[0], call=call, what=what):
                        run = with_fault(f"any:{call}:{what}", *command)
                        self.assertEqual(run.returncode, 2 if what > 0 else what)
                        if what > 0:
                            self.assertRegex(run.stderr, "standard output: "
                                             f"({os.strerror(what)}|an earlier write failed)")

    def test_standard_files_that_are_closed(self):
        for command in self.commands():
            usual = rigcal(*command)
            for closed in itertools.product((False, True), repeat=3):
                shell = 'exec "$@" ' + " ".join(
                    word for word, is_closed in zip(("<&-", ">&-", "2>&-"), closed) if is_closed)
                with self.subTest(command=command[0], shell=shell):
                    run = sound(subprocess.run(
                        ["sh", "-c", shell, "sh", BIN, *command], stdout=subprocess.PIPE,
                        stderr=subprocess.PIPE, text=True))
                    self.assertEqual(run.returncode, 2 if closed[1] else usual.returncode)
                    self.assertEqual(run.stdout, "" if closed[1] else usual.stdout)
                    if closed[1] and not closed[2]:
                        self.assertIn("standard output", run.stderr)

    def test_a_reader_that_went_away(self):
        for command in self.commands():
            read_end, write_end = os.pipe()
            os.close(read_end)
            with self.subTest(command=command[0]):
                run = sound(subprocess.run([BIN, *command], stdout=write_end, stderr=subprocess.PIPE,
                                           text=True, preexec_fn=lambda: signal.signal(
                                               signal.SIGPIPE, signal.SIG_DFL)))
                self.assertEqual(run.returncode, -signal.SIGPIPE)
            os.close(write_end)


if __name__ == "__main__":
    unittest.main()
