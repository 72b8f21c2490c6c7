"""Bench data that cannot be used, or only with care, is reported in a sentence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.physics.bench_runs import DRAG, THRUST, TURN, bench_run, staircase

from omnimorph.errors import InputError
from omnimorph.identification import BenchData, RotorFit, fit_rotor, read_bench
from omnimorph.protocols import FloatArray

HEADER = "time_s,speed_Hz,force_N,torque_Nm"
ROWS = ["0.0,10.0,0.1,0.001", "0.1,20.0,0.4,0.004", "0.2,30.0,0.9,0.009"]


def written(folder: Path, *lines: str) -> Path:
    path = folder / "bench.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def written_run(folder: Path, **columns: FloatArray) -> Path:
    """Write a run of the made-up rotor with columns changed or added, by their names in files."""
    run = bench_run(staircase())
    found: dict[str, FloatArray] = {
        "time_s": run.time,
        "speed_Hz": run.speed / TURN,
        "force_N": run.force,
        "torque_Nm": run.torque,
    }
    found |= columns
    rows = np.column_stack(list(found.values()))
    return written(folder, ",".join(found), *(",".join(map(repr, row)) for row in rows.tolist()))


def refusal(run: BenchData, **expected: float) -> str:
    with pytest.raises(InputError) as caught:
        fit_rotor(run, **expected)
    return str(caught.value)


# --- the file -------------------------------------------------------------------------------------


def test_columns_in_any_order_and_unit_are_read_in_SI(tmp_path: Path) -> None:
    path = written(tmp_path, " force_N,speed_rpm,torque_Nm,time_s,command_Hz", "1,60,0.1,0,1", "",
                   "2,120,0.2,1,2")  # fmt: skip
    run = read_bench(path)
    assert run.speed.tolist() == pytest.approx([TURN, 2.0 * TURN])
    assert run.command is not None
    assert run.command.tolist() == pytest.approx([TURN, 2.0 * TURN])
    assert (run.time.tolist(), run.force.tolist()) == ([0.0, 1.0], [1.0, 2.0])
    assert run.lines == (2, 4)
    assert not run.speed.flags.writeable


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ([HEADER, ROWS[0], "0.1,20.0,x,0.004"],
         'line 3, column force_N is "x", but it must be a finite number from -1e9 to 1e9.'),
        ([HEADER, ROWS[0], "0.1,nan,1,0.004"],
         'line 3, column speed_Hz is "nan", but it must be a finite number from -159155 to '),
        ([HEADER, ROWS[0], "0.1,20.0,1"], "line 3, number of values is 3, but it must be 4, as in"),
        ([HEADER, ROWS[1], ROWS[0]],
         "line 3, time is \"0 s\", but it must be later than the time before it, 0.1 s, "),
        (["time_s,speed_Hz,force_N", "0,1,2"],
         "line 1, column torque_Nm is missing, but it must be there: the first line names the "),
        (["time_s,force_N,torque_Nm", "0,1,2"], "line 1, column speed_Hz is missing, but it must"),
        (["time_s,speed_Hz,force_N,torque_Ncm"],
         "line 1, column 'torque_Ncm' is not a known key; did you mean torque_Nm "),
        ([f"{HEADER},speed_Hz"], "line 1, column speed_Hz is there twice, but must be once."),
        ([f"{HEADER},command_Hz,command_rpm"], "line 1 names several commands, but must name one"),
        ([""], "line 1, column time_s is missing, but it must be there"),
        ([HEADER], 'what there is to fit is "0 of 0 rows", but it must be 8 or more rows that '),
        ([HEADER, *ROWS], 'what there is to fit is "3 of 3 rows", but it must be 8 or more rows'),
    ],
)  # fmt: skip
def test_bad_file(tmp_path: Path, lines: list[str], expected: str) -> None:
    path = written(tmp_path, *lines)
    with pytest.raises(InputError) as caught:
        fit_rotor(read_bench(path))
    assert str(caught.value).startswith(f"{path}: {expected}")
    assert str(caught.value).count("\n") == 0


def test_file_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"nowhere.csv: this file cannot be read, because there is no such file"
    ):
        read_bench(tmp_path / "nowhere.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00time")
    with pytest.raises(InputError, match=r"binary.csv: .* it is not a text file"):
        read_bench(tmp_path / "binary.csv")


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"force": [1.0, 2.0]}, "number of values of force is 2, but it must be 3, as there are"),
        ({"torque": [[1.0], [2.0], [3.0]]}, "torque is [[1.0], [2.0], [3.0]], but it must be one"),
        ({"speed": ["a", "b", "c"]}, 'speed is ["a"'.replace('"', "'")),
        (
            {"command": [1.0, np.inf, 2.0]},
            "command is [1.0, inf, 2.0], but it must be one row of finite",
        ),
        ({"time": [0.0, 1.0, 1.0]}, 'line 3, time is "1 s", but it must be later'),
    ],
)
def test_bad_arrays(changes: dict[str, Any], expected: str) -> None:
    columns: dict[str, Any] = {name: [0.0, 1.0, 2.0] for name in ("time", "speed", "force")}
    with pytest.raises(InputError) as caught:
        BenchData(**(columns | {"torque": [0.0, 1.0, 2.0]} | changes))
    assert str(caught.value).startswith(f"the bench data: {expected}")


# --- units ----------------------------------------------------------------------------------------

# What a column says, what it holds, and the factor by which it is too large.
MISTAKES = [
    ("Hz", "rad/s", TURN, "2π"),
    ("Hz", "rpm", 60.0, "60"),
    ("rpm", "Hz", 1.0 / 60.0, "1/60"),
    ("rpm", "rad/s", TURN / 60.0, "2π/60"),
    ("rad_per_s", "Hz", 1.0 / TURN, "1/2π"),
    ("rad_per_s", "rpm", 60.0 / TURN, "60/2π"),
]
TO_UNIT = {"Hz": 1.0 / TURN, "rpm": 60.0 / TURN, "rad_per_s": 1.0}


@pytest.mark.parametrize(("said", "meant", "factor", "words"), MISTAKES)
@pytest.mark.parametrize("beside", ["speed", "command"])
def test_wrong_unit_beside_another_column(
    tmp_path: Path, said: str, meant: str, factor: float, words: str, beside: str
) -> None:
    right = "rpm" if said == "Hz" else "Hz"
    speed = staircase()
    columns = {f"speed_{said}": speed * TO_UNIT[said] * factor}
    columns[f"{beside}_{right}"] = speed * TO_UNIT[right]
    path = tmp_path / "bench.csv"
    names = ["time_s", "force_N", "torque_Nm", *columns]
    run = bench_run(speed)
    rows = np.column_stack([run.time, run.force, run.torque, *columns.values()])
    np.savetxt(path, rows, delimiter=",", header=",".join(names), comments="")
    with pytest.raises(InputError) as caught:
        read_bench(path)
    reported = str(caught.value)
    assert f"the numbers under speed_{said} look like {meant}" in reported
    first = f"speed_{said} is {factor:.4g} times {beside}_{right}, which is {words}"
    turned = f"{beside}_{right} is {1.0 / factor:.4g} times speed_{said}, which is "
    assert first in reported or turned in reported


@pytest.mark.parametrize(("said", "meant", "factor", "words"), MISTAKES)
def test_wrong_unit_beside_what_is_expected(
    said: str, meant: str, factor: float, words: str
) -> None:
    run = bench_run(staircase())
    reported = refusal(
        BenchData(time=run.time, speed=factor * run.speed, force=run.force, torque=run.torque),
        expected_thrust_coefficient=1.15 * THRUST,
        expected_drag_coefficient=0.9 * DRAG,
    )
    unit = {"rad_per_s": "rad/s"}.get(said, said)
    assert reported.endswith(f"the speeds look like {meant} where {unit} is said.")
    assert f"times the one expected, about {inverse_square(words)}:" in reported


def inverse_square(words: str) -> str:
    return {"2π": "1/(2π)²", "60": "1/60²", "1/60": "60²", "2π/60": "(60/2π)²", "1/2π": "(2π)²",
            "60/2π": "(2π/60)²"}[words]  # fmt: skip


def test_wrong_unit_of_force_beside_what_is_expected() -> None:
    run = bench_run(staircase())
    reported = refusal(
        bench_run(staircase(), force=run.force / 9.80665e-3),
        expected_thrust_coefficient=THRUST,
        expected_drag_coefficient=DRAG,
    )
    assert reported.endswith("the forces look like gf where N is said.")


def test_what_is_expected_and_comes_is_not_refused() -> None:
    fit = fit_rotor(
        bench_run(staircase()), expected_thrust_coefficient=2.0 * THRUST,
        expected_drag_coefficient=2.0 * DRAG,
    )  # fmt: skip
    assert fit.thrust.value.holds(THRUST)


@pytest.mark.parametrize(
    ("torque_factor", "force_factor", "expected"),
    [
        (100.0, 1.0, "torque in N cm (0.015 m)"),
        (1000.0, 1.0, "torque in N mm (0.015 m)"),
        (1.0, 1.0 / 9.80665e-3, "force in gf (0.015 m)"),
    ],
)
def test_torque_that_does_not_fit_the_force_is_reported(
    torque_factor: float, force_factor: float, expected: str
) -> None:
    run = bench_run(staircase())
    fit = fit_rotor(
        bench_run(staircase(), force=force_factor * run.force, torque=torque_factor * run.torque)
    )
    (sentence,) = (one for one in fit.warnings if one.startswith("Torque over force is "))
    assert expected in sentence
    assert fit.drag_to_thrust == pytest.approx(DRAG / THRUST * torque_factor / force_factor, 0.01)


def test_speeds_that_contradict_each_other(tmp_path: Path) -> None:
    path = written_run(tmp_path, speed_rpm=60.0 * 1.5 * staircase() / TURN)
    with pytest.raises(InputError, match=r"do not give the same speed: the first is 0.6667 times"):
        read_bench(path)


# --- the content ----------------------------------------------------------------------------------


def test_too_few_rows() -> None:
    reported = refusal(bench_run(staircase()[:7]))
    assert reported == (
        'the bench data: what there is to fit is "7 of 7 rows", but it must be 8 or more rows that '
        "turn the same way round."
    )


def test_rotor_that_never_turned() -> None:
    assert '"0 of 20 rows"' in refusal(bench_run(np.zeros(20)))


def test_speeds_that_do_not_vary() -> None:
    speed = TURN * np.linspace(118.0, 120.0, 50)
    assert refusal(bench_run(speed)).endswith(
        "the forward speeds do not vary enough, 118 to 120 Hz; the fastest must be at least 1.2 "
        "times the slowest."
    )


def test_force_against_the_speed() -> None:
    speed = staircase()
    run = bench_run(speed, force_noise=0.0)
    assert refusal(bench_run(speed, force=-run.force)).endswith(
        "the force has the sign opposite to the speed's in 120 of 120 rows that turn in forward, "
        "the first on line 1; turn the sign of the column that is wrong."
    )
    both = speed * np.where(np.arange(120) % 2, 1.0, -1.0)
    unsigned = bench_run(both, force_noise=0.0)
    reported = refusal(bench_run(both, force=np.abs(unsigned.force)))
    assert "in 60 of 60 rows that turn in reverse, the first on line 1;" in reported


def test_a_few_rows_of_the_other_sign() -> None:
    speed = staircase()
    speed[[3, 9]] *= -1.0
    reported = refusal(bench_run(speed))
    assert "only 2 rows (lines 4, 10) turn in reverse, but it must be none or 8 or more" in reported
    speed[[20, 30, 40, 50, 60]] *= -1.0
    assert "only 7 rows (lines 4, 10, 21, 31, 41 and 2 more) turn in" in refusal(bench_run(speed))


def test_as_many_outliers_are_reported_as_there_are() -> None:
    run = bench_run(staircase(), force_noise=1e-3)
    force = run.force.copy()
    force[10:80:5] += 5.0
    (reported,) = [
        one for one in fit_rotor(bench_run(staircase(), force=force)).warnings if "line" in one
    ]
    assert reported.startswith("14 of 120 rows were left out of the force")
    listed, more = reported.split("lines ")[1].rstrip(".").split(" and ")
    assert len(listed.split(", ")) + int(more.split()[0]) == 14


def test_torque_that_says_nothing() -> None:
    reported = refusal(bench_run(staircase(), torque_noise=10.0, seed=5))
    assert "the torque does not grow with the squared speed: its coefficient is " in reported


def test_rows_that_follow_no_coefficient() -> None:
    run = bench_run(staircase())
    force = run.force.copy()
    force[::4] *= 3.0
    reported = refusal(bench_run(staircase(), force=force))
    assert "30 of 120 rows are far from any force that grows with the squared speed (lines 1, 5, "
    assert "at most a fifth may be." in reported


def test_outliers_are_named_and_left_out_and_the_data_stay() -> None:
    run = bench_run(staircase())
    force = run.force.copy()
    force[[16, 99]] += [5.0, -3.0]
    run = bench_run(staircase(), force=force)
    fit = fit_rotor(run)
    assert np.flatnonzero(fit.thrust.outlier).tolist() == [16, 99]
    assert not fit.drag.outlier.any()
    assert fit.warnings[0] == (
        "2 of 120 rows were left out of the force, being beyond 5 robust standard deviations: "
        "lines 17, 100."
    )
    assert fit.thrust.value.holds(THRUST)
    assert run.force.tolist() == force.tolist()


def test_torque_of_the_other_sign_is_reported_and_turned() -> None:
    run = bench_run(staircase())
    fit = fit_rotor(bench_run(staircase(), torque=-run.torque))
    assert fit.torque_felt
    assert fit.drag.value.holds(DRAG)
    assert any(reported.startswith("The torque has the sign opposite") for reported in fit.warnings)


def test_steps_too_fast_for_the_samples_are_reported() -> None:
    speed = staircase()
    fit = fit_rotor(bench_run(speed, command=speed))
    assert fit.time_constant_up is None
    assert any(reported.startswith("No step up of the command") for reported in fit.warnings)


@pytest.mark.parametrize("command_Hz", [0.0, 90.0])
def test_command_that_never_steps_gives_no_time_constants(command_Hz: float) -> None:
    fit = fit_rotor(bench_run(staircase(), command=np.full(120, TURN * command_Hz)))
    assert (fit.time_constant_up, fit.time_constant_down, fit.steps) == (None, None, ())
    assert sum(reported.startswith("No step ") for reported in fit.warnings) == 2


@pytest.mark.parametrize("seed", range(40))
def test_any_numbers_are_fitted_or_refused(seed: int) -> None:
    """Whatever a file holds, the answer is finite or one sentence."""
    random = np.random.default_rng(seed)
    rows = int(random.integers(8, 60))
    held = np.repeat(random.uniform(-900.0, 900.0, rows // 5 + 1), 5)[:rows]
    speed = held if seed % 2 else 10.0 ** random.uniform(-9.0, 6.0, rows)
    scale = 10.0 ** random.uniform(-9.0, -3.0)
    run = BenchData(
        time=np.cumsum(10.0 ** random.uniform(-6.0, 1.0, rows)),
        speed=speed,
        force=scale * speed * np.abs(speed) + random.normal(0.0, 10.0 ** random.uniform(-9.0, 0.0)),
        torque=np.round(1e-7 * speed * np.abs(speed), 3),
        command=held,
    )
    found = fitted_or_refused(run)
    if isinstance(found, InputError):
        assert str(found).startswith("the bench data: ")
    else:
        estimates = [found.thrust.both, found.drag.both]
        estimates += [step.time_constant for step in found.steps]
        assert np.isfinite(estimates).all()


def fitted_or_refused(run: BenchData) -> RotorFit | InputError:
    try:
        return fit_rotor(run)
    except InputError as refused:
        return refused
