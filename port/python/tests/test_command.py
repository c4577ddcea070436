"""The command rigcal works like the program, with files of every format."""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys
from typing import Any

import pytest
from cli_scenes import DATA, ROOT, SETS, STEREO, Recording, rows_of

import rigcal
from rigcal import command
from rigcal.calibrate import program
from rigcal.command import main

CAMERAS, OBSERVATIONS = STEREO / "cameras.csv", STEREO / "observations.csv"


def ran(capfd: Any, *arguments: Any) -> tuple[int, str, str]:
    """Exit status, output and messages of the command."""
    status = main([str(a) for a in arguments])
    out, err = capfd.readouterr()
    return status, out, err


def of_program(*arguments: Any) -> tuple[int, str, str]:
    run = subprocess.run([program(), *map(str, arguments)], capture_output=True, text=True)
    return run.returncode, run.stdout, run.stderr


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """A calibrated stereo pair, and its cameras in other formats."""
    folder = tmp_path_factory.mktemp("files")
    rig = rigcal.calibrate(CAMERAS, OBSERVATIONS, out=folder / "out")
    rig.save(folder / "Calib.toml")
    rigcal.save_cameras(folder / "bare.toml", rigcal.load_cameras(CAMERAS), "anipose")
    (folder / "colmap").mkdir()
    rig.save(folder / "colmap", "colmap")
    return folder


# ---- as the program ---------------------------------------------------------------


def commands_of_program(files: pathlib.Path) -> list[list[Any]]:
    rig = f"--rig={files / 'out' / 'rig.csv'}"
    cameras, observations = f"--cameras={CAMERAS}", f"--observations={OBSERVATIONS}"
    pair = ["--from=left", "--to", "right"]
    return [
        ["calibrate", cameras, observations],
        ["calibrate", cameras, observations, "--sigma=0.1", "--robust", "--progress"],
        ["calibrate", "--cam", CAMERAS, "--obs", OBSERVATIONS],
        ["triangulate", cameras, rig, observations],
        ["line", cameras, rig, *pair, "--pixel=300,200", "--probability", "0.9"],
        ["line", cameras, rig, *pair, "--pixel", "-5,3"],
        ["monitor", rig, "--matches=/nowhere.csv"],
        ["calibrate"],
        ["calibrate", cameras],
        ["calibrate", cameras, observations, "--sigma"],
        ["calibrate", cameras, observations, "--sigma", "--robust"],
        ["calibrate", cameras, cameras, observations],
        ["calibrate", cameras, observations, "--wrong"],
        ["calibrate", cameras, observations, "more"],
        ["calibrate", cameras, observations, "--s=1"],
        ["calibrate", cameras, observations, "--hold=left", "--hold=right"],
        ["calibrate", "--cameras=/nowhere.csv", observations],
        ["calibrate", cameras, f"--observations={CAMERAS}"],
        ["calibrate", cameras, observations, "--sigma=-1"],
        ["line", "--help"],
        ["--version"],
    ]


@pytest.mark.parametrize("case", range(21))
def test_what_the_program_takes_is_the_programs(
    capfd: Any, files: pathlib.Path, case: int
) -> None:
    arguments = commands_of_program(files)[case]
    assert ran(capfd, *arguments) == of_program(*arguments)


@pytest.mark.parametrize("name", SETS)
def test_any_format_gives_what_csv_gives(
    capfd: Any, tmp_path: pathlib.Path, name: str
) -> None:
    data = DATA / name
    rigcal.save_cameras(
        tmp_path / "c.toml", rigcal.load_cameras(data / "cameras.csv"), "anipose"
    )
    expected = of_program(
        "calibrate", "--cameras", data / "cameras.csv", "--observations",
        data / "observations.csv", "--out", tmp_path / "a",
    )  # fmt: skip
    found = ran(
        capfd, "calibrate", "--cameras", tmp_path / "c.toml", "--observations",
        data / "observations.csv", "--out", tmp_path / "b",
    )  # fmt: skip
    assert found == expected
    for path in (tmp_path / "a").iterdir():
        assert (tmp_path / "b" / path.name).read_bytes() == path.read_bytes()


def test_one_file_serves_as_cameras_and_rig(capfd: Any, files: pathlib.Path) -> None:
    rig = files / "out" / "rig.csv"
    line = ["--from=left", "--to=right", "--pixel=300,200", "--sigma=0.2"]
    _, lines, _ = of_program("line", f"--cameras={CAMERAS}", f"--rig={rig}", *line)
    straight = [text.split(",") for text in lines.splitlines()[:3]]
    for given in (
        [f"--cameras={files / 'Calib.toml'}"],
        [f"--rig={files / 'Calib.toml'}"],
        [f"--cameras={files / 'Calib.toml'}", f"--rig={files / 'Calib.toml'}"],
        [f"--cameras={files / 'colmap'}"],
        [f"--cameras={files / 'out'}"],
        [f"--cameras={CAMERAS}", f"--rig={files / 'Calib.toml'}"],
        [f"--cameras={files / 'bare.toml'}", f"--rig={rig}"],
    ):
        status, out, err = ran(capfd, "line", *given, *line)
        assert status == 0
        assert "/rigcal-" not in err
        for text, expected in zip(out.splitlines()[1:3], straight[1:]):
            assert [float(x) for x in text.split(",")[1:4] if x] == pytest.approx(
                [float(x) for x in expected[1:4] if x], abs=1e-5
            )
    status, out, err = ran(
        capfd, "triangulate", f"--cameras={files / 'Calib.toml'}",
        f"--observations={OBSERVATIONS}",
    )  # fmt: skip
    assert status == 0
    assert len(out.splitlines()) == 379
    assert f"{files / 'Calib.toml'} has no covariance" in err


def test_a_broken_file_of_the_program_with_another_ending(
    capfd: Any, tmp_path: pathlib.Path
) -> None:
    path = tmp_path / "cameras.txt"
    path.write_text(CAMERAS.read_text().replace("640,480", "640,x"))
    given = ["calibrate", f"--cameras={path}", f"--observations={OBSERVATIONS}"]
    assert ran(capfd, *given) == of_program(*given)
    assert of_program(*given)[2].startswith(f"{path}:2: ")


def test_a_prior_of_another_format(capfd: Any, files: pathlib.Path) -> None:
    given = [f"--cameras={files / 'Calib.toml'}", f"--observations={OBSERVATIONS}"]
    status, out, err = ran(
        capfd, "calibrate", *given, f"--prior={files / 'Calib.toml'}", "--hold=left",
        "--hold=right",
    )  # fmt: skip
    assert (status, err) == (0, "")
    assert "centre in the frame of" in out
    status, _, err = ran(
        capfd, "calibrate", *given, f"--prior={files / 'bare.toml'}", "--hold=left"
    )
    assert (status, err) == (2, f"{files / 'bare.toml'}: no camera in it has a pose\n")


def test_progress_of_another_format(capfd: Any, files: pathlib.Path) -> None:
    given = [f"--cameras={files / 'Calib.toml'}", f"--observations={OBSERVATIONS}"]
    status, out, err = ran(capfd, "calibrate", *given, "--progress")
    assert (status, out, err) == of_program(
        "calibrate", f"--cameras={CAMERAS}", f"--observations={OBSERVATIONS}", "--progress"
    )


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ([], "rigcal: give a command: calibrate, detect, diagnose, triangulate, line, "),
        (["make"], 'rigcal: there is no command "make": the commands are calibrate, det'),
        (["convert"], "rigcal: "),
        (["convert", "x"], "rigcal: convert takes the file to read and the file to write"),
        (["convert", "x", "y", "--from"], "rigcal: argument --from"),
        (["convert", "x", "y", "--from=z"], "rigcal: argument --from"),
        (["convert", "x", "y", "--scale=z"], "rigcal: argument --scale"),
        (["convert", "nowhere.yaml", "y.toml"], "nowhere.yaml: No such file"),
        (["diagnose"], "rigcal: diagnose needs --cameras"),
        (["diagnose", "--cameras=x"], "rigcal: diagnose needs --observations"),
        (["diagnose", "--wrong"], "rigcal: diagnose has the options of calibrate"),
        (["calibrate", "--cameras", str(ROOT / "README.md"), "--observations=x"],
         f"{ROOT / 'README.md'}: "),
    ],
)  # fmt: skip
def test_wrong_use(capfd: Any, arguments: list[str], text: str) -> None:
    status, out, err = ran(capfd, *arguments)
    assert (status, out) == (2, "")
    assert err.startswith(text)


def test_help(capfd: Any) -> None:
    for arguments in (["--help"], ["-h"], ["convert", "--help"], ["diagnose", "--help"]):
        status, out, err = ran(capfd, *arguments)
        assert (status, err) == (0, "")
        assert out.endswith(of_program("--help")[1])
        for word in ("kalibr", "diagnose", "convert", "--intrinsics-sigma"):
            assert word in out


def test_it_is_installed_as_a_command(tmp_path: pathlib.Path) -> None:
    code = "import sys; from rigcal.command import main; sys.exit(main())"
    words = [sys.executable, "-c", code, "line", "--nothing"]
    run = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
    assert (run.returncode, run.stdout, run.stderr) == of_program("line", "--nothing")


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_a_signal_is_an_exit_status(
    capfd: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path
) -> None:
    script = tmp_path / "rigcal"
    script.write_text("#!/bin/sh\nkill -15 $$\n")
    script.chmod(0o755)
    monkeypatch.setenv("RIGCAL_PROGRAM", str(script))
    assert ran(capfd, "calibrate")[0] == 128 + 15
    monkeypatch.setenv("RIGCAL_PROGRAM", str(tmp_path / "nothing"))
    status, _, err = ran(capfd, "calibrate")
    assert status == 2
    assert "rigcal: the program rigcal cannot be run: " in err


@pytest.mark.skipif(sys.platform == "win32", reason="pipes")
def test_a_reader_that_goes_away(tmp_path: pathlib.Path) -> None:
    code = "import sys; from rigcal.command import main; sys.exit(main(sys.argv[1:]))"
    words = ["diagnose", f"--cameras={CAMERAS}", f"--observations={OBSERVATIONS}"]
    read, write = os.pipe()
    os.close(read)
    run = subprocess.run(
        [sys.executable, "-c", code, *words],
        stdout=write,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
    )
    os.close(write)
    assert run.returncode == 2
    assert b"Traceback" not in run.stderr


# ---- convert ---------------------------------------------------------------------------


def test_convert_there_and_back(
    capfd: Any, files: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    stereo = tmp_path / "stereo.xml"
    assert ran(capfd, "convert", files / "Calib.toml", stereo) == (0, "", "")
    back = tmp_path / "back.toml"
    assert ran(capfd, "convert", stereo, back, "--to", "anipose")[0] == 0
    for name, was in rigcal.load_cameras(files / "Calib.toml").items():
        now = rigcal.load_cameras(back)[name]
        assert now.dist == pytest.approx(was.dist, abs=1e-12)
        assert now.cam_from_rig is not None
        assert was.cam_from_rig is not None
        assert now.cam_from_rig.matrix == pytest.approx(was.cam_from_rig.matrix, abs=1e-12)


def test_convert_a_folder_of_calibrate(
    capfd: Any, files: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    folder = tmp_path / "csv"
    folder.mkdir()
    assert ran(capfd, "convert", files / "out", folder, "--to=rigcal") == (0, "", "")
    rows = rows_of(folder / "cameras.csv")
    assert [r["camera"] for r in rows] == ["left", "right"]
    assert [float(r["fx"]) for r in rows] == [float(r["fx"]) for r in rows_of(CAMERAS)]
    assert len(rows_of(folder / "rig.csv")) == 2


def test_convert_several_files_a_unit_and_a_caveat(
    capfd: Any, files: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    status, _, err = ran(
        capfd, "convert", files / "Calib.toml", tmp_path / "{name}.yaml", "--to=ros"
    )
    assert status == 0
    assert err.startswith("rigcal: ")
    names = [tmp_path / f"{name}.yaml" for name in ("left", "right")]
    assert ran(capfd, "convert", *names, tmp_path / "two.csv")[0] == 0
    assert [r["camera"] for r in rows_of(tmp_path / "two.csv")] == ["left", "right"]
    assert ran(capfd, "convert", files / "Calib.toml", tmp_path / "mm.toml", "--to=anipose",
               "--scale=1000")[0] == 0  # fmt: skip
    metres, millimetres = (
        rigcal.load_cameras(path)["right"].cam_from_rig
        for path in (files / "Calib.toml", tmp_path / "mm.toml")
    )
    assert metres is not None
    assert millimetres is not None
    assert millimetres.t == pytest.approx(1000 * metres.t)


def test_convert_names_options_of_its_own(
    capfd: Any, files: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    status, _, err = ran(capfd, "convert", files / "Calib.toml", tmp_path / "x.unknown")
    assert status == 2
    assert "pass --to" in err
    assert not (tmp_path / "x.unknown").exists()
    status, _, err = ran(capfd, "convert", files / "Calib.toml", tmp_path / "camchain.yaml")
    assert status == 2
    assert err.count("\n") == 1
    assert "k3" in err


# ---- diagnose ---------------------------------------------------------------------------


def as_csv(recording: Recording, folder: pathlib.Path) -> list[str]:
    rigcal.save_cameras(folder / "cameras.csv", recording.cameras)
    lines = [
        "frame,camera,point,X,Y,Z,u,v",
        *(",".join(map(str, r)) for r in recording.rows),
    ]
    (folder / "observations.csv").write_text("\n".join(lines) + "\n")
    stamps = [f"{f},{c},{t}" for (f, c), t in recording.times.items()]
    (folder / "times.csv").write_text("\n".join(["frame,camera,time_s", *stamps]) + "\n")
    return [
        f"--cameras={folder / 'cameras.csv'}",
        f"--observations={folder / 'observations.csv'}",
    ]


def test_diagnose_a_good_recording(capfd: Any, tmp_path: pathlib.Path) -> None:
    status, out, err = ran(capfd, "diagnose", *as_csv(Recording(), tmp_path))
    assert (status, err) == (0, "")
    assert out.startswith("no view, camera or point is wrong\n")
    assert "agrees" in out
    assert "next: show the target to" in out


def test_diagnose_a_wrong_view(capfd: Any, tmp_path: pathlib.Path) -> None:
    recording = Recording()
    recording.spoil("101", "c")
    given = as_csv(recording, tmp_path)
    status, out, err = ran(capfd, "diagnose", *given, f"--out={tmp_path / 'out'}")
    expected = of_program("calibrate", *given)
    assert (status, err) == (expected[0], "") == (1, "")
    assert "left out of the rig: c in frame 101\n" in out
    for line in expected[2].splitlines():
        assert line.replace("rigcal: ", "", 1) in out
    assert (tmp_path / "out" / "rig.csv").is_file()


def test_diagnose_clocks_and_another_format(capfd: Any, tmp_path: pathlib.Path) -> None:
    recording = Recording({"b": 0.012, "d": -0.007})
    given = as_csv(recording, tmp_path)
    rigcal.save_cameras(tmp_path / "c.toml", recording.cameras, "anipose")
    given[0] = f"--cameras={tmp_path / 'c.toml'}"
    status, out, err = ran(capfd, "diagnose", *given, f"--times={tmp_path / 'times.csv'}")
    assert (status, err) == (0, "")
    assert "explained\n" in out
    assert "Most likely the clocks" in out
    assert "  clocks: 0.01" in out
    assert ", explains" in out


def test_diagnose_what_cannot_disagree(capfd: Any) -> None:
    data = DATA / "openptv_cavity"
    status, out, _ = ran(
        capfd, "diagnose", f"--cameras={data / 'cameras.csv'}",
        f"--observations={data / 'observations.csv'}",
    )  # fmt: skip
    assert status == 0
    assert "the views have nothing in common that could disagree" in out


def test_diagnose_without_a_rig(capfd: Any, tmp_path: pathlib.Path) -> None:
    recording = Recording()
    recording.rows = [row for row in recording.rows if row[2] in ("p0", "p1")]
    given = as_csv(recording, tmp_path)
    status, out, err = ran(capfd, "diagnose", *given)
    expected = of_program("calibrate", *given)
    assert (status, out) == (expected[0], "") == (1, "")
    assert "has no pose in frame" in err
    status, _, err = ran(capfd, "diagnose", *given, "--sigma=-1")
    assert (status, err) == (2, 'rigcal: --sigma is from 1e-06 to 1e+06 pixels, not "-1"\n')


def test_the_options_are_those_of_the_program() -> None:
    """Each option that the program's help names for a command is known here."""
    text = of_program("--help")[1]
    usage = text.split("rigcal --help | --version")[0]
    for name in command.OPTIONS:
        part = usage.split(f"  rigcal {name} ")[1].split("  rigcal ")[0]
        words = {w.strip("[]().|") for w in part.split() if "--" in w}
        assert {w[2:] for w in words} == set(command.OPTIONS[name])
